"""A search for the worst place of a space in batches: what a search by single runs finds, in a tenth of the
time.

An evolution strategy with a few islands: each begins at one of the worst places known, draws its lanes around
its best with steps of every size at once, and keeps what is worse.  Vector units fill with the lanes of all
islands, and nothing is estimated that a worst case at a corner, or at a jump of the overshoot, would mislead.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ISLANDS, LANES = 8, 48
"""Islands, and places that each draws in a generation."""

STEPS = (0.3, 0.1, 0.03, 0.01)
"""Sizes of steps, in shares of the cube."""

AGAIN = 0.5
"""Share of the coordinates that a step leaves as they are."""


@dataclass(frozen=True)
class Hunted:
    """Places that were tried, (size, n), and how bad each is, (n,)."""

    places: Array
    heights: Array

    def worst(self, count: int, apart: float = 0.2) -> NDArray[np.intp]:
        """The worst `count`, worst first, each `apart` from the others in a coordinate."""
        found: list[int] = []
        for i in np.argsort(-self.heights, kind="stable")[:4000]:
            x = self.places[:, i]
            if all(np.max(np.abs(x - self.places[:, j])) > apart for j in found):
                found.append(int(i))
            if len(found) == count:
                break
        return np.array(found, np.intp)


def hunt(
    height: Callable[[Array], Array],
    known: Array,
    budget: int,
    seed: int,
    corners: int = 0,
    kind: Callable[[Array], NDArray[np.intp]] | None = None,
) -> Hunted:
    """Places of greatest height that were found in about `budget` tries, from those of `known`, (size, n),
    on.

    height: of places (size, lanes), minus infinity for those that do not count; corners: the first so many
    coordinates are those of a box, of which half of the fresh places are corners; kind: of places (size,
    lanes), which are searched apart in the first half, so that one kind that is bad at once does not hide
    another that is worse in the end.
    """
    rng = np.random.default_rng(seed)
    size = known.shape[0]
    fresh = rng.random((size, max(2 * ISLANDS * LANES - known.shape[1], ISLANDS)))
    fresh[:corners, ::2] = np.round(fresh[:corners, ::2])
    places = [np.hstack([known, fresh])]
    heights = [height(places[0])]
    used, again = heights[0].size, False
    best, at = _islands(Hunted(places[0], heights[0]), kind)
    while used < budget:
        if not again and used > budget // 2:
            again = True
            best, at = _islands(Hunted(np.hstack(places), np.concatenate(heights)), None)
        drawn = _steps(rng, np.repeat(best, LANES, axis=1))
        found = height(drawn)
        used += found.size
        places.append(drawn)
        heights.append(found)
        rows = found.reshape(best.shape[1], LANES)
        winner = rows.argmax(axis=1)
        where = np.arange(best.shape[1]) * LANES + winner
        better = found[where] > at
        best = np.where(better, drawn[:, where], best)
        at = np.where(better, found[where], at)
    return Hunted(np.hstack(places), np.concatenate(heights))


def _islands(known: Hunted, kind: Callable[[Array], NDArray[np.intp]] | None) -> tuple[Array, Array]:
    """Where islands begin, (size, n), and how bad these places are."""
    if kind is None:
        chosen = known.worst(ISLANDS)
    else:
        of = kind(known.places)
        kinds = np.unique(of)
        share, parts = -(-ISLANDS // kinds.size), []
        for k in kinds:
            (here,) = np.nonzero(of == k)
            parts.append(here[Hunted(known.places[:, here], known.heights[here]).worst(share)])
        chosen = np.concatenate(parts)
    return known.places[:, chosen], known.heights[chosen]


def _steps(rng: np.random.Generator, origin: Array) -> Array:
    """Places a step away from others: of every size, in about half of the coordinates, now and then to the
    end of one, where worst cases often are."""
    size, lanes = origin.shape
    step = rng.choice(STEPS, (1, lanes)) * rng.standard_normal((size, lanes))
    step[rng.random(step.shape) < AGAIN] = 0.0
    drawn = np.clip(origin + step, 0.0, 1.0)
    ends = rng.random(drawn.shape) < 0.5 / size
    return np.asarray(np.where(ends, np.round(rng.random(drawn.shape)), drawn))
