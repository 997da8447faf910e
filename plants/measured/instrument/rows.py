"""Rows that a logger wrote twice or in the wrong order: put right where there is no doubt what they were.

A row whose every cell repeats the one before is dropped.  Rows that run backwards in time are sorted where
that leaves an even time, as where two packets of a network overtook each other.  Anything else is left to be
refused: a time that repeats with other values, two runs in one file.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plants.measured.formats.cells import Column, Text
from plants.measured.formats.tables import Table

Rows = NDArray[np.intp]
EVEN = (0.6, 1.6)
"""Steps of the sorted time, over the usual one, between which it is even."""

FEW = 0.05
"""Share of the steps that may run backwards: more is no slip of a logger."""


def mended(table: Table, time: str) -> tuple[Table, dict[str, int]]:
    """The table without rows written twice and with its rows in order of the column `time`, and how many rows
    were ``repeated`` and ``swapped``; as it was where there is nothing to mend, or no certainty how.

    >>> from pathlib import Path
    >>> t = np.array([0.0, 0.1, 0.1, 0.3, 0.2, 0.4, 0.5, 0.6])
    >>> found, counts = mended(Table(Path("log.csv"), {"t": t, "x": 10.0 * t}), "t")
    >>> found.columns["x"].tolist(), counts
    ([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0], {'repeated': 1, 'swapped': 1})
    """
    at = table.columns[time]
    if isinstance(at, Text) or len(at) < 3 or np.all(np.diff(at) > 0.0) or not np.isfinite(at).all():
        return table, {}
    if any(_length(c) != len(at) for c in table.columns.values()):
        return table, {}
    twice = np.append(False, np.diff(at) == 0.0)
    for column in table.columns.values():
        twice[1:] &= _same(column)
    rows: Rows = np.flatnonzero(~twice)
    steps = np.diff(at[rows])
    back = int(np.sum(steps < 0.0))
    if back:
        order = np.argsort(at[rows], kind="stable")
        usual = float(np.median(steps))
        even = np.diff(at[rows][order])
        if back > max(1.0, FEW * len(steps)) or even.min() < EVEN[0] * usual or even.max() > EVEN[1] * usual:
            return table, {}
        rows = rows[order]
    if len(rows) == len(at) and not back:
        return table, {}
    columns = {n: _taken(c, rows) for n, c in table.columns.items()}
    numbers = None if table.rows is None else tuple(table.rows[i] for i in rows)
    counts = {"repeated": int(twice.sum()), "swapped": back}
    return replace(table, columns=columns, rows=numbers), {n: c for n, c in counts.items() if c}


def _length(column: Column) -> int:
    return len(column.cells) if isinstance(column, Text) else len(column)


def _same(column: Column) -> NDArray[np.bool_]:
    """Which cells are the same as those before."""
    if isinstance(column, Text):
        return np.array([a == b for a, b in zip(column.cells[:-1], column.cells[1:], strict=True)], bool)
    return np.equal(column[1:], column[:-1])


def _taken(column: Column, rows: Rows) -> Column:
    if isinstance(column, Text):
        return column._replace(cells=tuple(column.cells[i] for i in rows))
    return column[rows]
