"""Recordings that load but are probably not what was meant: a warning in one line."""

import pytest

from plants.errors import InputWarning
from plants.measured.campaigns.campaign import load_campaign, load_recording
from tests.measured.spoiled import HEADER, rows_with


def warning(load, *arguments, **named) -> str:
    with pytest.warns(InputWarning) as caught:
        load(*arguments, **named)
    assert len(caught) == 1
    message = str(caught[0].message)
    assert "\n" not in message
    return message


@pytest.mark.parametrize(("cell", "stage"), [("-0.5", "wrist"), ("4.2", "wrist"), ("4.2", "regulator")])
def test_a_command_outside_its_range_is_warned_of(write_csv, cell, stage):
    path = write_csv(rows=rows_with(1, 4, cell))
    assert warning(load_recording, path, stage=stage) == (
        f"{path}: row 4, column 'command_V': command {cell} V is outside 0 to 4 V (1 of 8 rows); "
        "if its unit is not volts, map it with a scale"
    )


@pytest.mark.parametrize(("volts", "kilopascals"), [(3.0, 0.0), (0.0, 150.0)])
def test_an_angle_in_radians_is_warned_of(write_csv, volts, kilopascals):
    rows = [
        [f"{i / 100}", f"{volts * i / 7}", f"{0.1 * i:.1f}", f"{50 + kilopascals * i / 7}"] for i in range(8)
    ]
    path = write_csv(rows=rows)
    assert warning(load_recording, path) == (
        f"{path}: column 'angle_deg': the angle stays within 0.7 deg, which looks like radians; "
        "map it with scale = 57.29578"
    )
    load_recording(path, {"angle_deg": {"name": "angle_deg", "scale": 57.29578}})


def test_angles_in_radians_of_a_rig_without_a_file_are_warned_of(write_csv, tmp_path):
    for name in ("a.csv", "b.csv"):
        write_csv(
            rows=[[f"{i / 100}", f"{i / 2}", f"{0.1 * i:.1f}", f"{10 * i}"] for i in range(8)], name=name
        )
    (tmp_path / "campaign.toml").write_text(
        'axis = "bend"\nsample_time_s = 0.01\nfit = ["a.csv"]\nvalidate = ["b.csv"]\n'
    )
    assert warning(load_campaign, tmp_path) == (
        f"{tmp_path}: the angle stays within 0.7 deg in every recording, which looks like radians; "
        "map it with scale = 57.29578"
    )


def test_a_small_angle_under_small_commands_is_no_radian(write_csv):
    rows = [[f"{i / 100}", f"{2 + i / 10}", f"{0.1 * i:.1f}", f"{100 + i}"] for i in range(8)]
    assert load_recording(write_csv(rows=rows)).angle[-1] == pytest.approx(0.7)


@pytest.mark.parametrize(("cell", "problem"), [("idle", "'idle' is not a number"), ("", "the cell is empty")])
def test_a_further_column_that_is_not_numeric_is_dropped_with_a_warning(write_csv, cell, problem):
    path = write_csv(rows=rows_with(3, 3, cell), header=(*HEADER[:3], "mode"))
    assert warning(load_recording, path) == (
        f"{path}: row 3, column 'mode': {problem}; the column is dropped"
    )
