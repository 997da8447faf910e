"""Bins over what a residual is plotted against."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plants.measured.residual.series.joined import Joined
from plants.measured.residual.series.remainder import Array

BINS = 12
"""Most bins of a variable."""

FEWEST = 0.004
"""Smallest share of the rows in a bin; smaller ones join the next."""

STRETCH = 8.0
"""Length of the stretches of time within a recording [s] whose means tell of wander."""

MOST_STRETCHES = 60
"""So many stretches at most; they are longer in longer campaigns."""


@dataclass(frozen=True)
class Bins:
    """Bins of one variable: label (n,) of each row, -1 for none; centre (bins,) in its unit."""

    variable: str
    label: NDArray[np.int64]
    centre: Array


def bins_of(joined: Joined, variable: str) -> Bins | None:
    """Bins of a variable, half of the edges at equal counts and half at equal distances.

    Equal counts alone would put most bins into the holds, where little happens;
    equal distances alone would leave rare extremes in bins of a few rows.
    None for a variable that is constant, or logged too rarely.
    """
    values = joined.variables[variable]
    known = np.isfinite(values)
    there = values[known]
    if there.size < 0.02 * joined.rows or np.ptp(there) == 0.0:
        return None
    levels = np.unique(there)
    if len(levels) <= BINS // 2:
        edges = (levels[1:] + levels[:-1]) / 2.0
    else:
        counted = np.quantile(there, np.linspace(0.0, 1.0, BINS // 2 + 1)[1:-1])
        low, high = np.quantile(there, [0.002, 0.998])
        edges = np.unique(np.append(counted, np.linspace(low, high, BINS // 2 + 2)[1:-1]))
    edges = _merged(edges, there)
    if not edges.size:
        return None
    label = np.full(len(values), -1, dtype=np.int64)
    label[known] = np.searchsorted(edges, there, side="right")
    sums = np.bincount(label[known], weights=there, minlength=len(edges) + 1)
    counts = np.bincount(label[known], minlength=len(edges) + 1)
    return Bins(variable, label, sums / counts)


def _merged(edges: Array, values: Array) -> Array:
    """Edges with every bin holding enough of the values."""
    least = max(5.0, FEWEST * len(values))
    ordered = np.sort(values)
    kept: list[float] = []
    last = 0
    for edge in edges.tolist():
        at = int(np.searchsorted(ordered, edge, side="left"))
        if at - last >= least and len(values) - at >= least:
            kept.append(edge)
            last = at
    return np.array(kept)


def stretches(joined: Joined, length: float = STRETCH) -> Bins:
    """Consecutive stretches of time [s] within each recording, as bins over the number of the stretch."""
    rows = max(2, round(max(length, joined.duration / MOST_STRETCHES) / joined.dt))
    label = np.full(len(joined.value), -1, dtype=np.int64)
    first = 0
    for span in joined.spans:
        count = span.stop - span.start
        parts = max(1, round(count / rows))
        label[span] = first + np.minimum(np.arange(count) * parts // count, parts - 1)
        first += parts
    return Bins("time", label, np.arange(first, dtype=float))
