"""Names beside the curves of a panel, where a legend of a dozen dash patterns cannot be read."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import isotonic_regression

from reports.shared.figures.style import GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
SIZE = 7.6
"""Letters of the names [pt]."""

ALONG, ACROSS, UP = 40, 14, 16
"""Points of a curve that a name may point at, and places of the panel where it may stand."""


def label_curves(axes: "Axes", curves: Mapping[str, tuple[Array, Array]], named: Mapping[str, str]) -> None:
    """Write the names of some curves into their panel, each joined to its curve by a thin line.

    curves: x and y of every curve that is drawn, in data; named: those to be named, with their names.  A name
    stands where no curve passes, near a point at which its curve is apart from the others.
    """
    axes.figure.draw_without_rendering()  # type: ignore[union-attr]  # the panel's size, for that of the letters
    box = axes.get_window_extent()
    points = 72.0 / axes.figure.dpi
    wide, high = box.width * points, box.height * points
    left, right = axes.get_xlim()
    bottom, top = axes.get_ylim()
    at = np.linspace(0.0, 1.0, 400)
    lines = {
        n: (np.interp(left + at * (right - left), x, y, left=np.nan, right=np.nan) - bottom) / (top - bottom)
        for n, (x, y) in curves.items()
    }
    taken: list[Array] = []
    lines_to: list[Array] = []
    for name, words in named.items():
        others = np.array([v for n, v in lines.items() if n != name])
        size = np.array([0.58 * SIZE * len(words) / wide, 1.25 * SIZE / high])
        every = np.array(list(lines.values()))
        place, point = _best(at, lines[name], others, every, size, [*taken, *lines_to])
        taken.append(np.concatenate([place, place + size]))
        # No later name stands on the line to this one: its points are boxes without a size.
        lines_to += [np.concatenate([p, p]) for p in _between(point, place + 0.5 * size)]
        x, y = (left + point[0] * (right - left), bottom + point[1] * (top - bottom))
        axes.annotate(
            words, (x, y), tuple(place + 0.5 * size), textcoords="axes fraction", fontsize=SIZE, ha="center",
            va="center", color="#333333", zorder=6,
            arrowprops={"arrowstyle": "-", "color": GREY, "linewidth": 0.5, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip


def label_ends(axes: "Axes", ends: Mapping[str, float]) -> None:
    """Write the names of curves to the right of their panel, at the heights, given in data, where they end:
    one above the other where these are close, each joined to its end by a thin line."""
    axes.figure.draw_without_rendering()  # type: ignore[union-attr]  # the panel's size
    high = axes.get_window_extent().height * 72.0 / axes.figure.dpi
    bottom, top = axes.get_ylim()
    names = sorted(ends, key=lambda n: ends[n])
    true = (np.array([ends[n] for n in names]) - bottom) / (top - bottom)
    apart = 1.3 * SIZE / high * np.arange(len(names))
    near = isotonic_regression(true - apart).x  # least squares of the distances, none below the one before
    places = np.clip(near, 0.0, 1.0 - apart[-1]) + apart
    for name, y, place in zip(names, true, places, strict=True):
        axes.annotate(
            name, (1.0, y), (1.06, place), xycoords="axes fraction", textcoords="axes fraction",
            fontsize=SIZE, va="center", color="#333333", annotation_clip=False,
            arrowprops={
                "arrowstyle": "-", "color": GREY, "linewidth": 0.5, "shrinkA": 0, "shrinkB": 0,
                "relpos": (0.0, 0.5),
            },
        )  # fmt: skip


def _best(
    at: Array, own: Array, others: Array, every: Array, size: Array, taken: list[Array]
) -> tuple[Array, Array]:
    """Where a name's lower left corner goes, and the point of its curve, all as shares of the panel."""
    step = np.linspace(0.02, 0.98, ALONG)
    heights = np.interp(step, at, own)
    seen = np.isfinite(heights) & (heights > 0.0) & (heights < 1.0)
    ends = np.stack([step[seen], heights[seen]], axis=1) if seen.any() else np.array([[0.5, 0.5]])
    corners = np.array(
        [
            (x, y)
            for x in np.linspace(0.01, 0.99 - size[0], ACROSS)
            for y in np.linspace(0.01, 0.97 - size[1], UP)
        ]
    )
    cost = np.array([_hits(at, every, c, size) + _over(c, size, taken) for c in corners])
    gap = np.array([np.nanmin(np.abs(_at(at, others, x) - y), initial=1.0) for x, y in ends])
    middles = corners + 0.5 * size
    best, found = np.inf, (corners[0], ends[0])
    for end, lonely in zip(ends, 0.12 / (gap + 0.02), strict=True):
        reach = np.hypot(*(middles - end).T)
        total = cost + reach + lonely
        for i in np.argsort(total)[:6]:
            value = total[i] + 0.15 * _crossed(at, others, end, middles[i])
            value += sum(5.0 * _through(box, end, middles[i]) for box in taken)
            if value < best:
                best, found = value, (corners[i], end)
    return found


def _at(at: Array, lines: Array, x: Any) -> Array:
    return np.array([np.interp(x, at, line) for line in lines]) if len(lines) else np.full((1,), np.nan)


def _hits(at: Array, lines: Array, corner: Array, size: Array) -> float:
    """How many curves pass through a name."""
    under = lines[:, (at >= corner[0] - 0.01) & (at <= corner[0] + size[0] + 0.01)]
    inside = (under > corner[1] - 0.01) & (under < corner[1] + size[1] + 0.01)
    return 5.0 * float(inside.any(axis=1).sum())


def _over(corner: Array, size: Array, taken: list[Array]) -> float:
    """Whether a name would lie over another."""
    return 1e3 * sum(
        bool((corner < t[2:] + 0.01).all() and (corner + size > t[:2] - 0.01).all()) for t in taken
    )


def _between(end: Array, middle: Array) -> Array:
    """Points of the line from a curve to the middle of a name, (n, 2)."""
    return np.asarray(end + np.linspace(0.05, 1.0, 12)[:, None] * (middle - end), float)


def _through(box: Array, end: Array, middle: Array) -> bool:
    """Whether the line from a curve to a name passes through another name."""
    way = _between(end, middle)
    return bool(((way > box[:2] - 0.005) & (way < box[2:] + 0.005)).all(axis=1).any())


def _crossed(at: Array, others: Array, end: Array, middle: Array) -> int:
    """How many curves the line from a name to its curve crosses."""
    x, y = _between(end, middle).T
    if not len(others):
        return 0
    above = _at(at, others, x) > y
    return int((above != above[:, :1]).any(axis=1).sum())
