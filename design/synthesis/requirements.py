"""Hard limits on a PI and the cost that is minimised under them, for many gains at once."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Controller
from design.controllers.pi import PI
from design.evaluation.metrics import Metrics
from design.evaluation.scenarios import Scenario, Spread, stack, tuning_scenarios, unreachable, within_reach
from design.evaluation.sequence import Batch as AdverseBatch
from design.evaluation.sequence import Sequence as Adverse
from design.evaluation.sequence import play, repeated
from design.evaluation.sequence import stack as stack_adverse
from design.evaluation.steps import run
from design.margins import BranchResponse, branch_responses, margins
from plants.effects.regulator.dead_time import DeadTime
from plants.kernel import pytrees
from plants.rig import Rig, built_in_rig
from plants.simulation.disturbance import burdened
from plants.wrist import State, Wrist

Array = NDArray[np.float64]
Cost = Literal["iae", "itae", "settling_time"]
COSTS: dict[str, str] = {"iae": "iae_deg_s", "itae": "itae_deg_s2", "settling_time": "settling_time_s"}
"""Costs to choose from, and the metric that each is."""


_PAPER = built_in_rig().limits


@dataclass(frozen=True)
class Limits:
    """Limits that a tuned PI holds on every scenario and branch; None drops one.

    overshoot_percent: simulated, of the step.  Ms: peak of the sensitivity on
    {transit, line 1, line 2} x {slow, fast}.  delay_margin_s: dead time that may
    come on top; 60 ms, since rigs of this kind show about 50 ms of tube.
    total_variation_V: total variation of the command in one step.  steady_error_percent:
    of the step, what may be left at the end of the run.  Mt: peak of the complementary sensitivity, on the
    same branches as Ms.  settling_time_s: until the step is settled; a run's duration asks that it does so
    at all.  The defaults are those of the built-in rig.
    """

    overshoot_percent: float | None = _PAPER["overshoot_percent"]
    Ms: float | None = _PAPER["Ms"]
    delay_margin_s: float | None = _PAPER["delay_margin_s"]
    total_variation_V: float | None = _PAPER["total_variation_V"]
    steady_error_percent: float | None = _PAPER["steady_error_percent"]
    Mt: float | None = _PAPER["Mt"]
    settling_time_s: float | None = _PAPER["settling_time_s"]

    @classmethod
    def none(cls) -> "Limits":
        """No limit at all."""
        return cls(**dict.fromkeys((f.name for f in fields(cls)), None))

    @classmethod
    def of(cls, rig: Rig) -> "Limits":
        """What a rig's task asks for; what it does not name is not limited."""
        return cls(**{f.name: rig.limits.get(f.name) for f in fields(cls)})

    @property
    def named(self) -> dict[str, float]:
        """The limits that are in force, by name."""
        return {f.name: v for f in fields(self) if (v := getattr(self, f.name)) is not None}


NOMINAL = replace(Limits(), delay_margin_s=None)
"""Limits for a rig without dead time, which no real one is."""

SCREEN = 0.02
"""Excess of a linear limit, as a share, up to which gains are simulated all the same: a search that comes
from outside sees where it is heading."""

ROUNDING = 1.0005
"""A tuned optimum lies on its limit; half a per mille keeps rounding from breaking it."""

LIMIT_UNITS = {
    "overshoot_percent": "%", "Ms": "1", "delay_margin_s": "s", "total_variation_V": "V",
    "steady_error_percent": "%", "command_range": "V", "Mt": "1", "settling_time_s": "s",
}  # fmt: skip


