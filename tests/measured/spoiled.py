"""Cells of a good recording, one of which a test may spoil."""

HEADER = ("time_s", "command_V", "angle_deg", "pressure_kPa")


def rows_with(column: int = 0, row: int = 0, cell: str | None = None) -> list[list[str]]:
    """Cells of a good recording but for one; `row` counts as the file does, the header being row 1."""
    rows = [[f"{i / 100:.2f}", "2.0", f"{i}", f"{100 + i}"] for i in range(8)]
    if cell is not None:
        rows[row - 2][column] = cell
    return rows
