"""Cells that a logger left empty, and values that no sensor can have seen: rows that a channel lacks.

Loggers that merge channels of different rates leave the cells between empty; a bad contact or a lost packet
gives single values far from those beside them, back in a row or two.  Such rows are taken out: between the
others there are straight lines, and only the others count.
"""

import numpy as np
from numpy.typing import NDArray

from plants.measured.formats.cells import Column, Text, column_of

Array = NDArray[np.float64]
Rows = NDArray[np.bool_]

ROWS, FILLED = 50, 20
"""Rows that a recording needs for cells to be missing, and cells that have to be there: a short table with an
empty cell is a mistake rather than a habit."""

WIDTH = 3
"""Rows that a spike lasts at most."""

HIGH = 0.05
"""Share of the channel's range that a spike exceeds the values beside it by at least."""

BEYOND = 6.0
"""Times the steps that a channel makes from row to row, all but the largest of them, that it does."""

BACK = 0.2
"""Share of its height by which the values before and after a spike may differ: after a slip they do."""

FEW = 0.01
"""Share of the rows that spikes may take: more is a way of moving."""


def with_missing(column: Column) -> Array | None:
    """The numbers of a column whose empty cells are not a number, None where it has other text, infinite
    values, too few rows, or too few numbers.

    >>> with_missing(Text(("", "1.5") * 30))[:2]
    array([nan, 1.5])
    >>> with_missing(Text(("1", ""))) is None
    True
    """
    values = numbers_in(column)
    if values is None or np.isinf(values).any() or len(values) < ROWS:
        return None
    return values if np.isfinite(values).sum() >= FILLED else None


def numbers_in(column: Column) -> Array | None:
    """The numbers of a column whose empty cells are not a number, None where it has other text."""
    if not isinstance(column, Text):
        return column
    cells = ["nan" if not c.strip() else c for c in column.cells]
    numbers = column_of(cells, column.decimal == ",")
    return None if isinstance(numbers, Text) else numbers


def lines_between(time: Array, values: Array, there: Rows) -> Array:
    """Values (n,) with straight lines over the rows that lack one."""
    return np.interp(time, time[there], values[there])


def spikes(values: Array) -> Rows:
    """Rows of a series (n,) that hold a spike: at most three in a row that stand far to one side of the
    values before and after, which agree.  The series is taken to turn back at its ends.

    >>> at = spikes(np.insert(np.sin(np.arange(400) / 40), 100, [9.0, 9.1]))
    >>> np.flatnonzero(at).tolist()
    [100, 101]
    """
    n, found = len(values), np.zeros(len(values), bool)
    if n < ROWS:
        return found
    steps = np.abs(np.diff(values))
    usual = float(np.quantile(steps, 1.0 - 2.0 * FEW))
    span = float(np.ptp(np.quantile(values, (FEW, 1.0 - FEW))))
    high = max(BEYOND * usual, HIGH * span)
    if high == 0.0:
        return found
    longer = np.pad(values, WIDTH, "reflect")
    off = np.zeros(len(longer), bool)
    for width in range(1, WIDTH + 1):
        before, after = longer[: -width - 1], longer[width + 1 :]
        inside = np.lib.stride_tricks.sliding_window_view(longer[1:-1], width)
        for way in (1.0, -1.0):
            height = np.min(way * inside, axis=1) - np.maximum(way * before, way * after)
            at = np.flatnonzero((height > high) & (np.abs(after - before) < BACK * height))
            for i in at:
                off[i + 1 : i + 1 + width] = True
    found = off[WIDTH:-WIDTH]
    return found if found.mean() <= FEW else np.zeros(n, bool)
