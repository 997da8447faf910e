"""Columns as they come out of a file: numbers, or text where a cell is no number."""

from collections.abc import Sequence
from math import isfinite, isnan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Text(NamedTuple):
    """A column with at least one cell that is no number: its cells, and the decimal sign they use.

    Made by ``column_of``, which sees to that.
    """

    cells: tuple[str, ...]
    decimal: str = "."


Column = Array | Text


def column_of(cells: Sequence[str], comma: bool = False) -> Column:
    """The numbers in a column of text, or the text if a cell is no number.

    comma: whether "1,5" may stand for 1.5; a column must then use one of the two signs throughout.

    >>> column_of(["0,5", " 1"], comma=True)
    array([0.5, 1. ])
    >>> column_of(["0.5", ""])
    Text(cells=('0.5', ''), decimal='.')
    """
    joined = " ".join(cells)
    decimal = "," if comma and "," in joined and "." not in joined else "."
    if "_" in joined:  # Python reads 1_000 as a number; nobody who logs means that
        return Text(tuple(cells), decimal)
    try:
        if decimal == ",":
            return np.array([float(c.replace(",", ".")) for c in cells], dtype=np.float64)
        return np.array([float(c) for c in cells], dtype=np.float64)
    except ValueError:
        return Text(tuple(cells), decimal)


def first_bad(column: Column) -> tuple[int, str] | None:
    """Where a column stops being finite numbers, and what is there instead; None for a good one.

    >>> first_bad(np.array([1.0, np.inf]))
    (1, 'the cell is infinite')
    >>> first_bad(Text(("1", "", "x")))
    (1, 'the cell is empty')
    """
    if isinstance(column, Text):
        for i, cell in enumerate(column.cells):
            problem = _problem(cell, column.decimal)
            if problem:
                return i, problem
        return None
    bad = np.flatnonzero(~np.isfinite(column))
    return (int(bad[0]), _of_number(float(column[bad[0]]))) if bad.size else None


def _problem(cell: str, decimal: str) -> str | None:
    if not cell.strip():
        return "the cell is empty"
    try:
        value = float("?" if "_" in cell else cell.replace(decimal, "."))
    except ValueError:
        return f"{cell.strip()!r} is not a number"
    return None if isfinite(value) else _of_number(value)


def _of_number(value: float) -> str:
    return "the cell is NaN" if isnan(value) else "the cell is infinite"


def shorten(names: Sequence[str], most: int = 20) -> str:
    """Names in one line, the first few of many.

    >>> shorten(["a", "b", "c"], most=2)
    "'a', 'b' and 1 more"
    """
    shown = ", ".join(repr(n) for n in names[:most]) or "none"
    return f"{shown} and {len(names) - most} more" if len(names) > most else shown


def one_line(error: Any) -> str:
    """What a library said went wrong, in one line."""
    return " ".join(str(error).split()) or type(error).__name__
