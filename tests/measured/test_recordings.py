"""Good recordings load as what they are, whatever they are written in."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from plants.errors import InputWarning
from plants.measured.campaigns.campaign import load_campaign, load_recording, shipped
from reports.shared.html import SYNTHETIC, remark_on

DECLARATION = 'axis = "flexion"\nsample_time_s = 0.01\nfit = ["steps.csv"]\nvalidate = ["sine.csv"]\n'
TIME = np.arange(8) * 0.01


def test_a_recording_has_its_columns_in_any_order(write_csv):
    rows = [[f"{100 + i}", f"{i}", "2.0", f"{i / 100:.2f}", f"{3 * i}"] for i in range(8)]
    r = load_recording(
        write_csv(rows=rows, header=("pressure_kPa", "angle_deg", "command_V", "time_s", "T_C"))
    )
    np.testing.assert_allclose(r.time, TIME)
    np.testing.assert_array_equal(r.angle, np.arange(8.0))
    np.testing.assert_array_equal(r.pressure, 100 + np.arange(8.0))
    np.testing.assert_array_equal(r.command, np.full(8, 2.0))
    np.testing.assert_array_equal(r.extra["T_C"], 3 * np.arange(8.0))
    assert (r.name, r.reference, r.other_pressure, list(r.extra)) == ("steps.csv", None, None, ["T_C"])


def test_every_standard_column_has_its_place(write_csv):
    names = ("time_s", "command_V", "angle_deg", "pressure_kPa", "reference_deg", "other_pressure_kPa")
    rows = [[f"{i / 100}", "1", "2", "3", "4", "5"] for i in range(8)]
    r = load_recording(write_csv(rows=rows, header=names))
    got = [x[0] for x in (r.command, r.angle, r.pressure, r.reference, r.other_pressure)]
    assert got == [1, 2, 3, 4, 5]
    assert all(x.dtype == np.float64 and x.shape == (8,) for x in (r.time, r.command, r.reference))


def test_a_byte_order_mark_is_no_part_of_the_first_name(write_csv):
    path = write_csv()
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    np.testing.assert_allclose(load_recording(path).time, TIME)


@pytest.mark.parametrize("separator", [";", "\t"])
@pytest.mark.parametrize("decimal", [",", "."])
def test_semicolons_tabs_and_decimal_commas_are_understood(write_csv, separator, decimal):
    path = write_csv(separator=separator)
    path.write_text(path.read_text().replace(".", decimal))
    r = load_recording(path)
    np.testing.assert_allclose(r.time, TIME)
    np.testing.assert_allclose(r.pressure, 100 + 50 * TIME)


def test_quotes_blank_lines_and_windows_line_ends_do_no_harm(write_csv):
    path = write_csv(header=('"time_s"', '"command_V"', ' "angle_deg"', '"pressure, measured"'))
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n") + b"\r\n,,,\r\n\r\n")
    r = load_recording(path, {"pressure_kPa": "pressure, measured"})
    np.testing.assert_allclose(r.pressure, 100 + 50 * TIME)


def test_mapped_columns_are_scaled_and_shifted(write_csv):
    path = write_csv(header=("Time", "Setpoint", "theta", "Pressure"))
    columns = {
        "time_s": "Time",
        "command_V": {"name": "Setpoint", "scale": 0.5, "offset": 0.25},
        "angle_deg": {"name": "theta", "scale": 57.29578},
    }
    r = load_recording(path, columns)
    np.testing.assert_allclose(r.command, 0.5 * (2 + TIME) + 0.25)
    np.testing.assert_allclose(r.angle, 57.29578 * 10 * TIME)
    assert r.pressure is None
    assert list(r.extra) == ["Pressure"]


def test_a_mapping_wins_over_a_column_that_has_the_standard_name(write_csv):
    path = write_csv(header=("time_s", "command_V", "angle_deg", "theta"))
    with pytest.warns(InputWarning, match=r"steps\.csv: column 'angle_deg' is ignored"):
        r = load_recording(path, {"angle_deg": "theta"})
    np.testing.assert_allclose(r.angle, 100 + 50 * TIME)
    assert not r.extra


def test_jitter_and_a_skipped_row_are_no_gap(write_csv):
    times = [0.0, 0.02, 0.041, 0.061, 0.082, 0.122, 0.143, 0.163]
    rows = [[f"{t}", "2", "0", "100"] for t in times]
    assert len(load_recording(write_csv(rows=rows), sample_time=0.02).time) == 8


def test_a_file_that_logged_a_channel_twice_offers_it_once(write_csv):
    rows = [[f"{t:.2f}", "2", f"{t:.2f}", f"{100 * t:.2f}"] for t in TIME]
    r = load_recording(write_csv(rows=rows, header=("time_s", "command_V", "clock", "angle_deg")))
    assert not r.extra


def test_parquet_gives_what_csv_gives(write_csv, tmp_path: Path):
    import pyarrow
    import pyarrow.parquet

    r = load_recording(write_csv())
    columns = {"time_s": r.time, "command_V": r.command, "angle_deg": r.angle, "on": r.time > 0.02}
    pyarrow.parquet.write_table(pyarrow.table(columns), tmp_path / "steps.parquet")
    p = load_recording(tmp_path / "steps.parquet")
    np.testing.assert_array_equal(p.time, r.time)
    np.testing.assert_array_equal(p.angle, r.angle)
    np.testing.assert_array_equal(p.extra["on"], r.time > 0.02)
    assert p.name == "steps.parquet"


def test_a_campaign_holds_what_its_file_says(campaign):
    folder = campaign()
    c = load_campaign(folder)
    assert (c.name, c.axis, c.stage, c.start) == (folder.name, "flexion", "wrist", "rest")
    assert c.sample_time == 0.01
    assert [r.name for r in c.fit + c.validate] == ["steps.csv", "sine.csv"]
    assert load_campaign(str(folder)).checksum == c.checksum


def test_a_regulator_campaign_needs_no_angle(campaign, write_csv):
    columns = (
        '[columns]\ntime_s = "Time"\ncommand_V = {name = "Target", scale = 0.02}\npressure_kPa = "Pressure"\n'
    )
    folder = campaign(DECLARATION + 'stage = "regulator"\nstart = "unknown"\n' + columns)
    for name in ("steps.csv", "sine.csv"):
        write_csv(name, header=("Time", "Target", "PWM", "Pressure"))
    c = load_campaign(folder)
    assert (c.stage, c.start) == ("regulator", "unknown")
    assert c.fit[0].angle is None
    np.testing.assert_allclose(c.fit[0].command, 0.02 * (2 + TIME))
    assert list(c.fit[0].extra) == ["PWM"]


def test_a_mapped_setpoint_may_be_in_the_closed_loop_runs_alone(campaign, write_csv):
    folder = campaign(DECLARATION + '[columns]\nreference_deg = "ref"\n')
    write_csv("sine.csv", header=("time_s", "command_V", "angle_deg", "ref"))
    c = load_campaign(folder)
    assert c.fit[0].reference is None
    assert c.validate[0].reference is not None


def test_the_checksum_is_of_the_contents_whatever_the_order(campaign, write_csv):
    declaration = DECLARATION.replace('["steps.csv"]', '["steps.csv", "more.csv"]')
    write_csv("more.csv")
    first = load_campaign(campaign(declaration)).checksum
    assert len(first) == 64
    assert load_campaign(campaign(declaration + "# a note\n")).checksum != first
    rows = [[f"{t:.2f}", "2.5", "0", "100"] for t in TIME]
    folder = campaign(declaration)
    write_csv("more.csv", rows=rows)
    assert load_campaign(folder).checksum != first
    write_csv("more.csv")
    assert load_campaign(folder).checksum == first


def test_the_campaigns_that_ship_are_found_and_told_as_synthetic():
    """Wherever the module stands that looks for them."""
    assert [f.name for f in shipped()] == ["deviation", "flexion"]
    flexion = load_campaign(shipped()[1])
    assert flexion.axis == "flexion"
    assert remark_on({"flexion": flexion.checksum[:12]}) == SYNTHETIC
    assert remark_on({"flexion": "0" * 12}) == ""


def test_the_readers_of_rare_formats_load_when_they_are_needed():
    code = (
        "import plants.measured.campaigns.campaign, sys; print([m for m in "
        "('pandas', 'pyarrow', 'pymatreader', 'h5py') if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"
