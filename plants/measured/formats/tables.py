"""Reading a file of any known format into columns by name."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from plants.errors import InputError
from plants.measured.formats.binary.matlab import read_mat
from plants.measured.formats.cells import Column, column_of, one_line
from plants.measured.formats.csv_table import read_csv


@dataclass(frozen=True)
class Table:
    """Columns of a file by name.

    rows: the row of the file in which each cell stands; None where the format has
    no rows of text, and cells are counted from 1.  note: what could not be read,
    to be added where a column is missing.
    """

    path: Path
    columns: Mapping[str, Column]
    rows: tuple[int, ...] | None = None
    note: str = ""

    def row(self, i: int) -> int:
        """The row, as a user counts it, of the i-th cell of a column."""
        return i + 1 if self.rows is None else self.rows[i]


def read_table(path: str | Path) -> Table:
    """The columns of a CSV (.csv, .tsv, .txt), Parquet (.parquet) or MATLAB (.mat) file.

    Raises InputError, in one line, for a file that is missing, of another kind, damaged or empty.
    """
    path = Path(path)
    try:
        if path.is_dir():
            raise InputError(f"{path}: is a folder; give a recording (.csv, .parquet or .mat)")
        if not path.exists():
            raise InputError(f"{path}: no such file; give a recording (.csv, .parquet or .mat) that exists")
        if path.stat().st_size == 0:
            raise InputError(f"{path}: the file is empty; a recording needs a header row and at least 2 rows")
        match path.suffix.lower():
            case ".csv" | ".tsv" | ".txt":
                return Table(path, *read_csv(path))
            case ".parquet" | ".pq":
                return Table(path, _read_parquet(path))
            case ".mat":
                columns, note = read_mat(path)
                return Table(path, columns, note=note)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or one_line(error)})") from None
    raise InputError(f"{path}: unknown kind of file; recordings are .csv, .parquet or .mat")


def _read_parquet(path: Path) -> dict[str, Column]:
    import pyarrow
    import pyarrow.parquet

    try:
        with path.open("rb") as file:
            table = pyarrow.parquet.read_table(file)
    except (pyarrow.ArrowException, OSError) as error:
        raise InputError(
            f"{path}: cannot be read as Parquet ({one_line(error)}); it may be cut off: export it again"
        ) from None
    return {name: _numbers(table.column(i)) for i, name in enumerate(table.column_names)}


def _numbers(column: Any) -> Column:
    import pyarrow

    try:
        numbers = column.cast(pyarrow.float64(), safe=False)
        return np.array(numbers.to_numpy(), dtype=np.float64)
    except pyarrow.ArrowException:
        return column_of(["" if c is None else str(c) for c in column.to_pylist()])
