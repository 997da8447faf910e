"""Bad recordings are refused in one line: the file, the row and column where they apply, and what to do."""

from pathlib import Path

import numpy as np
import pytest

from plants.errors import InputError
from plants.measured.campaigns.campaign import load_recording
from tests.measured.spoiled import HEADER, rows_with


def refusal(load, *arguments, **named) -> str:
    with pytest.raises(InputError) as caught:
        load(*arguments, **named)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_a_missing_file(tmp_path: Path):
    path = tmp_path / "none.csv"
    said = refusal(load_recording, path)
    assert said == f"{path}: no such file; give a recording (.csv, .parquet or .mat) that exists"


def test_a_folder_in_place_of_a_recording(tmp_path: Path):
    assert refusal(load_recording, tmp_path).startswith(f"{tmp_path}: is a folder; ")


def test_a_file_of_another_kind(tmp_path: Path):
    path = tmp_path / "steps.xlsx"
    path.write_bytes(b"PK")
    assert (
        refusal(load_recording, path)
        == f"{path}: unknown kind of file; recordings are .csv, .parquet or .mat"
    )


def test_a_missing_column_lists_those_there_are(write_csv):
    path = write_csv(header=("time_s", "command_V", "theta", "pressure_kPa"))
    assert refusal(load_recording, path) == (
        f"{path}: no column 'angle_deg'; the file has 'time_s', 'command_V', 'theta', 'pressure_kPa'; "
        'name it in [columns], or set stage = "regulator" if only the pressure was measured'
    )


def test_a_regulator_recording_needs_its_pressure(write_csv):
    path = write_csv(header=("time_s", "command_V", "angle_deg", "p"))
    said = refusal(load_recording, path, stage="regulator")
    assert said.startswith(f"{path}: no column 'pressure_kPa'; ")


def test_a_mapped_column_that_is_not_there(write_csv):
    path = write_csv()
    assert refusal(load_recording, path, {"time_s": "Time"}) == (
        f"{path}: no column 'Time', to which [columns] maps time_s; "
        "the file has 'time_s', 'command_V', 'angle_deg', 'pressure_kPa'"
    )


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        (
            {"angle": "theta"},
            "unknown column 'angle' in [columns]; known are 'time_s', 'command_V', 'angle_deg', ",
        ),
        (
            {"angle_deg": 3},
            '[columns] angle_deg: must be "NAME" or {name = "NAME", scale = 1.0, offset = 0.0}',
        ),
        (
            {"angle_deg": {"name": "a", "gain": 2.0}},
            "[columns] angle_deg: unknown key 'gain'; known are 'name', ",
        ),
        ({"angle_deg": {"name": "a", "scale": "2"}}, "[columns] angle_deg: scale '2' is not a finite number"),
        ({"angle_deg": {"name": "a", "scale": 0}}, "[columns] angle_deg: scale must not be 0"),
        (
            {"angle_deg": {"name": "a", "offset": np.nan}},
            "[columns] angle_deg: offset nan is not a finite number",
        ),
    ],
)
def test_a_mapping_that_makes_no_sense(write_csv, entry, said):
    path = write_csv()
    assert refusal(load_recording, path, entry).startswith(f"{path}: {said}")


@pytest.mark.parametrize("content", ["", "\n\n", "\ufeff", ",,,\n,,,\n"])
def test_an_empty_file(tmp_path: Path, content):
    path = tmp_path / "empty.csv"
    path.write_text(content, encoding="utf-8")
    said = refusal(load_recording, path)
    assert said == f"{path}: the file is empty; a recording needs a header row and at least 2 rows"


def test_a_header_and_nothing_else(write_csv):
    path = write_csv(rows=[])
    assert refusal(load_recording, path) == f"{path}: has no rows; a recording needs at least 2"


def test_one_row(write_csv):
    path = write_csv(rows=rows_with()[:1])
    assert refusal(load_recording, path) == f"{path}: has only 1 row; a recording needs at least 2"


def test_no_header(write_csv):
    path = write_csv(header=("0.0", "2.0", "0", "100"))
    assert refusal(load_recording, path).startswith(f"{path}: row 1: holds numbers, not column names; ")


def test_a_name_that_is_there_twice(write_csv):
    path = write_csv(header=("time_s", "command_V", "angle_deg", "angle_deg"))
    assert refusal(load_recording, path).startswith(f"{path}: row 1: column 'angle_deg' is there twice; ")


def test_a_column_without_a_name(write_csv):
    path = write_csv(header=("time_s", "command_V", "angle_deg", ""))
    assert refusal(load_recording, path) == f"{path}: row 1: column 4 has no name; give it one"


@pytest.mark.parametrize(
    ("cell", "problem"),
    [
        ("NaN", "the cell is NaN"),
        ("inf", "the cell is infinite"),
        ("-Infinity", "the cell is infinite"),
        ("", "the cell is empty"),
        ("  ", "the cell is empty"),
        ("abc", "'abc' is not a number"),
        ("1.0.0", "'1.0.0' is not a number"),
        ("1_000", "'1_000' is not a number"),
        ('"1,5"', "'1,5' is not a number"),
        ("#DIV/0!", "'#DIV/0!' is not a number"),
        ('"two\nlines"', r"'two\nlines' is not a number"),
    ],
)
@pytest.mark.parametrize("column", range(4))
def test_a_cell_that_is_no_finite_number(write_csv, column, cell, problem):
    path = write_csv(rows=rows_with(column, 5, cell))
    row = 6 if "\n" in cell else 5  # a cell of two lines ends in the next line of the file
    assert refusal(load_recording, path) == (
        f"{path}: row {row}, column {HEADER[column]!r}: {problem}; correct it or cut the recording there"
    )


