"""Reading text tables of any dialect: what recorders, spreadsheets and instruments call CSV.

The table is the longest stretch of rows of equally many cells that are mostly numbers.  The row above it, or
the one above that where the next holds units, has the names; all that stands before is a header of text and
is passed over, as is what stands after.  The reader of a campaign's own CSV is stricter, and
names the row in which something is wrong.
"""

import csv
import io
import re
from collections import Counter
from pathlib import Path

import numpy as np

from plants.errors import InputError
from plants.measured.formats.channel import Array, LoggedSeries
from plants.measured.formats.units import quantity

SEPARATORS = (";", "\t", ",", "|", None)
"""What may stand between cells, the first that makes a table: a comma may also be a decimal sign, which the
others are not, and blanks (None) stand anywhere."""

LEAST = 8
"""Rows of numbers that make a table."""

UNIT = re.compile(r"^\s*[\[(]?\s*([^\[\]()]{0,12}?)\s*[\])]?\s*$")
IN_NAME = re.compile(r"^(.*\S)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))\s*$")


def read_text(path: Path) -> list[LoggedSeries]:
    """The numeric columns of a text file with their units.

    Encodings UTF-8, UTF-16 with its mark and Windows-1252; separators semicolon, tab, comma, bar and blanks;
    decimal commas where commas do not separate; times of day and dates as seconds from the first row.
    Raises InputError for a file in which no table is found.

    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "log.csv"
    >>> _ = path.write_text("Logger 7\\n\\nZeit;Druck\\ns;bar\\n" + "0,0;1,5\\n0,1;1,5\\n" * 9)
    >>> [(s.name, s.unit, float(s.values[1])) for s in read_text(path)]
    [('Zeit', 's', 0.1), ('Druck', 'bar', 1.5)]
    """
    text = _decoded(path.read_bytes())
    tables = (_table(text, separator) for separator in SEPARATORS)
    head, rows, comma = next((t for t in tables if len(t[1]) >= LEAST), ([], [], False))
    if not rows:
        raise InputError(f"{path}: no table of numbers was found in it; export it as CSV with a row of names")
    names, units = _heading(head, len(rows[0]))
    found = []
    for name, unit, cells in zip(names, units, zip(*rows, strict=True), strict=True):
        values, own = _values(list(cells), comma)
        if values is not None:
            found.append(LoggedSeries(name, own or unit, values))
    return found


def _decoded(data: bytes) -> str:
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", "replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace")


def _table(text: str, separator: str | None) -> tuple[list[list[str]], list[list[str]], bool]:
    """Rows above the longest table of a dialect, its rows, and whether its decimal sign is a comma."""
    if separator is None:
        lines = [line.split() for line in text.splitlines()]
    else:
        lines = list(csv.reader(io.StringIO(text, newline=None), delimiter=separator, skipinitialspace=True))
    lines = _ended([[c.strip() for c in line] for line in lines])
    comma = separator != ","
    best, start = (0, 0), 0
    for i in range(len(lines) + 1):
        same = (
            i < len(lines) and i > start and len(lines[i]) == len(lines[start]) and _is_row(lines[i], comma)
        )
        if same:
            continue
        if i - start > best[1] - best[0]:
            best = start, i
        start = i + (i < len(lines) and not _is_row(lines[i], comma))
    first, last = best
    if last <= first or len(lines[first]) < 2:
        return [], [], comma
    decimal = comma and any("," in c for line in lines[first : first + 200] for c in line)
    return lines[:first], lines[first:last], decimal


def _ended(lines: list[list[str]]) -> list[list[str]]:
    """Lines without the cell that a separator at their end adds; one that is empty in some rows only is a
    cell of the last column.

    >>> _ended([["t", "u", ""], ["0", "1", ""]]), _ended([["t", "u"], ["0", ""], ["1", "2", ""]])
    ([['t', 'u'], ['0', '1']], [['t', 'u'], ['0', ''], ['1', '2']])
    """
    widths = Counter(len(line) for line in lines if len(line) > 1)
    width = widths.most_common(1)[0][0] if widths else 0
    if width > 2 and not any(line[-1] for line in lines if len(line) == width):
        width -= 1
    return [line[:-1] if len(line) == width + 1 and not line[-1] else line for line in lines]


def _is_row(cells: list[str], comma: bool) -> bool:
    """Whether most cells of a line that are not empty are numbers, or times."""
    known = [c for c in cells if c]
    return len(cells) > 1 and 2 * sum(_number(c, comma) is not None or _is_time(c) for c in known) > len(
        known
    )


def _number(cell: str, comma: bool) -> float | None:
    if "_" in cell:
        return None
    if comma and "," in cell:
        cell = cell.replace(".", "").replace(",", ".") if cell.count(",") == 1 else "?"
    try:
        return float(cell)
    except ValueError:
        return None


def _is_time(cell: str) -> bool:
    return re.search(r"\d{1,2}:\d{2}", cell) is not None


def _heading(head: list[list[str]], width: int) -> tuple[list[str], list[str]]:
    """Names and units from the rows above a table."""
    above = [line for line in head[-3:] if any(line)]
    wide = [line for line in above if abs(len(line) - width) <= 1 and sum(map(bool, line)) > width / 2]
    names = wide[-1] if wide else []
    units = [""] * width
    if len(wide) > 1 and _are_units(wide[-1]) and not _are_units(wide[-2]):
        names, units = wide[-2], [_unit(c) for c in wide[-1]] + [""]
    found: list[str] = []
    for i in range(width):
        name = (names[i] if i < len(names) else "").lstrip("#% ") or f"column {i + 1}"
        name, inside = named_unit(name)
        units[i] = units[i] or inside
        found.append(name if name not in found else f"{name} ({i + 1})")
    return found, units[:width]


def named_unit(name: str) -> tuple[str, str]:
    """A name and the unit in brackets at its end, "" where there is none.

    >>> named_unit("Zeit [s]"), named_unit("u")
    (('Zeit', 's'), ('u', ''))
    """
    found = IN_NAME.match(name)
    return (found[1], found[2] if found[2] is not None else found[3]) if found else (name, "")


def _are_units(cells: list[str]) -> bool:
    """Whether a row above a table holds units: all short, one at least that is known."""
    said = [_unit(c) for c in cells if c]
    known = sum(quantity(u) is not None for u in said)
    return bool(said) and all(len(u) <= 12 for u in said) and 2 * known >= len(said)


def _unit(cell: str) -> str:
    found = UNIT.match(cell)
    return found[1] if found and found[1] not in ("-", "1") else ""


def _values(cells: list[str], comma: bool) -> tuple[Array | None, str]:
    """A column's numbers, NaN where a cell is none, and its unit where they are times; None for text, and
    where every cell is empty."""
    numbers = [_number(c, comma) for c in cells]
    if 10 * sum(n is not None for n in numbers) > 9 * sum(map(bool, cells)):
        return np.array([np.nan if n is None else n for n in numbers]), ""
    if all(map(_is_time, cells)):
        return _seconds([c.replace(",", ".") for c in cells]), "s"
    return None, ""


def _seconds(cells: list[str]) -> Array | None:
    """Seconds since the first of some times of day or dates."""
    import pandas as pd

    kind = pd.to_timedelta if all(re.fullmatch(r"[\d:.]+", c) for c in cells) else pd.to_datetime
    try:
        stamps = pd.Series(kind(cells))
    except ValueError:
        return None
    return np.asarray((stamps - stamps.iloc[0]).dt.total_seconds(), float)
