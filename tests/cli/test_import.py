"""``wrist import`` lists channels, says what it took them for, and writes a campaign that ``wrist`` loads."""

from pathlib import Path

import pandas as pd
import pytest

EXAMPLE = Path(__file__).parents[2] / "plants/measured/examples/flexion"


def test_the_command_says_what_it_decided(wrist, tmp_path):
    out = tmp_path / "rig"
    told = wrist("import", EXAMPLE / "steps.csv", EXAMPLE / "sine.csv", "--axis", "flexion", "--out", out,
                 "--json", tmp_path / "it.json")  # fmt: skip
    assert told.code == 0, told.err
    assert "angle_deg  deg" in told.out
    assert "command: command_V [V], by its name, leads the pressure" in told.out
    assert {p.name for p in out.iterdir()} == {"steps.csv", "sine.csv", "campaign.toml"}


def test_channels_that_fill_no_role_are_told(wrist, tmp_path):
    rows = pd.read_csv(EXAMPLE / "steps.csv")
    second = {"cmd_B_V": 4.0 - rows.command_V, "pB_psi": 20.0 - 0.1 * rows.pressure_kPa}
    rows.assign(other_pressure_kPa=50.0 + rows.time_s, **second).to_csv(tmp_path / "log.csv", index=False)
    told = wrist("import", tmp_path / "log.csv", "--out", tmp_path / "rig")
    assert told.code == 0, told.err
    line = "not used in the fit: 'cmd_B_V', 'pB_psi'"
    assert line in told.out.splitlines()
    assert f"# {line}" in (tmp_path / "rig" / "campaign.toml").read_text().splitlines()
    alone = wrist("import", EXAMPLE / "steps.csv", "--out", tmp_path / "alone")
    assert "not used" not in alone.out + (tmp_path / "alone" / "campaign.toml").read_text()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nowhere.csv"], "nowhere.csv: no such file"),
        ([EXAMPLE / "steps.csv", "--map", "u"], "--map: 'u' is not ROLE=CHANNEL"),
        ([EXAMPLE / "steps.csv", "--map", "angle=phi"], "no such channel"),
        ([EXAMPLE / "steps.csv", "--map", "angle=angle_deg [bar]"], "none of angle"),
    ],
)
def test_bad_input_is_refused_in_a_line_and_nothing_is_written(wrist, tmp_path, words, message):
    told = wrist("import", *words, "--out", tmp_path / "c")
    assert told.code == 2
    assert message in told.err
    assert told.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
