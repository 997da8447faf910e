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

ROUNDS, ORDERS = 4, 12
"""How often each name is placed again with all others in place, and in how many orders that is tried."""

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
    names = _placed(at, size, lines)
    for name, b in names.items():
        leader = _leaders(at[name], b[None])[0]
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


def _placed(at: Mapping[str, Array], panel: Array, lines: Array) -> dict[str, Array]:
    """The box (left, bottom, right, top) [pt] of each name: each where it costs least with the others in
    place, begun in several orders, of which the cheapest is taken."""
    places = {n: _places(p, np.array([0.58 * SIZE * len(n), 1.25 * SIZE]), panel) for n, p in at.items()}
    shuffle = np.random.default_rng(0)
    least, found = np.inf, dict[str, Array]()
    for _ in range(ORDERS):
        names: dict[str, Array] = {}
        total = np.inf
        order = [list(at)[i] for i in shuffle.permutation(len(at))]
        for _ in range(ROUNDS):
            before, total = total, 0.0
            for name in order:
                point, others = at[name], {n: b for n, b in names.items() if n != name}
                marks = [_around(p) for n, p in at.items() if n != name]
                leaders = [_leaders(at[n], b[None])[0] for n, b in others.items()]
                cost = _costs(places[name], point, _boxes([*others.values(), *marks]), lines, _boxes(leaders))
                names[name] = places[name][int(np.argmin(cost))]
                total += float(cost.min())
            if total == before:
                break
        if total < least:
            least, found = total, names
    return found


def _costs(boxes: Array, point: Array, taken: Array, lines: Array, leaders: Array) -> Array:
    """What a name costs in each of some boxes (n, 4) [pt], beside boxes that are taken, lines of the panel
    and the leaders of other names."""
    roomy = boxes + np.concatenate([-ROOM, ROOM])
    over = ((roomy[:, None, :2] < taken[:, 2:]) & (roomy[:, None, 2:] > taken[:, :2])).all(axis=2).sum(axis=1)
    own = _leaders(point, boxes)
    length = np.hypot(*(own[:, 2:] - own[:, :2]).T)
    askew = np.abs(0.5 * (boxes[:, :2] + boxes[:, 2:]) - point).min(axis=1)
    struck = _met(lines[None], roomy[:, None]).sum(axis=1) + _met(leaders[None], roomy[:, None]).sum(axis=1)
    through = _met(own[:, None], taken[None]).sum(axis=1)
    crossed = _crossings(own, np.concatenate([lines, leaders]))
    joined = length > 2.0 * MARK
    struck = struck + np.where(joined, through, 0)
    crossed = np.where(joined, crossed, 0)
    return np.asarray(OVER * over + STRUCK * struck + CROSSED * crossed + length + 0.5 * askew)


def _places(point: Array, size: Array, panel: Array) -> Array:
    """Boxes (n, 4) around a point within the panel: beside it, above and below it, ever further away."""
    beside, high = MARK + 3.0, size[1]
    found = []
    for up in 0.5 * high * np.arange(-14, 15):
        for right in (beside, 3.0 * beside, 6.0 * beside, 10.0 * beside):
            for left in (point[0] + right, point[0] - right - size[0]):
                found.append((left, point[1] + up - 0.5 * high))
        if abs(up) >= MARK + 0.5 * high:
            for share in (0.2, 0.5, 0.8):
                found.append((point[0] - share * size[0], point[1] + up - 0.5 * high))
    corners = np.array(found)
    boxes = np.concatenate([corners, corners + size], axis=1)
    inside = (boxes[:, :2] >= 0.0).all(axis=1) & (boxes[:, 2:] <= panel).all(axis=1)
    return np.asarray(boxes[inside] if inside.any() else boxes)


def _leaders(point: Array, boxes: Array) -> Array:
    """The lines (n, x y x y) [pt] from a point to the nearest place of each box."""
    ends = np.clip(point, boxes[:, :2], boxes[:, 2:])
    return np.concatenate([np.broadcast_to(point, ends.shape), ends], axis=1)


def _boxes(some: list[Array]) -> Array:
    return np.array(some).reshape(-1, 4)


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


def _met(segments: Array, boxes: Array) -> NDArray[np.bool_]:
    """Which segments (..., x y x y) have a point in boxes (..., left bottom right top), broadcast."""
    start, way = segments[..., :2], segments[..., 2:] - segments[..., :2]
    way = np.where(way == 0.0, 1e-12, way)
    one, other = (boxes[..., :2] - start) / way, (boxes[..., 2:] - start) / way
    enters, leaves = np.minimum(one, other).max(axis=-1), np.maximum(one, other).min(axis=-1)
    return np.asarray(np.maximum(enters, 0.0) <= np.minimum(leaves, 1.0))


def _crossings(segments: Array, others: Array) -> NDArray[np.intp]:
    """How many of the others each segment crosses; those that begin where it begins are not counted."""

    def side(a: Array, b: Array, p: Array) -> Array:
        return (b[..., 0] - a[..., 0]) * (p[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (
            p[..., 0] - a[..., 0]
        )

    a, b, c, d = segments[:, None, :2], segments[:, None, 2:], others[None, :, :2], others[None, :, 2:]
    apart = (np.abs(c - a).max(axis=-1) > 0.1) & (np.abs(d - a).max(axis=-1) > 0.1)
    cross = (side(a, b, c) * side(a, b, d) < 0.0) & (side(c, d, a) * side(c, d, b) < 0.0)
    return np.asarray((apart & cross).sum(axis=1))
