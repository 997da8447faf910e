"""Reading a CSV file, with the row of the file for everything that is wrong in it.

Rows are counted as an editor counts them: from 1, the header included.  The
standard library splits the file: it keeps the row numbers, which a faster
parser loses, and takes about 30 ms for 14,000 rows.
"""

import csv
import io
import re
from pathlib import Path

from plants.errors import InputError
from plants.measured.formats.cells import Column, column_of


def read_csv(path: Path) -> tuple[dict[str, Column], tuple[int, ...]]:
    """Columns of a CSV file by name, and the row of the file in which each of their cells stands.

    Cells are separated by comma, semicolon or tab, whichever the header has; with
    the latter two a decimal comma is understood.  A byte order mark is skipped.
    Raises InputError for a file that is empty, not UTF-8, has no names in its
    header, or rows that are longer or shorter than it.
    """
    text = _text(path)
    separator = _separator(path, text)
    names, cells, rows = _split(path, text, separator)
    while cells and not any(c.strip() for c in cells[-1]):  # spreadsheets leave empty rows at the end
        del cells[-1], rows[-1]
    _check_widths(path, names, cells, rows)
    columns = list(zip(*(row[: len(names)] for row in cells), strict=True)) or [()] * len(names)
    table = {
        name: column_of(column, comma=separator != ",")
        for name, column in zip(names, columns, strict=True)
        if name or any(c.strip() for c in column)
    }
    if "" in table:
        raise InputError(f"{path}: row 1: column {names.index('') + 1} has no name; give it one")
    return table, tuple(rows)


def _text(path: Path) -> str:
    data = path.read_bytes()
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = data.count(b"\n", 0, error.start) + 1
        raise InputError(f"{path}: row {row}: not UTF-8 text; save the file as CSV in UTF-8") from None


def _separator(path: Path, text: str) -> str:
    lines = enumerate(text.splitlines(), 1)
    row, header = next(((i, line) for i, line in lines if line.strip(' \t";,')), (1, ""))
    if not header:
        raise InputError(f"{path}: the file is empty; a recording needs a header row and at least 2 rows")
    bare = re.sub(r'"[^"]*"', "", header)
    found = [s for s in ("\t", ";", ",") if s in bare]
    if len(found) > 1:
        names = {"\t": "tabs", ";": "semicolons", ",": "commas"}
        raise InputError(
            f"{path}: row {row}: the header has {' and '.join(names[s] for s in found)}; "
            "separate columns with one of them and quote names that contain it"
        )
    return found[0] if found else ","


def _split(path: Path, text: str, separator: str) -> tuple[list[str], list[list[str]], list[int]]:
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, skipinitialspace=True)
    cells, rows = [], []
    try:
        for row in reader:
            if len(row) > 1 or (row and row[0].strip()):  # lines that are blank are passed over
                cells.append(row)
                rows.append(reader.line_num)
    except csv.Error as error:
        raise InputError(f"{path}: row {reader.line_num}: {error}; export the file again") from None
    names = [name.strip() for name in cells[0]]
    if all(not isinstance(column_of([n]), tuple) for n in names):
        raise InputError(f"{path}: row {rows[0]}: holds numbers, not column names; put a header row above it")
    twice = [n for i, n in enumerate(names) if n and n in names[:i]]
    if twice:
        raise InputError(f"{path}: row {rows[0]}: column {twice[0]!r} is there twice; rename one of them")
    return names, cells[1:], rows[1:]


def _check_widths(path: Path, names: list[str], cells: list[list[str]], rows: list[int]) -> None:
    width = len(names)
    for row, line in zip(rows, cells, strict=True):
        if len(line) == width or (len(line) > width and not any(c.strip() for c in line[width:])):
            continue
        advice = "complete the row, or drop it if the file was cut off"
        if len(line) > width:
            advice = "with decimal commas, separate the columns with semicolons"
        raise InputError(f"{path}: row {row}: {len(line)} cells under a header of {width}; {advice}")