@dataclass(frozen=True)
class Evaluation:
    """What gains of shape (n,) do on a set of scenarios; settings: what the controllers have beside the
    gains, by name, each (n,).

    cost (n,): the worst over the scenarios (and adverse sequences), `cost_at` (n,) where.  values[limit]
    (n,): the worst value of each limited quantity, `values_at` (n,) on which
    scenario or branch.  excess[limit] (n,): how far beyond its limit, as a share
    of the limit; not above 0 where it is held.
    """

    Kp: Array
    Ki: Array
    cost: Array
    cost_at: NDArray[np.intp]
    values: dict[str, Array]
    values_at: dict[str, NDArray[np.intp]]
    excess: dict[str, Array]
    settings: dict[str, Array] = field(default_factory=dict)

    @property
    def worst_excess(self) -> Array:
        """Largest excess over all limits, (n,)."""
        worst = np.full(self.Kp.shape, -1.0)
        for excess in self.excess.values():
            worst = np.maximum(worst, excess)
        return worst

    @property
    def feasible(self) -> NDArray[np.bool_]:
        """Which gains meet every limit, (n,)."""
        return self.worst_excess <= 0.0

    def only(self, n: int) -> "Evaluation":
        """The evaluation of the n-th gains alone, arrays of length 1."""
        one = slice(n, n + 1)
        return Evaluation(
            self.Kp[one], self.Ki[one], self.cost[one], self.cost_at[one],
            {k: v[one] for k, v in self.values.items()},
            {k: v[one] for k, v in self.values_at.items()},
            {k: v[one] for k, v in self.excess.items()},
            {k: v[one] for k, v in self.settings.items()},
        )  # fmt: skip


@dataclass(frozen=True)
class Problem:
    """A plant, the scenarios to be tuned on, the cost and the limits.

    adverse: sequences of references whose last step joins the scenarios in all that is simulated, put on
    the footing of the task's step (`design.evaluation.sequence.PlayedSequence.values`); none by default.
    Of these only steps of the task (`Sequence.of_task`) count for the cost.  branches: where margins are
    judged.  guard: shares of limits that gains must stay below them by.  screened: gains that break a limit
    of the linear loop are not simulated: their cost is infinite and the rest of their values no number.
    """

    wrist: Wrist
    scenarios: tuple[Scenario, ...]
    limits: Limits
    cost: str
    branches: tuple[BranchResponse, ...]
    stacked: tuple[Wrist, State, Array]
    duration: float
    jobs: int | None = None
    set_aside: tuple[Scenario, ...] = ()
    adverse: tuple[Adverse, ...] = ()
    guard: Mapping[str, float] = field(default_factory=dict, hash=False)
    screened: bool = False

    @property
    def held_to(self) -> dict[str, float]:
        """The limits in force, less their guard."""
        return {n: v * (1.0 - self.guard.get(n, 0.0)) for n, v in self.limits.named.items()}

    @cached_property
    def adverse_lanes(self) -> list[tuple[NDArray[np.intp], AdverseBatch]]:
        """The adverse sequences as batches of about the same length, each with the places of its lanes."""
        lasts = np.array([sum(s.holds) for s in self.adverse])
        order = np.argsort(lasts, kind="stable")
        pieces = [p for p in np.split(order, np.flatnonzero(np.diff(lasts[order]) > 1.0) + 1) if p.size]
        return [(p, stack_adverse([self.adverse[i] for i in p])) for p in pieces]

    @classmethod
    def of(
        cls,
        wrist: Wrist,
        scenarios: Sequence[Scenario],
        limits: Limits | None = None,
        cost: str = "iae",
        duration: float | None = None,
        jobs: int | None = None,
    ) -> "Problem":
        """The problem of tuning a wrist; corners that no command can hold are set aside.

        duration [s] of a run, the rig's where not given.
        Raises ValueError for an unknown cost.
        """
        if cost not in COSTS:
            raise ValueError(f"unknown cost {cost!r}; one of {', '.join(COSTS)}")
        kept, aside = within_reach(scenarios)
        return cls(
            wrist, tuple(kept), limits or Limits.of(wrist.rig), cost, tuple(branch_responses(wrist)),
            stack(kept), wrist.rig.task.duration if duration is None else duration, jobs, tuple(aside),
        )  # fmt: skip

    def place(self, limit: str, index: int) -> str:
        """In words, the scenario or branch that an entry of ``values_at`` points to; with ``cost`` as
        the limit, that of ``cost_at``."""
        if limit in ("Ms", "Mt", "delay_margin_s"):
            b = self.branches[index]
            return f"{b.branch}, {b.rate} regulator rate"
        if index < len(self.scenarios):
            return self.scenarios[index].name
        return self.adverse[index - len(self.scenarios)].name


