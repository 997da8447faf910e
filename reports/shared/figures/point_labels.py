"""Names beside the points of a panel, clear of marks, lines and each other."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from reports.shared.figures.direct_labels import SIZE
from reports.shared.figures.style import GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

MARK, ROOM = 5.0, np.array([1.5, 0.3])
"""Half the side of the square that a mark takes, and the room beside and above a name [pt]."""

ROUNDS = 4
"""How often each name is placed again with all others in place."""

OVER, STRUCK, CROSSED = 1000.0, 200.0, 50.0
"""Costs, in points of distance: a name over a name or mark; a line through a name, or a leader through a name
or mark; a leader across a line."""


def label_points(axes: "Axes", points: Mapping[str, tuple[float, float]]) -> None:
    """Write the names of points, given in data, beside them: where no mark, no line and no other name is.

    A name that does not touch its mark is joined to it by a thin line, its leader.
    """
    axes.figure.draw_without_rendering()  # type: ignore[union-attr]  # the panel's size, for that of the letters
    to_points = 72.0 / axes.figure.dpi
    corner, size = (np.array(v) * to_points for v in (axes.bbox.p0, axes.bbox.size))
    at = {n: axes.transData.transform(place) * to_points - corner for n, place in points.items()}
    lines = _segments(axes, to_points, corner)
    names: dict[str, Array] = {}
    for _ in range(ROUNDS):
        for name, point in at.items():
            others = [b for n, b in names.items() if n != name]
            taken = np.array(others + [_around(p) for n, p in at.items() if n != name]).reshape(-1, 4)
            leaders = [_leader(at[n], b) for n, b in names.items() if n != name]
            names[name] = _best(point, name, size, taken, lines, np.array(leaders).reshape(-1, 4))
    for name, b in names.items():
        leader = _leader(at[name], b)
        far = float(np.hypot(*(leader[2:] - leader[:2]))) > 2.0 * MARK
        axes.annotate(
            name, points[name], tuple(0.5 * (b[:2] + b[2:]) / size), textcoords="axes fraction",
            fontsize=SIZE, ha="center", va="center", color="#333333", zorder=6,
        )  # fmt: skip
        if far:
            axes.annotate(
                "", points[name], tuple(leader[2:] / size), textcoords="axes fraction", zorder=3,
                arrowprops={"arrowstyle": "-", "color": GREY, "linewidth": 0.5, "shrinkA": 0, "shrinkB": 0},
            )  # fmt: skip


def _best(point: Array, name: str, panel: Array, taken: Array, lines: Array, leaders: Array) -> Array:
    """The box (left, bottom, right, top) [pt] in which a name costs least."""
    size = np.array([0.58 * SIZE * len(name), 1.25 * SIZE])
    places = np.array([p for p in _places(point, size) if (p[:2] >= 0.0).all() and (p[2:] <= panel).all()])
    if not len(places):
        places = np.array(_places(point, size))

    def cost(box: Array) -> float:
        roomy = box + np.concatenate([-ROOM, ROOM])
        over = ((roomy[:2] < taken[:, 2:]) & (roomy[2:] > taken[:, :2])).all(axis=1).sum()
        leader = _leader(point, box)
        far = float(np.hypot(*(leader[2:] - leader[:2])))
        askew = float(np.abs(0.5 * (box[:2] + box[2:]) - point).min())
        struck = _met(lines, roomy).sum() + _met(leaders, roomy).sum()
        crossed = 0.0
        if far > 2.0 * MARK:
            struck += sum(bool(_met(leader[None], t)[0]) for t in taken)
            crossed = _cross(leader, lines) + _cross(leader, leaders)
        return float(OVER * over + STRUCK * struck + CROSSED * crossed + far + 0.5 * askew)

    return np.array(places[int(np.argmin([cost(b) for b in places]))])


def _places(point: Array, size: Array) -> list[Array]:
    """Boxes around a point: beside it, above and below it, ever further away."""
    beside, high = MARK + 3.0, size[1]
    found = []
    for up in 0.5 * high * np.arange(-12, 13):
        for right in (beside, 3.0 * beside, 6.0 * beside):
            for left in (point[0] + right, point[0] - right - size[0]):
                found.append(np.array([left, point[1] + up - 0.5 * high]))
        if abs(up) >= MARK + 0.5 * high:
            found.append(np.array([point[0] - 0.5 * size[0], point[1] + up - 0.5 * high]))
    return [np.concatenate([p, p + size]) for p in found]


def _leader(point: Array, box: Array) -> Array:
    """The line (x, y, x, y) [pt] from a point to the nearest place of a box."""
    return np.concatenate([point, np.clip(point, box[:2], box[2:])])


def _around(point: Array) -> Array:
    return np.concatenate([point - MARK, point + MARK])


def _segments(axes: "Axes", to_points: float, corner: Array) -> Array:
    """The straight parts (x, y, x, y) [pt] of all lines of a panel, as few as draw the same."""
    from matplotlib.path import Path

    found = [np.empty((0, 4))]
    for line in axes.lines:
        drawn = line.get_transform().transform_path(line.get_path()).cleaned(simplify=True)
        corners = np.asarray(drawn.vertices)[np.asarray(drawn.codes) != Path.STOP] * to_points - corner
        found.append(np.concatenate([corners[:-1], corners[1:]], axis=1))
    return np.concatenate(found)


def _met(segments: Array, box: Array) -> NDArray[np.bool_]:
    """Which segments (x, y, x, y) have a point in a box (left, bottom, right, top)."""
    start, way = segments[:, :2], segments[:, 2:] - segments[:, :2]
    way = np.where(way == 0.0, 1e-12, way)
    one, other = (box[:2] - start) / way, (box[2:] - start) / way
    enters, leaves = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
    return np.asarray(np.maximum(enters, 0.0) <= np.minimum(leaves, 1.0))


def _cross(segment: Array, others: Array) -> int:
    """How many segments another crosses; those that begin where it begins are not counted."""

    def side(a: Array, b: Array, p: Array) -> Array:
        return (b[..., 0] - a[..., 0]) * (p[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (
            p[..., 0] - a[..., 0]
        )

    a, b, c, d = segment[:2], segment[2:], others[:, :2], others[:, 2:]
    apart = (np.abs(c - a).max(axis=1) > 0.1) & (np.abs(d - a).max(axis=1) > 0.1)
    return int((apart & (side(a, b, c) * side(a, b, d) < 0.0) & (side(c, d, a) * side(c, d, b) < 0.0)).sum())