def test_the_row_is_counted_with_the_blank_lines_above_it(write_csv):
    rows = [*rows_with()[:3], [""], *rows_with(2, 6, "x")[3:]]
    path = write_csv(rows=rows)
    assert refusal(load_recording, path).startswith(f"{path}: row 7, column 'angle_deg': 'x' is not a number")


@pytest.mark.parametrize("cell", ["x,5", "1.234,5", ""])
def test_a_bad_cell_among_decimal_commas(write_csv, cell):
    rows = [[c.replace(".", ",") for c in row] for row in rows_with()]
    rows[4][1] = cell
    path = write_csv(rows=rows, separator=";")
    problem = f"{cell!r} is not a number" if cell else "the cell is empty"
    said = refusal(load_recording, path)
    # A decimal point makes the column one of points, so that the first comma in it is what is wrong.
    where, problem = ("row 2", "'2,0' is not a number") if "." in cell else ("row 6", problem)
    assert said.startswith(f"{path}: {where}, column 'command_V': {problem}")


def test_decimal_commas_between_commas(write_csv):
    path = write_csv(rows=[[c.replace(".", ",") for c in row] for row in rows_with()])
    assert refusal(load_recording, path) == (
        f"{path}: row 2: 6 cells under a header of 4; "
        "with decimal commas, separate the columns with semicolons"
    )


def test_a_header_with_two_separators(write_csv):
    path = write_csv(header=("time_s", "command_V;angle_deg", "pressure_kPa"))
    assert refusal(load_recording, path).startswith(f"{path}: row 1: the header has semicolons and commas; ")


def test_a_row_that_is_cut_off(write_csv):
    path = write_csv(rows=[*rows_with(), ["0.08", "2"]])
    said = refusal(load_recording, path)
    assert said.startswith(f"{path}: row 10: 2 cells under a header of 4; complete the row, or drop it")


def test_a_text_that_is_not_utf8(write_csv):
    path = write_csv(rows=rows_with())
    path.write_bytes(path.read_bytes().replace(b"103", b"\xb0"))
    assert refusal(load_recording, path) == f"{path}: row 5: not UTF-8 text; save the file as CSV in UTF-8"


def test_time_that_repeats(write_csv):
    path = write_csv(rows=rows_with(0, 6, "0.03"))
    assert refusal(load_recording, path) == (
        f"{path}: row 6, column 'time_s': time 0.03 s repeats; it must increase from row to row"
    )


def test_time_that_runs_backwards(write_csv):
    path = write_csv(rows=rows_with(0, 6, "0.015"), header=("Time", *HEADER[1:]))
    assert refusal(load_recording, path, {"time_s": "Time"}) == (
        f"{path}: row 6, column 'Time': time 0.015 s runs backwards, from 0.03; "
        "it must increase from row to row"
    )


@pytest.mark.parametrize("sample_time", [0.01, None])
def test_a_gap(write_csv, sample_time):
    rows = [[f"{i / 100 + 0.03 * (i > 4):.2f}", "2", f"{i}", "100"] for i in range(8)]
    path = write_csv(rows=rows)
    assert refusal(load_recording, path, sample_time=sample_time) == (
        f"{path}: row 7, column 'time_s': gap of 0.04 s after 0.04 s, the sample time being 0.01 s; "
        "split the recording there"
    )


def test_a_sample_time_that_contradicts_the_file(write_csv):
    path = write_csv()
    assert refusal(load_recording, path, sample_time=0.02) == (
        f"{path}: column 'time_s': the median step is 0.01 s but sample_time_s is 0.02; correct sample_time_s"
    )


def test_time_in_milliseconds(write_csv):
    path = write_csv(rows=[[f"{10 * i}", "2", f"{i}", "100"] for i in range(8)])
    said = refusal(load_recording, path, sample_time=0.01)
    assert said.endswith("sample_time_s is 0.01; the time looks like milliseconds; map it with scale = 0.001")


def test_parquet_that_is_cut_off(tmp_path: Path):
    import pyarrow
    import pyarrow.parquet

    path = tmp_path / "steps.parquet"
    pyarrow.parquet.write_table(pyarrow.table({"time_s": np.arange(100.0)}), path)
    whole = path.read_bytes()
    for length in (1, 20, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        said = refusal(load_recording, path)
        assert said.startswith(f"{path}: cannot be read as Parquet (")
        assert said.endswith("); it may be cut off: export it again")


def test_a_bad_cell_in_parquet_counts_from_one(tmp_path: Path):
    import pyarrow
    import pyarrow.parquet

    path = tmp_path / "steps.parquet"
    time = [0.0, 0.01, 0.02]
    for angle, problem in (
        ([0.0, None, 0.0], "row 2, column 'angle_deg': the cell is NaN"),
        (["0", "1", "x"], "row 3, column 'angle_deg': 'x' is not a number"),
    ):
        pyarrow.parquet.write_table(
            pyarrow.table({"time_s": time, "command_V": time, "angle_deg": angle}), path
        )
        assert refusal(load_recording, path).startswith(f"{path}: {problem}; ")
