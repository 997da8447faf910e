"""Cost and limits of gains under a problem, for many gains at once: every scenario and adverse case."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Controller
from design.controllers.pi import PI
from design.evaluation.cases import Case, repeated, unreachable
from design.evaluation.metrics import Metrics
from design.evaluation.runner import play
from design.margins import margins
from design.synthesis.requirements import COSTS, Problem, excesses
from plants.kernel import pytrees

Array = NDArray[np.float64]


SCREEN = 0.02
"""Excess of a linear limit, as a share, up to which gains are simulated all the same: a search that comes
from outside sees where it is heading."""

ALIKE = 1e-6
"""Relative difference of results within which they are the same but for rounding."""


@dataclass(frozen=True)
class Evaluation:
    """What gains of shape (n,) do on a set of scenarios; settings: what the controllers have beside the
    gains, by name, each (n,).

    cost (n,): the worst over the scenarios (and adverse cases), `cost_at` (n,) where.  values[limit]
    (n,): the worst value of each limited quantity, `values_at` (n,) on which
    scenario or branch.  excess[limit] (n,): how far beyond its limit, as a share
    of the limit; not above 0 where it is held.  unsettled (n,): runs that never settle, 0 of gains that were
    not simulated.
    """

    Kp: Array
    Ki: Array
    cost: Array
    cost_at: NDArray[np.intp]
    values: dict[str, Array]
    values_at: dict[str, NDArray[np.intp]]
    excess: dict[str, Array]
    unsettled: NDArray[np.intp]
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
            self.unsettled[one],
            {k: v[one] for k, v in self.settings.items()},
        )  # fmt: skip


def join(parts: list[Evaluation]) -> Evaluation:
    """Evaluations of pieces of a set of gains, put together."""

    def table(name: str) -> dict[str, Any]:
        return {k: np.concatenate([getattr(p, name)[k] for p in parts]) for k in getattr(parts[0], name)}

    row = {
        n: np.concatenate([getattr(p, n) for p in parts])
        for n in ("Kp", "Ki", "cost", "cost_at", "unsettled")
    }
    return Evaluation(
        **row, values=table("values"), values_at=table("values_at"), excess=table("excess"),
        settings=table("settings"),
    )  # fmt: skip


def best_of(at: Evaluation) -> Evaluation:
    """The gains of least cost among those that hold the limits, else those with the fewest runs that never
    settle, where they are to, and of these those of least excess; gains that were not simulated come last,
    since what they break is not all known."""
    if at.feasible.any():
        return at.only(int(np.argmin(np.where(at.feasible, at.cost, np.inf))))
    finite = np.max([np.where(np.isinf(e), -1.0, e) for e in at.excess.values()], axis=0)
    asked = at.unsettled if "settling_time_s" in at.excess else np.zeros_like(at.unsettled)
    return at.only(int(np.lexsort((at.cost, finite, asked, ~np.isfinite(at.cost)))[0]))


def rollouts(problem: Problem, Kp: Array, Ki: Array) -> Metrics:
    """Metrics of every scenario under every pair of gains, leaves of shape (gains, scenarios)."""
    return simulated(problem, controller(problem, Kp, Ki), Kp.size)


def simulated(problem: Problem, many: Controller, n: int) -> Metrics:
    """Metrics of every scenario under n controllers of one kind, lanes of one, leaves (n, scenarios)."""
    m = len(problem.scenarios)
    return play(repeated(problem.lanes, n), _each(many, n, m), jobs=problem.jobs).metrics.reshape(n, m)


def judged(problem: Problem, many: Controller, n: int) -> tuple[Array, dict[str, Array]]:
    """Cost, and what the limits of a run are held against, of n controllers of one kind, lanes of one, on
    every scenario and adverse case, each (n, scenarios + cases)."""
    found = simulated(problem, many, n)
    sizes = np.array([abs(s.task.reference - s.task.angle) for s in problem.scenarios])
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
    """What limits and cost are held against on the adverse cases, each (n, cases)."""
    found: dict[str, Array] = {}
    # Batches of their own: dead time and load are effects that the scenarios' wrists do not have.
    for places, lanes in problem.adverse_lanes:
        one = play(repeated(lanes, n), _each(many, n, places.size), jobs=problem.jobs)
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
    """Cost and limits of controllers, lanes of one, with gains (n,); of one that says which PI closes its
    loop (`pi`), the margins are those of that PI."""
    law: Any = many
    linear = margins(problem.branches, getattr(law, "pi", law))
    values, at = linear.values, linear.at
    own = {n: np.broadcast_to(getattr(many, n), Kp.shape) for n in getattr(many, "TUNED", ())}
    cost, of_run, excess = screened(problem, many, values, problem.held_to)
    values |= {n: v.max(axis=1) for n, v in of_run.items()}
    at |= {n: largest_at(v) for n, v in of_run.items()}
    unsettled = np.isinf(of_run["settling_time_s"]).sum(axis=1)
    return Evaluation(Kp, Ki, cost.max(axis=1), largest_at(cost), values, at, excess, unsettled, own)


def largest_at(values: Array) -> NDArray[np.intp]:
    """Place (n,) of the largest of each row of values (n, cases), the first of those that are as large: by
    the symmetry of a rig two cases are alike, and rounding would choose.

    >>> largest_at(np.array([[1.0, 2.0, 2.0 + 1e-12]]))
    array([1])
    """
    largest = values.max(axis=1, keepdims=True)
    found: NDArray[np.intp] = np.isclose(values, largest, ALIKE, 0.0, equal_nan=True).argmax(axis=1)
    return found


def screened(
    problem: Problem, many: Any, linear: Mapping[str, Array], limits: Mapping[str, float]
) -> tuple[Array, dict[str, Array], dict[str, Array]]:
    """Cost and values of runs as of `judged`, and the excess over limits of these and of the linear loop's
    values (n,).

    Of a screened problem, controllers that break a limit of the linear loop are not simulated: infinite
    costs, no numbers, and no excess but that of the loop.
    """
    n = next(iter(linear.values())).size
    excess = excesses(linear, {name: v for name, v in limits.items() if name in linear})
    missed = np.zeros(n, bool)
    if problem.screened and excess:
        missed = np.max(list(excess.values()), axis=0) > SCREEN
    if missed.any():
        cost, of_run = _judged_where(problem, many, np.flatnonzero(~missed), n)
    else:
        cost, of_run = judged(problem, many, n)
    worst = {name: v.max(axis=1) for name, v in of_run.items()}
    runs = excesses(worst, {name: v for name, v in limits.items() if name in worst})
    excess |= {name: np.where(missed, -1.0, v) for name, v in runs.items()}
    return cost, of_run, {k: excess[k] for k in limits}


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


def out_of_range(problem: Problem) -> tuple[Case, float] | None:
    """The scenario whose reference no command in the range can hold, and by how many volts; or None.

    Infinitely many where an effect keeps the wrist from it, as `design.evaluation.cases.hindrance` says.
    """
    known = controller(problem, 0.0, 0.0)
    lack = [unreachable(s, known.low, known.high) for s in problem.scenarios]
    worst = int(np.argmax(lack))
    return (problem.scenarios[worst], lack[worst]) if lack[worst] > 0.0 else None