def default_problem(
    wrist: Wrist,
    limits: Limits | None = None,
    cost: str = "iae",
    nominal: bool = False,
    jobs: int | None = None,
    spread: Spread | None = None,
) -> Problem:
    """The problem that ``wrist tune`` solves: all scenarios, or the step from rest of the nominal plant."""
    scenarios = tuning_scenarios(wrist, spread)
    if nominal:
        scenarios = [s for s in scenarios if (s.plant, s.start) == ("nominal", "virgin")]
    return Problem.of(wrist, scenarios, limits, cost, jobs=jobs)


def late_problem(
    wrist: Wrist,
    limits: Limits | None = None,
    cost: str = "iae",
    dead_time: float | None = None,
    duration: float | None = None,
    jobs: int | None = None,
) -> Problem:
    """All scenarios behind a dead time [s], the longest that the rig states if not given, which is in the
    margins too; a plant with a dead time of its own keeps that.

    >>> from plants.wrist import Wrist
    >>> problem = late_problem(Wrist.flexion())
    >>> {float(s.wrist.values["dead-time.delay"]) for s in problem.scenarios}, len(problem.branches)
    ({0.05}, 12)
    """
    late = wrist.rig.uncertainty.dead_time[1] if dead_time is None else dead_time
    if late == 0.0 or any(e.NAME == DeadTime.NAME for e in wrist.effects):
        return default_problem(wrist, limits, cost, jobs=jobs)
    scenarios = [replace(s, wrist=burdened(s.wrist, late, None)) for s in tuning_scenarios(wrist)]
    plain = Problem.of(wrist, scenarios, limits, cost, duration, jobs)
    both = (*branch_responses(wrist), *branch_responses(burdened(wrist, late, None)))
    return replace(plain, branches=both, screened=True)


def rollouts(problem: Problem, Kp: Array, Ki: Array) -> Metrics:
    """Metrics of every scenario under every pair of gains, leaves of shape (gains, scenarios)."""
    return simulated(problem, controller(problem, Kp, Ki), Kp.size)


def simulated(problem: Problem, many: Controller, n: int) -> Metrics:
    """Metrics of every scenario under n controllers of one kind, lanes of one, leaves (n, scenarios)."""
    wrist, state, reference = problem.stacked
    m = len(problem.scenarios)
    lanes = pytrees.like(state, [np.tile(x, n) for x in pytrees.leaves(state)])
    plants = wrist.made_of({k: np.tile(v, n) for k, v in wrist.values.items()})
    judged, _, _ = run(
        plants, _each(many, n, m), np.tile(reference, n), lanes, duration=problem.duration, jobs=problem.jobs
    )
    return judged.reshape(n, m)


def judged(problem: Problem, many: Controller, n: int) -> tuple[Array, dict[str, Array]]:
    """Cost, and what the limits of a run are held against, of n controllers of one kind, lanes of one, on
    every scenario and adverse sequence, each (n, scenarios + sequences)."""
    found = simulated(problem, many, n)
    sizes = np.array([abs(s.reference - s.angle) for s in problem.scenarios])
    values: dict[str, Array] = {
        "overshoot_percent": found.overshoot_percent,
        "total_variation_V": found.total_variation_V,
        "steady_error_percent": 100.0 * found.steady_state_error_deg / sizes,
        "settling_time_s": found.settling_time_s,
    }
    cost = getattr(found, COSTS[problem.cost])
    if problem.adverse:
        more = adverse_values(problem, many, n)
        values = {k: np.hstack([v, more[k]]) for k, v in values.items()}
        of_task = np.array([s.of_task for s in problem.adverse])
        cost = np.hstack([cost, np.where(of_task, more[COSTS[problem.cost]], 0.0)])
    return cost, values


def adverse_values(problem: Problem, many: Controller, n: int) -> dict[str, Array]:
    """What limits and cost are held against on the adverse sequences, each (n, sequences)."""
    found: dict[str, Array] = {}
    # Batches of their own: dead time and load are effects that the scenarios' wrists do not have.
    for places, lanes in problem.adverse_lanes:
        one = play(repeated(lanes, n), _each(many, n, places.size), jobs=problem.jobs, task_band=True)
        for name, v in one.values.items():
            into = found.setdefault(name, np.empty((n, len(problem.adverse))))
            into[:, places] = v.reshape(n, places.size)
    return found


