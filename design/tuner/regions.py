"""The map of the gains, level by level: at once a coarse one, sharper while nobody drags.

Each level halves the distance of the points and keeps those of the level before.  What is drawn is
where the excess over a limit is zero, interpolated between points, so that a coarse map already shows
about where a limit runs.
"""

from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.margins import Margins, margins
from design.synthesis.evaluate import controller, evaluate
from design.synthesis.requirements import ROUNDING, Limits, Problem, excesses
from design.synthesis.tuning import Region

Array = NDArray[np.float64]

LEVELS = (7, 13, 25)
"""Points of a side of the map, level by level."""

SIDE = LEVELS[-1]

NEAR = 1.0
"""Gains that break a linear limit by more than this share of it are not simulated: they are out."""

HIGHEST = 1.0
"""Excess is shown up to this share of a limit either way, so that interpolation meets no infinity."""

PIECE = 14
"""Points of the coarsest level that are evaluated between two looks at the clock."""

FINER = 3
"""Lines are drawn straight within this share of the distance of two points."""

SPECK = 0.06
"""A line shorter than this share of the map's side is a speck between points, and left out."""


def _order() -> tuple[NDArray[np.intp], tuple[int, ...]]:
    """Points of the map, flattened, level after level, and how many belong to each level and those before."""
    points = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    steps = [(SIDE - 1) // (n - 1) for n in LEVELS]
    listed = list(dict.fromkeys(int(p) for step in steps for p in points[::step, ::step].ravel()))
    return np.array(listed, np.intp), tuple(n * n for n in LEVELS)


ORDER, ENDS = _order()


@dataclass(frozen=True)
class Regions:
    """What is known of the map.

    region: the gains it covers, log-spaced, `SIDE` points a side; done: points of `ORDER` that are known;
    excess: by limit, as `design.synthesis.evaluate.Evaluation` has it, (SIDE, SIDE), rows Kp, columns
    Ki, nan where it is not known; cost: the worst IAE [deg s], likewise.
    """

    region: Region
    done: int = 0
    excess: dict[str, Array] = field(default_factory=dict)
    cost: Array = field(default_factory=lambda: np.full((SIDE, SIDE), np.inf))

    @property
    def level(self) -> int:
        """Points of a side of the finest level that is complete; 0 before there is one."""
        return max((n for n, end in zip(LEVELS, ENDS, strict=True) if self.done >= end), default=0)

    @property
    def complete(self) -> bool:
        """Whether there is nothing left to sharpen."""
        return self.done >= ENDS[-1]

    def grid(self, name: str) -> Array:
        """Excess over a limit at the finest complete level, (level, level), within `HIGHEST`; nan where
        the gains were not simulated."""
        step = (SIDE - 1) // (self.level - 1)
        clipped: Array = np.clip(self.excess[name][::step, ::step], -HIGHEST, HIGHEST)
        return clipped

    @property
    def worst(self) -> Array:
        """Excess over the limit that is broken most, (level, level), within `HIGHEST`."""
        found = np.full((self.level, self.level), -HIGHEST)
        for name in self.excess:
            found = np.fmax(found, self.grid(name))
        return found

    @property
    def best(self) -> tuple[float, float] | None:
        """Kp and Ki of the point of least cost that meets every limit, or None where none does."""
        step = (SIDE - 1) // (self.level - 1)
        held = np.where(self.worst <= ROUNDING - 1.0, self.cost[::step, ::step], np.inf)
        i, j = np.unravel_index(int(held.argmin()), held.shape)
        Kp, Ki = gains(self.region)
        return (float(Kp[i * step]), float(Ki[j * step])) if np.isfinite(held[i, j]) else None


def gains(region: Region) -> tuple[Array, Array]:
    """Kp of the map's rows and Ki of its columns, each (SIDE,)."""
    return np.geomspace(*region.Kp, SIDE), np.geomspace(*region.Ki, SIDE)


def first(problem: Problem, region: Region, seconds: float = np.inf) -> Regions:
    """The coarsest level, or what can be had of it in so many seconds of the clock."""
    end = perf_counter() + seconds
    known = Regions(region, 0, {name: np.full((SIDE, SIDE), np.nan) for name in problem.limits.named})
    while not known.level and perf_counter() < end:
        known = sharper(problem, known, min(PIECE, ENDS[0] - known.done))
    return known


def sharper(problem: Problem, known: Regions, points: int) -> Regions:
    """The map with so many points more, or what is left of them."""
    here = ORDER[known.done : known.done + points]
    if not here.size:
        return known
    rows, columns = np.unravel_index(here, (SIDE, SIDE))
    of_rows, of_columns = gains(known.region)
    Kp, Ki = of_rows[rows], of_columns[columns]
    excess = {name: grid.copy() for name, grid in known.excess.items()}
    cost = known.cost.copy()
    linear = linear_excess(problem.limits, margins(list(problem.branches), controller(problem, Kp, Ki)))
    near = np.ones(here.size, bool)
    for name, values in linear.items():
        excess[name][rows, columns] = values
        near &= values <= NEAR
    if near.any():
        at = evaluate(problem, Kp[near], Ki[near])
        for name, values in at.excess.items():
            excess[name][rows[near], columns[near]] = values
        cost[rows[near], columns[near]] = at.cost
    return replace(known, done=known.done + here.size, excess=excess, cost=cost)


def linear_excess(limits: Limits, found: Margins) -> dict[str, Array]:
    """Excess over those limits that need no simulation, as a share of each; by name, shape of the gains."""
    values = found.values
    return excesses(values, {n: v for n, v in limits.named.items() if n in values})


@dataclass(frozen=True)
class Outline:
    """The map as lines in the unit square, x along log Kp, y along log Ki.

    held: rings around the gains that meet every limit, holes included, each (n, 2), to be filled by the
    even-odd rule; limits: by name, the lines along which a limit is just held, each (n, 2).
    """

    held: tuple[Array, ...]
    limits: dict[str, tuple[Array, ...]]


def outline(known: Regions) -> Outline:
    """The lines of a map, between its points by bilinear interpolation of each limit on its own."""
    from contourpy import FillType, LineType, contour_generator

    side = FINER * (known.level - 1) + 1
    at = np.linspace(0.0, 1.0, side)

    def contours(heights: Array) -> Any:
        masked = np.ma.masked_invalid(heights.T)
        return contour_generator(at, at, masked, line_type=LineType.Separate, fill_type=FillType.OuterOffset)

    worst, lines = np.full((side, side), -HIGHEST), {}
    for name in known.excess:
        grid = known.grid(name)
        worst = np.maximum(worst, finer(np.where(np.isnan(grid), HIGHEST, grid)))
        drawn = contours(finer(grid)).lines(ROUNDING - 1.0)
        lines[name] = tuple(line for line in drawn if np.ptp(line, axis=0).max() > SPECK)
    polygons, offsets = contours(worst).filled(-2.0 * HIGHEST, ROUNDING - 1.0)
    pieces = zip(polygons, offsets, strict=True)
    return Outline(tuple(ring for piece, cuts in pieces for ring in np.split(piece, cuts[1:-1])), lines)


def finer(grid: Array) -> Array:
    """A square grid (n, n), bilinear between its points, with `FINER` times as many on a side.

    >>> finer(np.array([[0.0, 3.0], [6.0, 9.0]]))[1].round(9).tolist()
    [2.0, 3.0, 4.0, 5.0]
    """
    from scipy.ndimage import zoom

    found: Array = zoom(grid, (FINER * (len(grid) - 1) + 1) / len(grid), order=1)
    return found
