"""What microcontrollers and their sensors log: millis, counts of a converter, hPa, quaternions, mm."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from plants.errors import InputError
from plants.measured.campaigns.campaign import load_campaign, load_recording
from plants.measured.formats.columns import ATMOSPHERE
from plants.measured.importing.importing import import_logs, write_campaign

EXAMPLE = Path(__file__).parents[2] / "plants/measured/examples/flexion"
STEPS = load_recording(EXAMPLE / "steps.csv").until(30.0)
USUAL = {"u_V": STEPS.command, "angle_deg": STEPS.angle}
ABOVE = 101.0 + np.maximum(STEPS.pressure - STEPS.pressure[0], 0.0)
"""A pressure [kPa] above vacuum that never falls below that of the air."""


def imported(folder, columns):
    """What an import makes of columns, and the recording that its campaign holds."""
    pd.DataFrame(columns).to_csv(folder / "log.csv", index=False)
    made = import_logs([folder / "log.csv"], {})
    write_campaign(made, "bend", folder / "out")
    with pytest.warns(match="only one recording"):
        return made.roles, load_campaign(folder / "out").validate[0]


@pytest.mark.parametrize("later", [0.02, 7000.0])
def test_a_second_clock_in_the_columns_of_a_file_has_its_own_channels(tmp_path, later):
    """A camera of 30 Hz beside rows of 10 ms: its columns end earlier, and its rows are not theirs.  Where it
    counts from another moment the two begin together."""
    seen = np.arange(0.0, STEPS.time[-1] - 0.05, 1.0 / 30.0)
    angle = np.interp(seen, STEPS.time, STEPS.angle)
    rest = len(STEPS.time) - len(seen)
    columns = {
        "DAQ time (s)": STEPS.time, "u (V)": STEPS.command, "p (kPa)": STEPS.pressure,
        "Camera time (s)": np.append(seen + later, np.full(rest, np.nan)),
        "Bending angle (deg)": np.append(angle, np.full(rest, np.nan)),
    }  # fmt: skip
    _, found = imported(tmp_path, columns)
    moved = seen + (later if later < 1.0 else 0.0)
    expected = np.interp(found.time + moved[0], moved, angle)
    np.testing.assert_allclose(found.angle, expected, atol=0.02)
    assert found.time[-1] > 0.99 * moved[-1] - 0.1


def test_a_folder_of_such_files_is_for_wrist_import(tmp_path):
    half = np.append(STEPS.time[::2], np.full(len(STEPS.time) // 2, np.nan))[: len(STEPS.time)]
    columns = {"time": STEPS.time, "camera time": half} | USUAL
    pd.DataFrame(columns).to_csv(tmp_path / "log.csv", index=False)
    with pytest.raises(InputError, match="wrist import"):
        load_campaign(tmp_path)


@pytest.mark.parametrize(("header", "unit"), [("enc [counts]", "counts"), ("Weg [µm]", "um"), ("x_um", "um")])
def test_a_motion_in_counts_or_micrometres_stays_so(tmp_path, header, unit):
    roles, found = imported(tmp_path, {"time": STEPS.time, "u_V": STEPS.command, header: 40.0 * STEPS.angle})
    assert roles["angle"].unit == unit
    np.testing.assert_allclose(found.angle, 40.0 * STEPS.angle)


@pytest.mark.parametrize("header", ["enc_cnt", "encoder_counts", "EncCnt", "enc [pulses]", "enc_ticks"])
def test_an_angle_that_is_called_counts_stays_so_and_is_told_how_to_convert(tmp_path, header):
    """By its range alone 185 counts to either side would be degrees."""
    counts = np.round(12.0 * STEPS.angle)
    roles, found = imported(tmp_path, {"time": STEPS.time, "u_V": STEPS.command, header: counts})
    assert roles["angle"].unit == "counts"
    np.testing.assert_allclose(found.angle, counts)
    folder = tmp_path / "out"
    lines = (folder / "campaign.toml").read_text().splitlines()
    (angle,) = (line for line in lines if line.startswith("angle_deg"))
    advised = re.search(r"; (\{.*\}) gives it in deg", angle)[1].replace("COUNTS_PER_TURN", "4096")
    lines[lines.index(angle)] = f"angle_deg = {advised}"
    (folder / "campaign.toml").write_text("\n".join(lines))
    with pytest.warns(match="only one recording"):
        converted = load_campaign(folder).validate[0]
    np.testing.assert_allclose(converted.angle, found.angle * 360.0 / 4096)


def test_a_pressure_that_is_asked_for_is_the_command(tmp_path):
    columns = {"t": STEPS.time, "dp_ref [bar]": STEPS.command, "dp [bar]": STEPS.pressure / 100.0}
    roles, _ = imported(tmp_path, columns | {"enc [counts]": np.round(40.0 * STEPS.angle)})
    assert [roles[r].channel for r in ("command", "pressure", "angle")] == ["dp_ref", "dp", "enc"]


@pytest.mark.parametrize("asked", ["pset_flex [bar]", "Pd_flex [bar]", "p1_des [bar]", "pd1", "p1_des"])
def test_beside_the_reference_of_an_angle_a_pressure_that_is_asked_for_is_the_command(tmp_path, asked):
    reference = np.roll(np.round(STEPS.angle), -30)
    columns = {"t": STEPS.time, "q_ref": reference, "q_enc": STEPS.angle, asked: STEPS.command}
    measured = {"P_flex [bar]": STEPS.pressure / 100.0, "P_ext [bar]": 2.0 - STEPS.pressure / 100.0}
    roles, _ = imported(tmp_path, columns | measured)
    assert asked.startswith(roles["command"].channel)
    assert (roles["reference"].channel, roles["angle"].channel) == ("q_ref", "q_enc")
    assert roles["pressure"].channel == "P_flex"


@pytest.mark.parametrize(("unit", "per_kpa"), [("mbar abs", 10.0), ("psia", 1.0 / 6.894757293168)])
def test_a_unit_may_say_that_a_pressure_counts_from_vacuum(tmp_path, unit, per_kpa):
    columns = {"time": STEPS.time, f"p_ist [{unit}]": per_kpa * ABOVE} | USUAL
    roles, found = imported(tmp_path, columns)
    assert roles["pressure"].absolute
    np.testing.assert_allclose(found.pressure, ABOVE - ATMOSPHERE, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "per_second"),
    [("millis", 1e3), ("ms", 1e3), ("time_ms", 1e3), ("t_millis", 1e3), ("timestamp_us", 1e6),
     ("micros", 1e6), ("seconds", 1.0)],
)  # fmt: skip
def test_a_time_is_known_by_its_unit(tmp_path, name, per_second):
    _, found = imported(tmp_path, {name: np.round(per_second * (5.0 + STEPS.time), 6)} | USUAL)
    np.testing.assert_allclose(found.time, STEPS.time, atol=1e-6)


def test_a_command_in_whole_numbers_may_be_counts(tmp_path):
    counts = np.round(1000.0 * STEPS.command)
    roles, _ = imported(tmp_path, {"time": STEPS.time, "dac": counts, "angle_deg": STEPS.angle})
    assert '{name = "dac", counts = 4095, full = 10.0} says that 4095 are 10 V' in roles["command"].why


def test_a_pressure_in_hpa_that_starts_at_that_of_the_air_counts_from_vacuum(tmp_path):
    columns = {"time": STEPS.time, "p_hPa": 10.0 * ABOVE} | USUAL
    roles, found = imported(tmp_path, columns)
    assert roles["pressure"].absolute
    np.testing.assert_allclose(found.pressure, ABOVE - ATMOSPHERE, atol=1e-9)


def test_of_another_pressure_that_starts_there_it_is_asked(tmp_path):
    roles, found = imported(tmp_path, {"time": STEPS.time, "p_bar": ABOVE / 100.0} | USUAL)
    assert not roles["pressure"].absolute
    assert 'add unit = "bar", absolute = true if above vacuum' in roles["pressure"].why
    np.testing.assert_allclose(found.pressure, ABOVE)


def test_a_vacuum_that_deepens_with_a_duty_in_percent_needs_no_hand(tmp_path):
    pressure = -np.maximum(STEPS.pressure - STEPS.pressure[0], 0.0)
    columns = {
        "time": STEPS.time,
        "duty_pct": 25.0 * STEPS.command,
        "P_kPa": pressure,
        "angle_deg": STEPS.angle,
    }
    roles, found = imported(tmp_path, columns)
    assert roles["command"][1:3] == ("%", 1.0)
    assert "a vacuum that deepens" in roles["pressure"].why
    assert " %, 29.9" in (tmp_path / "out/campaign.toml").read_text()
    np.testing.assert_allclose(found.pressure, -pressure)


def test_a_pressure_that_is_called_absolute_counts_from_vacuum_wherever_it_starts(tmp_path):
    columns = {"time": STEPS.time, "p_abs_bar": (60.0 + ABOVE) / 100.0} | USUAL
    roles, found = imported(tmp_path, columns)
    assert roles["pressure"].absolute
    np.testing.assert_allclose(found.pressure, 60.0 + ABOVE - ATMOSPHERE)


def test_an_absolute_vacuum_that_deepens_is_counted_below_the_air(tmp_path):
    below = np.maximum(STEPS.pressure - STEPS.pressure[0], 0.0) / 3.0
    columns = {"time": STEPS.time, "duty_pct": 25.0 * STEPS.command, "p_kPa": 101.0 - below}
    _, found = imported(tmp_path, columns | {"angle_deg": STEPS.angle})
    np.testing.assert_allclose(found.pressure, below + ATMOSPHERE - 101.0, atol=1e-9)


@pytest.mark.parametrize(("column", "per_second", "turn"), [("t_us", 1e6, 2**32), ("millis", 1e3, 2**16)])
def test_a_counter_that_begins_again_counts_on(tmp_path, column, per_second, turn):
    counted = (np.round(per_second * STEPS.time) + turn - 7e3) % turn
    assert np.any(np.diff(counted) < 0.0)
    _, found = imported(tmp_path, {column: counted} | USUAL)
    np.testing.assert_allclose(found.time, STEPS.time, atol=1e-6)


def test_orientations_of_all_recordings_turn_about_one_axis(tmp_path):
    """A run that goes the other way from its start has the sign of the run that goes farthest."""
    far = Rotation.from_rotvec(np.outer(np.radians(40.0 * np.sin(STEPS.time)), [0.0, 0.6, 0.8]))
    near = Rotation.from_rotvec(np.outer(np.radians(-25.0 * np.sin(STEPS.time[:2000]) ** 2), [0.0, 0.6, 0.8]))
    for name, seen in (("far", far), ("near", near)):
        parts = dict(zip(("q_x", "q_y", "q_z", "q_w"), seen.as_quat().T, strict=True))
        rows = slice(0, len(seen))
        columns = {"time_s": STEPS.time[rows], "command_V": STEPS.command[rows]} | parts
        pd.DataFrame(columns).to_csv(tmp_path / f"{name}.csv", index=False)
    (tmp_path / "campaign.toml").write_text(
        'axis = "bend"\nsample_time_s = 0.01\nfit = ["near.csv"]\nvalidate = ["far.csv"]\n'
        '[columns]\nangle_deg = {quaternion = ["q_w", "q_x", "q_y", "q_z"]}\n'
    )
    near_run, far_run = load_campaign(tmp_path).recordings
    way = np.sign(far_run.angle[100])
    np.testing.assert_allclose(way * far_run.angle, 40.0 * np.sin(STEPS.time), atol=1e-6)
    np.testing.assert_allclose(way * near_run.angle, -25.0 * np.sin(STEPS.time[:2000]) ** 2, atol=1e-6)


def test_four_columns_of_a_quaternion_are_an_angle(tmp_path):
    seen = Rotation.from_rotvec(np.outer(np.radians(STEPS.angle), [0.0, 0.6, 0.8])).as_quat()
    seen[500:505] = np.nan
    parts = dict(zip(("q_x", "q_y", "q_z", "q_w"), seen.T, strict=True))
    roles, found = imported(tmp_path, {"time": STEPS.time, "u_V": STEPS.command} | parts)
    assert roles["angle"].entry() == {"quaternion": ["q_w", "q_x", "q_y", "q_z"]}
    there = found.fresh("angle_deg")
    assert np.flatnonzero(~there).tolist() == [*range(500, 505)]
    moved = STEPS.angle[0] - STEPS.angle  # counted upwards where it turns most
    np.testing.assert_allclose(found.angle[there], moved[there], atol=1e-6)


def test_a_motion_in_mm_stays_in_mm(tmp_path):
    columns = {"time": STEPS.time, "u_V": STEPS.command, "pos_mm": STEPS.angle}
    roles, _ = imported(tmp_path, columns)
    assert roles["angle"][:3] == ("pos_mm", "mm", 1.0)


def test_values_between_those_of_a_sensor_are_in_its_steps(tmp_path):
    """A log with rows closer than those of another is put on rows as far apart; a step of 0.05 deg stays one
    of 0.05 deg."""
    angle = 0.05 * np.rint(STEPS.angle / 0.05)
    slow = 0.016 * np.arange(1800)
    at = np.searchsorted(STEPS.time, slow)
    fast_log = {"time": STEPS.time, "u_V": STEPS.command, "angle_deg": angle}
    slow_log = {"time": slow, "u_V": STEPS.command[at], "angle_deg": angle[at]}
    for name, columns in (("fast", fast_log), ("slow", slow_log)):
        pd.DataFrame(columns).to_csv(tmp_path / f"{name}.csv", index=False)
    run = import_logs([tmp_path / "fast.csv", tmp_path / "slow.csv"], {}).runs[0]
    assert not np.isin(np.round(run.time, 6), np.round(STEPS.time, 6)).all()
    in_steps = run.values["angle_deg"] / 0.05
    np.testing.assert_allclose(in_steps, np.rint(in_steps), atol=1e-6)
