"""Tuning the PI: the least worst cost under hard limits, with evidence that it is the global one.

A dense map of the two gains comes first; it shows every valley.  Then a local
search (Nelder-Mead, restarted once, since it stalls on the edge of a limit)
runs from the lowest cells that are valleys of their own, and three ever finer
maps are laid around the best of them.  Nothing here needs a derivative: the
worst of many scenarios has none where the worst one changes.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.cluster import each
from design.synthesis.evaluate import Evaluation, best_of, evaluate, join
from design.synthesis.judged import active_limit, merit
from design.synthesis.requirements import Problem
from design.synthesis.structure import with_gains
from plants.hysteresis import with_values
from plants.parameters.files import built_in
from plants.wrist import Wrist

Array = NDArray[np.float64]
ALIKE = 0.4
"""Decades of the slope within which wrists are searched for gains in one and the same region."""


@dataclass(frozen=True)
class Region:
    """Gains that are searched, and how finely the map covers them (log-spaced)."""

    Kp: tuple[float, float] = (0.3, 40.0)
    Ki: tuple[float, float] = (0.3, 200.0)
    points: int = 40

    @classmethod
    def of(cls, wrist: Wrist, points: int = 40) -> "Region":
        """The region for a wrist: that of the built-in one, or as much higher, in half decades, as the lines
        of the wrist are flatter, since a loop answers to gain times slope.

        >>> Region.of(Wrist.flexion()) == Region()
        True
        >>> flat = Wrist.flexion().with_values(a1=0.036, a2=0.036, s=0.008)
        >>> Region.of(flat).Kp
        (3.0, 400.0)
        """
        usual = max(with_values(built_in("flexion").values).steepness)
        decades = np.log10(usual / float(np.max(wrist.hysteresis.steepness)))
        higher = 10.0 ** (np.round(2.0 * decades) / 2.0) if abs(decades) > ALIKE else 1.0
        Kp, Ki = ((float(low * higher), float(high * higher)) for low, high in (cls.Kp, cls.Ki))
        return cls(Kp, Ki, points)

    @property
    def grid(self) -> tuple[Array, Array]:
        """Kp and Ki of the map's rows and columns, each (points,)."""
        return np.geomspace(*self.Kp, self.points), np.geomspace(*self.Ki, self.points)

    @property
    def resolution(self) -> tuple[float, float]:
        """Ratio of neighbouring gains of the map, for Kp and Ki."""
        return (
            (self.Kp[1] / self.Kp[0]) ** (1 / (self.points - 1)),
            (self.Ki[1] / self.Ki[0]) ** (1 / (self.points - 1)),
        )


@dataclass(frozen=True)
class LocalSearch:
    """One local search: gains it started from and ended at, cost there, whether limits hold."""

    start: tuple[float, float]
    end: tuple[float, float]
    cost: float
    feasible: bool
    evaluations: int


@dataclass(frozen=True)
class Tuning:
    """Result of a tuning.

    Kp, Ki: the gains, of least excess where no gains hold the limits.
    at: their evaluation, arrays of length 1.  map: the evaluation of the whole
    map, rows Kp, columns Ki, flattened.  searches: the local searches.  given: the gains were found
    elsewhere and are only shown on the problem.
    """

    problem: Problem
    region: Region
    at: Evaluation
    map: Evaluation
    searches: tuple[LocalSearch, ...]
    given: bool = False

    @property
    def Kp(self) -> float:
        """Proportional gain [kPa/deg]."""
        return float(self.at.Kp[0])

    @property
    def Ki(self) -> float:
        """Integral gain [kPa/(deg s)]."""
        return float(self.at.Ki[0])

    @property
    def settings(self) -> dict[str, float]:
        """Settings beside the gains, by name: b [1] and Tf [s] of a PI with two degrees of freedom, speed
        [1/s] and dead_time [s] of a feedforward; none of a plain PI."""
        return {n: float(v[0]) for n, v in self.at.settings.items()}

    @property
    def gains(self) -> dict[str, float]:
        """Gains and settings by name; of a plain PI with the weight and the filter that it has."""
        return {"Kp": self.Kp, "Ki": self.Ki, **(self.settings or {"b": 1.0, "Tf": 0.0})}

    @property
    def controller(self) -> Any:
        """The controller with the gains."""
        return with_gains(self.problem.wrist, self.gains)

    @property
    def feasible(self) -> bool:
        """Whether the gains meet every limit."""
        return bool(self.at.feasible[0])

    @property
    def active(self) -> str | None:
        """The limit that the gains run into first, or None for an optimum inside all limits."""
        return active_limit(self.at)

    @property
    def spread(self) -> float:
        """By how much the best local searches differ: the share of the cost by which the
        second best feasible one lies above the best; infinite where there is only one."""
        costs = sorted(s.cost for s in self.searches if s.feasible)
        return costs[1] / costs[0] - 1.0 if len(costs) > 1 else float("inf")

    @property
    def on_edge(self) -> bool:
        """Whether the optimum lies on the edge of the searched region, so that it may go on outside."""
        return any(
            min(gain / low, high / gain) < 1.02
            for gain, (low, high) in ((self.Kp, self.region.Kp), (self.Ki, self.region.Ki))
        )


