"""An MPC tuned under the whole requirement, by the loop that tunes a PI.

Two weights of the robust setting (`design.mpc.problem.robust`) are searched.  What a change of the command
from one period to the next costs is the least that keeps the limits of the linear loop at rest on the nominal
plant, behind the longest dead time too (`design.mpc.margins_at_rest`); what a change of the angle costs
trades overshoot for speed.  The model has the longest dead time that is asked for, in whole periods: with
less the loop behind it has less margin, and without any it still has enough.

A run takes a hundred times as long as a PI's, so pool, samples and the search for the worst case are smaller;
the corners of the box are judged once, of the weights that are found (`design.studies.designs`).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from design.evaluation.runner import play
from design.margins import LINEAR
from design.mpc.margins_at_rest import Replaceable, margins_at_rest
from design.mpc.problem import robust
from design.robustness.requirement import Requirement
from design.robustness.tuning.robust_tuning import GUARD, RobustTuning, RoundEffort, grow
from design.synthesis.judged import JudgedDesign, active_limit
from design.synthesis.requirements import COSTS, Problem, excesses
from design.synthesis.structure import weighted_mpc
from plants.effects.effect import dead_time_of
from plants.simulation.periodic import Periodic

Array = NDArray[np.float64]
Tell = Callable[[str, float], None]

SWINGS = (16.0, 20.0, 25.0, 32.0, 40.0, 50.0, 63.0, 80.0, 100.0, 125.0, 160.0, 200.0, 250.0)
"""Weights of the swing [1/deg^2] that are tried, mild to strict."""

BEGIN = 63.0
"""Where the search begins."""

MOVES = (50.0, 70.0, 100.0, 150.0, 200.0, 300.0, 400.0, 500.0, 700.0, 1000.0, 1400.0, 2000.0)
"""Weights of a move [1/V^2] that are tried, bold to mild; less lets the sensor's noise through."""

RESERVE = 0.02
"""Share of the limits of the linear loop that the nominal plant leaves to the corners of the box."""

EFFORT = RoundEffort(pool=256, search=2000, fresh=256)
"""What a round spends."""


@dataclass(frozen=True)
class RobustMPC:
    """The design: weights of the swing [1/deg^2] and of a move [1/V^2], periods of dead time in the model,
    what the MPC does with them on a problem (arrays of length 1), and how many of the former were tried."""

    problem: Problem
    swing: float
    move: float
    delay: int
    at: JudgedDesign
    tried: int

    @property
    def gains(self) -> dict[str, float]:
        """Its weights by name."""
        return {"swing": self.swing, "move": self.move, "delay": float(self.delay)}

    @property
    def controller(self) -> Replaceable:
        """The controller."""
        made: Replaceable = weighted_mpc(self.problem.wrist, **self.gains)
        return made

    @property
    def feasible(self) -> bool:
        """Whether it meets every limit of a run."""
        return bool(self.at.worst_excess[0] <= 0.0)

    @property
    def active(self) -> str | None:
        """The limit that it runs into first, or None for an optimum inside all limits."""
        return active_limit(self.at)


def tune_mpc(
    requirement: Requirement,
    seed: int = 0,
    rounds: int = 8,
    jobs: int | None = None,
    progress: Tell | None = None,
    effort: RoundEffort = EFFORT,
) -> RobustTuning[RobustMPC]:
    """Weights of an MPC of least worst cost that hold the limits of runs, as far as pool, search and fresh
    samples can tell; arguments as of `design.robustness.tuning.robust_tuning.grow`.

    Raises InputError where its solver is not installed, or a plant has no MPC.
    """
    problem = requirement.problem(dict(GUARD), jobs)
    delay = longest_delay(requirement)

    @cache
    def move_of(swing: float) -> float:
        return least_move(requirement, swing, delay)

    def design(problem: Problem, known: RobustMPC | None) -> RobustMPC:
        return design_mpc(problem, move_of, delay, known)

    return grow(requirement, problem, design, seed, rounds, jobs, progress, effort)


def longest_delay(requirement: Requirement) -> int:
    """The longest dead time of a requirement, that of its plant included, in whole periods of the MPC."""
    wrist = requirement.wrist
    longest = requirement.space.dead_time + dead_time_of(wrist.effects)
    return int(longest / robust(replace(wrist, effects=())).period + 1e-9)


def least_move(requirement: Requirement, swing: float, delay: int) -> float:
    """The least weight of a move [1/V^2] with which the loop at rest keeps its limits, less a reserve, on the
    nominal plant; the largest where none does."""
    held = {n: v for n, v in requirement.limits.named.items() if n in LINEAR}
    for move in MOVES if held else MOVES[:1]:
        controller = weighted_mpc(requirement.wrist, swing, move, delay)
        late = (0.0, requirement.space.dead_time)
        found = margins_at_rest(controller, [requirement.wrist], late, requirement.box.weight)
        values = {n: np.array([getattr(found, n)]) for n in held}
        if all(e[0] <= -RESERVE for e in excesses(values, held).values()):
            return move
    return MOVES[-1]


def design_mpc(
    problem: Problem, move_of: Callable[[float], float], delay: int, known: RobustMPC | None = None
) -> RobustMPC:
    """The least weight of the swing that meets every limit of a run, else the one that comes nearest: down
    from the one that is known as long as limits hold, else up until they do; move_of: weight of a move of
    one of the swing.

    The cost rises with the weight, and the overshoot falls.
    """
    place = SWINGS.index(BEGIN if known is None else known.swing)
    judged: dict[int, JudgedDesign] = {}

    def at(i: int) -> JudgedDesign:
        if i not in judged:
            judged[i] = judge(problem, weighted_mpc(problem.wrist, SWINGS[i], move_of(SWINGS[i]), delay))
        return judged[i]

    def held(i: int) -> bool:
        return bool(at(i).worst_excess[0] <= 0.0)

    if held(place):
        # What a set of cases has refused is not tried again on a larger one.
        while known is None and place > 0 and held(place - 1):
            place -= 1
    else:
        above = range(place + 1, len(SWINGS))
        place = next((i for i in above if held(i)), min(judged, key=lambda i: float(at(i).merit[0])))
    return RobustMPC(problem, SWINGS[place], move_of(SWINGS[place]), delay, at(place), len(judged))


def judge(problem: Problem, controller: Periodic) -> JudgedDesign:
    """Cost and limits of runs of a controller on every scenario and adverse case of a problem."""
    count = len(problem.scenarios)
    counts = np.array([c.of_task for c in (*problem.scenarios, *problem.adverse)])
    pieces = [(np.arange(count), problem.lanes)]
    if problem.adverse:
        pieces += [(count + places, lanes) for places, lanes in problem.adverse_lanes]
    found: dict[str, Array] = {}
    for places, lanes in pieces:
        values = play(lanes, controller, jobs=problem.jobs).values
        for name, v in values.items():
            found.setdefault(name, np.empty(counts.size))[places] = v
    limits = {n: v for n, v in problem.held_to.items() if n not in LINEAR}
    worst = {n: np.array([found[n].max()]) for n in limits}
    cost = np.where(counts, found[COSTS[problem.cost]], 0.0).max()
    return JudgedDesign(np.array([cost]), worst, excesses(worst, limits))
