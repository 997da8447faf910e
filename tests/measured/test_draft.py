"""A folder that holds logs and no campaign.toml is answered with a draft that loads."""

import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from design.cli.errors import answered
from plants.errors import InputError
from plants.measured.campaigns.campaign import load_campaign, load_recording
from plants.measured.campaigns.draft import draft
from plants.measured.importing.importing import import_logs
from plants.measured.importing.roles import ROLES

EXAMPLE = Path(__file__).parents[2] / "plants/measured/examples/flexion"


@pytest.fixture
def logs(tmp_path):
    """Two logs with names of a recorder's own."""
    t = np.arange(300) * 0.02
    for name, phase in (("run1.csv", 0.0), ("run2.csv", 1.0)):
        command, bend = 1000 + 500 * np.sin(t + phase), 30 * np.cos(t)
        frame = {"Timestamp": t, "DAC": command, "P_bar": np.sin(t), "bend": bend}
        pd.DataFrame(frame).to_csv(tmp_path / name, index=False)
    return tmp_path


def test_the_draft_loads_as_it_is(logs):
    with pytest.raises(InputError, match=r"holds no campaign\.toml; correct the draft") as refused:
        load_campaign(logs)
    draft = tomllib.loads(refused.value.draft)
    assert draft["columns"] == {
        "time_s": "Timestamp", "command_V": "DAC", "pressure_kPa": {"name": "P_bar", "scale": 100.0},
        "angle_deg": "bend",
    }  # fmt: skip
    assert draft["sample_time_s"] == pytest.approx(0.02)
    assert (draft["fit"], draft["validate"]) == (["run1.csv"], ["run2.csv"])
    (logs / "campaign.toml").write_text(refused.value.draft)
    campaign = load_campaign(logs)
    assert campaign.fit[0].command.max() == pytest.approx(1500.0, abs=1.0)


def test_the_command_says_it_in_a_line_and_prints_the_draft(logs, capsys):
    assert answered(["fit", str(logs)]) == 2
    said = capsys.readouterr()
    assert said.err.count("\n") == 1
    assert tomllib.loads(said.out)["start"] == "unknown"


def test_a_folder_without_logs_has_no_draft(tmp_path, capsys):
    assert answered(["fit", str(tmp_path)]) == 2
    assert capsys.readouterr().out == ""


def drafted(folder):
    """The draft of a folder, saved there, and the campaign that it makes."""
    advice, said = draft(folder)
    assert advice == "correct the draft and save it there"
    (folder / "campaign.toml").write_text(said)
    return tomllib.loads(said), load_campaign(folder)


STEPS = load_recording(EXAMPLE / "steps.csv").until(30.0)
SINE = load_recording(EXAMPLE / "sine.csv").until(30.0)


def test_a_draft_has_the_units_that_an_import_reads(tmp_path):
    for name, r in (("steps.csv", STEPS), ("sine.csv", SINE)):
        bent = np.radians(r.angle)
        columns = {"t [ms]": 1e3 * r.time, "u": r.command, "dp_bar": r.pressure / 100, "theta_rad": bent}
        pd.DataFrame(columns).to_csv(tmp_path / name, index=False)
    said, campaign = drafted(tmp_path)
    assert said["columns"]["time_s"] == {"name": "t [ms]", "scale": 0.001}
    assert said["sample_time_s"] == 0.01
    logged = {r.name: r for r in campaign.recordings}
    np.testing.assert_allclose(logged["steps.csv"].angle, STEPS.angle, atol=1e-6)
    np.testing.assert_allclose(logged["steps.csv"].pressure, STEPS.pressure, atol=1e-6)
    made = import_logs([tmp_path / "steps.csv", tmp_path / "sine.csv"], {})
    assert {r: f.entry() for r, f in made.roles.items()} == {
        r: said["columns"][column] for r, column in ROLES.items() if column in said["columns"]
    }


@pytest.mark.filterwarnings("ignore:.*only one recording")
def test_texts_are_logs_and_others_are_left_out(tmp_path):
    columns = {"millis": np.round(1e3 * STEPS.time), "dac_V": STEPS.command, "pos_mm": STEPS.angle}
    pd.DataFrame(columns).to_csv(tmp_path / "r1.txt", index=False, sep="\t")
    (tmp_path / "README.txt").write_text("What was logged.\n")
    said, campaign = drafted(tmp_path)
    assert said["columns"] == {
        "time_s": {"name": "millis", "scale": 0.001}, "command_V": "dac_V",
        "angle_deg": {"name": "pos_mm", "unit": "mm"},
    }  # fmt: skip
    assert said["fit"] == ["r1.txt"]
    np.testing.assert_allclose(campaign.validate[0].time, STEPS.time)
    assert "# README.txt is left out: " in draft(tmp_path)[1]


def test_logs_that_cannot_be_read_as_they_are_are_to_be_imported(tmp_path):
    rows = [f"{t:g};{u:g};{y:g}".replace(".", ",") for t, u, y in zip(STEPS.time, STEPS.command, STEPS.angle,
                                                                     strict=True)]  # fmt: skip
    (tmp_path / "log.csv").write_bytes("\n".join(["Zeit [s];u [V];Winkel [°]", *rows]).encode("cp1252"))
    with pytest.raises(InputError, match=r"its logs need converting: wrist import .*/\*\.csv --out NEW"):
        load_campaign(tmp_path)


@pytest.mark.parametrize("name", ['x; system("ls")', "<script>", 'q"uo,te;', "[rig]"])
@pytest.mark.filterwarnings("ignore:.*only one recording")
def test_names_of_columns_do_nothing_but_name(tmp_path, name):
    columns = {"time": STEPS.time, "u": STEPS.command, name: STEPS.angle, f"{name} bar": STEPS.pressure / 100}
    pd.DataFrame(columns).to_parquet(tmp_path / "log.parquet")
    said, campaign = drafted(tmp_path)
    assert set(said) == {"axis", "start", "sample_time_s", "fit", "columns"}
    assert f"{name} bar" in str(said["columns"]["pressure_kPa"]["name"])
    assert len(campaign.validate[0].time) == len(STEPS.time)


def test_names_that_no_toml_holds_are_to_be_imported(tmp_path):
    columns = {"time": STEPS.time, "u": STEPS.command, "\x1b[31mred\n": STEPS.angle}
    pd.DataFrame(columns).to_parquet(tmp_path / "log.parquet")
    advice, said = draft(tmp_path)
    assert "wrist import" in advice
    assert said is None