def valleys(values: Array, count: int) -> list[tuple[int, int]]:
    """Cells of a map, shape (n, m), that are no higher than their eight neighbours, lowest first.

    >>> valleys(np.array([[3., 9., 9.], [9., 9., 9.], [9., 9., 1.]]), 5)
    [(2, 2), (0, 0)]
    """
    n, m = values.shape

    def neighbours(edge: float) -> list[Array]:
        around = np.pad(values, 1, constant_values=edge)
        return [around[1 + i : 1 + i + n, 1 + j : 1 + j + m] for i in (-1, 0, 1) for j in (-1, 0, 1)]

    low = (values <= np.min(neighbours(np.inf), axis=0)) & (values < np.max(neighbours(-np.inf), axis=0))
    cells = sorted(zip(*np.nonzero(low), strict=True), key=lambda cell: float(values[cell]))
    return [(int(i), int(j)) for i, j in cells[:count]]


def local_search(problem: Problem, region: Region, start: tuple[float, float]) -> LocalSearch:
    """Nelder-Mead in the logarithms of the gains, within the region, restarted once."""
    from scipy.optimize import minimize

    best: tuple[float, Any, Evaluation] | None = None
    low, high = np.log([region.Kp[0], region.Ki[0]]), np.log([region.Kp[1], region.Ki[1]])
    calls = 0

    def height(x: Array) -> float:
        nonlocal best, calls
        calls += 1
        inside = np.clip(x, low, high)
        at = evaluate(problem, np.exp(inside[:1]), np.exp(inside[1:]))
        value = float(merit(at)[0])
        if best is None or (not bool(at.feasible[0]), value) < (not bool(best[2].feasible[0]), best[0]):
            best = (value, inside, at)
        return value + float(np.abs(x - inside).sum()) * value

    x = np.log(start)
    for size in (1.0, 0.3):
        steps = np.diag(np.log(region.resolution)) * size
        options = {"initial_simplex": np.vstack([x, x + steps]), "xatol": 1e-4, "fatol": 1e-5, "maxfev": 70}
        x = minimize(height, x, method="Nelder-Mead", options=options).x
    assert best is not None
    _, _, at = best
    end = (float(at.Kp[0]), float(at.Ki[0]))
    return LocalSearch(start, end, float(at.cost[0]), bool(at.feasible[0]), calls)


def tune(
    problem: Problem,
    region: Region | None = None,
    starts: int = 5,
    seed: int = 0,
    progress: Callable[[str, float], None] | None = None,
    scheduler: str | None = None,
) -> Tuning:
    """Gains of least worst cost under the problem's limits.

    `starts` is the number of local searches, from the minima of the map and, where these are fewer, from
    cells of it drawn with `seed`; `progress`, if given, is told the
    stage and the share that is done; `scheduler` is the address of a Dask cluster that the
    map, cut into pieces that do not depend on it, is computed on, to the same bits.  The result
    says whether the limits are held (`Tuning.feasible`); it is for the caller to say no.
    """
    region, tell = region or Region.of(problem.wrist), progress or (lambda stage, share: None)
    rows, columns = region.grid
    Kp, Ki = (g.ravel() for g in np.meshgrid(rows, columns, indexing="ij"))
    pieces = np.array_split(np.arange(Kp.size), max(1, Kp.size // 200))
    tell("map", 0.0)
    # On a cluster one thread a piece: its workers have threads of their own.
    work = partial(_piece, problem if scheduler is None else replace(problem, jobs=1))
    gains = [(Kp[piece], Ki[piece]) for piece in pieces]
    whole = join(each(work, gains, scheduler, lambda share: tell("map", share)))

    begins = _begins(whole, rows, columns, starts, seed)
    searches = []
    for number, begin in enumerate(begins):
        tell("local search", number / len(begins))
        searches.append(local_search(problem, region, begin))
    at = best_of(join([best_of(whole), evaluate(problem, *np.array([s.end for s in searches]).T)]))
    for zoom in (1.0, 0.3, 0.1):
        tell("fine map", 1.0 - zoom)
        at = best_of(join([at, evaluate(problem, *_around(at, region, zoom))]))
    tell("done", 1.0)
    return Tuning(problem, region, at, whole, tuple(searches))


def _piece(problem: Problem, gains: tuple[Array, Array]) -> Evaluation:
    return evaluate(problem, *gains)


def _begins(
    whole: Evaluation, rows: Array, columns: Array, count: int, seed: int
) -> list[tuple[float, float]]:
    """Gains that local searches start from: valleys of the map, then cells drawn at random; of
    those that hold the limits, where there are any."""
    cells = valleys(merit(whole).reshape(rows.size, columns.size), rows.size * columns.size)
    usable = whole.feasible if whole.feasible.any() else np.ones(whole.Kp.size, bool)
    indices = [i * columns.size + j for i, j in cells if usable[i * columns.size + j]]
    drawn = np.random.default_rng(seed).permutation(np.flatnonzero(usable))
    chosen = list(dict.fromkeys([*indices, *map(int, drawn)]))[:count]
    return [(float(whole.Kp[n]), float(whole.Ki[n])) for n in chosen]


def _around(at: Evaluation, region: Region, zoom: float) -> tuple[Array, Array]:
    """Gains of a fine map that reaches `zoom` cells of the region's map to each side, flattened."""
    points = max(5, region.points // 2)
    centres = (float(at.Kp[0]), float(at.Ki[0]))
    sides = [
        np.clip(centre * ratio ** np.linspace(-zoom, zoom, points), *bounds)
        for centre, ratio, bounds in zip(centres, region.resolution, (region.Kp, region.Ki), strict=True)
    ]
    rows, columns = np.meshgrid(*sides, indexing="ij")
    return rows.ravel(), columns.ravel()
