"""Tables as values, and numbers as people read them."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import floor, isfinite, log10


@dataclass(frozen=True)
class Cell:
    """What stands in a cell: text, a smaller second line (a range), whether it breaks a limit, whether it is
    marked as something to be wary of, and whether it meets a limit."""

    text: str
    under: str = ""
    broken: bool = False
    marked: bool = False
    met: bool = False


@dataclass(frozen=True)
class Column:
    """A column: heading, unit (may be empty), and whether it holds numbers."""

    heading: str
    unit: str = ""
    number: bool = True


@dataclass(frozen=True)
class Group:
    """Rows under a common heading, which may be empty; `strong` marks rows to stand out."""

    heading: str
    rows: tuple[tuple[Cell, ...], ...]
    strong: tuple[int, ...] = ()


@dataclass(frozen=True)
class Table:
    """Columns, and groups of rows."""

    columns: tuple[Column, ...]
    groups: tuple[Group, ...]


def row(*values: "str | Cell") -> tuple[Cell, ...]:
    """Cells of a row, plain text made into cells."""
    return tuple(v if isinstance(v, Cell) else Cell(v) for v in values)


def number(value: float | None, digits: int = 3) -> str:
    """A number with some significant digits and no exponent where it can do without.

    >>> number(0.0803), number(1234.5), number(None), number(-2.0)
    ('0.0803', '1230', '–', '−2')
    """
    if value is None:
        return "–"
    if not isfinite(value):
        return "∞" if value > 0 else "−∞"
    if value == 0.0:
        return "0"
    decimals = digits - 1 - floor(log10(abs(value)))
    if decimals < -6 or decimals > 8:
        return f"{value:.{digits}g}"
    text = f"{round(value, decimals):.{max(decimals, 0)}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return text.replace("-", "−")


def measured(value: float, digits: int = 3, decimals: int = 3) -> str:
    """A result to some significant digits, zeros kept, with no more than some decimals.

    >>> measured(1.6), measured(10.81), measured(0.0501), measured(0.00255), measured(177.3)
    ('1.60', '10.8', '0.050', '0.003', '177')
    """
    if not isfinite(value) or value == 0.0:
        return number(value)
    places = min(max(digits - 1 - floor(log10(abs(value))), 0), decimals)
    return fixed(value, places)


def fixed(value: float, decimals: int, beyond: str = "∞") -> str:
    """A number with a number of decimals, so that a column lines up; `beyond` for an infinite one.

    >>> fixed(1.706, 2), fixed(float("inf"), 2, "> 10")
    ('1.71', '> 10')
    """
    return f"{value:.{decimals}f}".replace("-", "−") if isfinite(value) else beyond


def with_error(value: float, error: float | None) -> str:
    """A value and its standard error, both to the second digit of the error.

    >>> with_error(0.36012, 0.00214), with_error(6.0, None), with_error(48.7, 0.0)
    ('0.3601 ± 0.0021', '6 ± unknown', '48.7 ± 0')
    """
    if error is None or not isfinite(error):
        return f"{number(value, 4)} ± unknown"
    if error <= 0.0:
        return f"{number(value, 4)} ± 0"
    decimals = min(max(1 - floor(log10(error)), 0), 8)
    return f"{value:.{decimals}f} ± {error:.{decimals}f}".replace("-", "−")


def spaced(branch: str) -> str:
    """Words with the lines of the loop, and negative numbers, as people write them.

    >>> spaced("line1, slow regulator rate"), spaced("-15 deg, from line2")
    ('line 1, slow regulator rate', '−15 deg, from line 2')
    """
    words = branch.replace("line1", "line 1").replace("line2", "line 2")
    return re.sub(r"(?<![\w.])-(?=\d)", "−", words)


def listed(words: Sequence[str]) -> str:
    """Words as a list in a sentence.

    >>> listed(["a", "b", "c"]), listed(["a"])
    ('a, b and c', 'a')
    """
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