def _each(many: Any, n: int, repeat: int) -> Any:
    """n controllers, lanes of one, each `repeat` times in a row."""
    settings = pytrees.leaves(many)
    return pytrees.like(many, [np.repeat(np.broadcast_to(x, (n,)), repeat) for x in settings])


def controller(problem: Problem, Kp: Any, Ki: Any) -> PI:
    """A PI that knows of the problem's regulator what its declared parameters say."""
    return PI.of(problem.wrist, Kp, Ki)


def evaluate(problem: Problem, Kp: Any, Ki: Any) -> Evaluation:
    """Cost and limits of gains, arrays of one shape (n,)."""
    Kp, Ki = np.atleast_1d(np.asarray(Kp, float)), np.atleast_1d(np.asarray(Ki, float))
    return evaluate_with(problem, controller(problem, Kp, Ki), Kp, Ki)


def evaluate_with(problem: Problem, many: Controller, Kp: Array, Ki: Array) -> Evaluation:
    """Cost and limits of controllers, lanes of one, whose loop has the margins of a PI with gains (n,)."""
    linear = margins(problem.branches, many if isinstance(many, PI) else controller(problem, Kp, Ki))
    values = {"Ms": linear.Ms, "Mt": linear.Mt, "delay_margin_s": linear.delay_margin_s}
    at = {"Ms": linear.Ms_at, "Mt": linear.Mt_at, "delay_margin_s": linear.delay_at}
    excess = excesses(values, {n: v for n, v in problem.held_to.items() if n in values})
    own = {n: np.broadcast_to(getattr(many, n), Kp.shape) for n in getattr(many, "TUNED", ())}
    run_at = np.arange(Kp.size)
    if problem.screened and excess:
        run_at = np.flatnonzero(np.max(list(excess.values()), axis=0) <= SCREEN)
    if run_at.size == Kp.size:
        cost, of_run = judged(problem, many, Kp.size)
    else:
        cost, of_run = _judged_where(problem, many, run_at, Kp.size)
    values |= {n: v.max(axis=1) for n, v in of_run.items()}
    at |= {n: v.argmax(axis=1) for n, v in of_run.items()}
    excess = excesses(values, problem.held_to)
    if run_at.size < Kp.size:
        excess = {n: np.where(np.isnan(v), -1.0, v) for n, v in excess.items()}
    return Evaluation(Kp, Ki, cost.max(axis=1), cost.argmax(axis=1), values, at, excess, own)


def _judged_where(
    problem: Problem, many: Controller, at: NDArray[np.intp], n: int
) -> tuple[Array, dict[str, Array]]:
    """As `judged`, of n controllers of which only some are run; infinite costs and no numbers elsewhere."""
    count = len(problem.scenarios) + len(problem.adverse)
    names = ("overshoot_percent", "total_variation_V", "steady_error_percent", "settling_time_s")
    cost, values = np.full((n, count), np.inf), {name: np.full((n, count), np.nan) for name in names}
    if at.size:
        settings = [np.broadcast_to(x, (n,))[at] for x in pytrees.leaves(many)]
        some, of_run = judged(problem, pytrees.like(many, settings), at.size)
        cost[at] = some
        for name, v in of_run.items():
            values[name][at] = v
    return cost, values


def excesses(values: Mapping[str, Array], limits: Mapping[str, float]) -> dict[str, Array]:
    """How far each value lies beyond its limit, as a share of the limit; not above 0 where it is held."""
    found = {}
    for name, limit in limits.items():
        beyond = limit - values[name] if name == "delay_margin_s" else values[name] - limit
        found[name] = beyond / (limit or 1.0)  # a limit of zero has no share of itself
    return found


def out_of_range(problem: Problem) -> tuple[Scenario, float] | None:
    """The scenario whose reference no command in the range can hold, and by how many volts; or None.

    Infinitely many where an effect keeps the wrist from it, as `design.evaluation.scenarios.hindrance` says.
    """
    known = controller(problem, 0.0, 0.0)
    lack = [unreachable(s, known.low, known.high) for s in problem.scenarios]
    worst = int(np.argmax(lack))
    return (problem.scenarios[worst], lack[worst]) if lack[worst] > 0.0 else None
