"""``wrist import`` lists channels, says what it took them for, and writes a campaign that ``wrist`` loads."""

from pathlib import Path

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
