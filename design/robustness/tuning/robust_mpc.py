"""An MPC tuned under the whole requirement, by the loop that tunes a PI.

Of the weights of the robust setting (`design.mpc.problem.robust`) the one that trades overshoot for speed is
searched: what a change of the angle from one period to the next costs.  A run takes a hundred times as long
as a PI's, so pool, samples and the search for the worst case are smaller.  Ms, Mt and the delay margin belong
to a linear loop, which an MPC does not have: of these nothing is judged.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from design.evaluation.runner import play
from design.robustness.requirement import LINEAR, Requirement
from design.robustness.tuning.robust_tuning import GUARD, RobustTuning, RoundEffort, grow
from design.synthesis.judged import JudgedDesign
from design.synthesis.requirements import COSTS, Problem, excesses
from design.synthesis.structure import weighted_mpc
from design.synthesis.tuning import active_limit
from plants.simulation.periodic import Periodic

Array = NDArray[np.float64]
Tell = Callable[[str, float], None]

SWINGS = (25.0, 32.0, 40.0, 50.0, 63.0, 80.0, 100.0, 125.0, 160.0, 200.0, 250.0)
"""Weights of the swing [1/deg^2] that are tried, mild to strict."""

BEGIN = 100.0
"""Where the search begins."""

MOVE = 100.0
"""Weight of a move [1/V^2]."""

EFFORT = RoundEffort(pool=256, search=2000, fresh=256)
"""What a round spends."""


@dataclass(frozen=True)
class RobustMPC:
    """The design: weight of the swing [1/deg^2], what the MPC does with it on a problem (arrays of length 1),
    and how many weights were tried."""

    problem: Problem
    swing: float
    at: JudgedDesign
    tried: int

    @property
    def gains(self) -> dict[str, float]:
        """Its weights by name."""
        return {"swing": self.swing, "move": MOVE}

    @property
    def controller(self) -> Periodic:
        """The controller."""
        made: Periodic = weighted_mpc(self.problem.wrist, **self.gains)
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
    return grow(requirement, problem, design_mpc, seed, rounds, jobs, progress, effort)


def design_mpc(problem: Problem, known: RobustMPC | None = None) -> RobustMPC:
    """The least weight of the swing that meets every limit of a run, else the one that comes nearest: down
    from the one that is known as long as limits hold, else up until they do.

    The cost rises with the weight, and the overshoot falls.
    """
    place = SWINGS.index(BEGIN if known is None else known.swing)
    judged: dict[int, JudgedDesign] = {}

    def at(i: int) -> JudgedDesign:
        if i not in judged:
            judged[i] = judge(problem, weighted_mpc(problem.wrist, SWINGS[i], MOVE))
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
    return RobustMPC(problem, SWINGS[place], at(place), len(judged))


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
