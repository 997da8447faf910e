"""Every command does what its help says, in the exit codes and JSON keys that others read."""

import json
import re
import shlex
from pathlib import Path

import pytest

from design.cli.app import MODULES as COMMANDS
from plants.parameters.files import built_in, load

ROOT = Path(__file__).parents[2]
MODULES = {m.NAME: m for m in COMMANDS}


@pytest.mark.parametrize("name", MODULES)
def test_help_carries_an_example(wrist, name):
    outcome = wrist(name, "--help")
    assert outcome.code == 0
    assert f"wrist {name}" in outcome.out.replace("\n", " ")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["show", "simulate", "fit", "tune"])
def test_the_example_of_the_help_runs(wrist, name, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plants").symlink_to(ROOT / "plants")
    line = MODULES[name].EXAMPLE.removeprefix("Example: wrist ")
    arguments = shlex.split(line)
    if name == "tune":  # the same line on a coarser map
        arguments += ["--plain", "--points", "8", "--starts", "1"]
    outcome = wrist(*arguments)
    assert outcome.code == 0, outcome.err


def test_show_gives_every_value_with_unit_and_provenance(wrist):
    shown = wrist("show", "--axis", "deviation", "--json", "-").json
    assert set(shown) == set(built_in("flexion").parameters)
    assert shown["s"]["value"] == 0.0557
    assert shown["s"]["unit"] == "deg/kPa"
    assert shown["s"]["provenance"]["kind"] == "stated"
    assert shown["Tw"]["provenance"]["kind"] == "assumed"


def test_show_marks_what_is_assumed(wrist):
    out = wrist("show").out
    marked = re.findall(r"^\? (\w+)\s+[\d.]", out, re.M)
    assert marked == built_in("flexion").assumed


def test_simulate_open_loop_reaches_the_stated_steady_state(wrist):
    result = wrist("simulate", "--volts", "2", "--duration", "30", "--json", "-").json
    assert result["pressure_kPa"][-1] == pytest.approx(98.8, abs=0.01)  # 49.4 kPa/V, section 3


def test_simulate_closed_loop_gives_metrics(wrist):
    result = wrist("simulate", "--gains", "1.2,2.2", "--json", "-").json
    assert 5.0 < result["metrics"]["settling_time_s"] < 8.0  # how slow the paper reads
    assert result["angle_deg"][-1] == pytest.approx(15.0, abs=0.3)


def test_simulate_plays_a_recording(wrist):
    path = ROOT / "plants/measured/examples/flexion/task.csv"
    result = wrist("simulate", "--recording", path, "--json", "-").json
    assert len(result["angle_deg"]) == len(result["measured_angle_deg"]) == 2400


def test_json_to_stdout_is_all_there_is_on_stdout(wrist):
    outcome = wrist("simulate", "--json", "-")
    json.loads(outcome.out)
    assert "3 V for 10 s" in outcome.err


@pytest.mark.slow
def test_fit_saves_a_set_that_the_other_commands_take(wrist, tmp_path):
    path = tmp_path / "fitted.toml"
    outcome = wrist(
        "fit", ROOT / "plants/measured/examples/flexion", "--save", path, "--starts", "1", "--json", "-"
    )
    assert outcome.code == 0
    fitted = load(path)
    assert outcome.json["parameters"]["a1"]["value"] == pytest.approx(fitted.values["a1"])
    shown = wrist("show", "--plant", path, "--json", "-").json
    assert shown["a1"]["provenance"]["kind"] == "fitted"
    assert shown["a1"]["provenance"]["std_error"] > 0.0
    assert wrist("simulate", "--plant", path).code == 0


@pytest.mark.slow
def test_tune_answers_with_the_keys_that_others_read(wrist):
    result = wrist("tune", "--plain", "--points", "8", "--starts", "1", "--json", "-").json
    metrics = {"settling_time_s", "overshoot_percent", "iae_deg_s", "itae_deg_s2", "Ms"}
    assert metrics <= set(result["metrics"])
    assert {"Kp", "Ki", "units", "worst_case", "active_constraint", "optimality"} <= set(result)
    assert result["scenarios"] <= 96


@pytest.mark.slow
def test_tune_says_no_with_the_limit_and_the_scenario(wrist):
    outcome = wrist("tune", "--plain", "--points", "6", "--starts", "1", "--variation", "0.1", "--json", "-")
    assert outcome.code == 1
    assert "total_variation_V" in outcome.json["refusal"]
    assert re.search(r"deg from (virgin|line1|line2|inside), .* plant", outcome.json["refusal"])


def test_tune_says_no_where_the_task_is_out_of_reach(wrist, tmp_path):
    text = (ROOT / "plants/parameters/flexion.toml").read_text().replace("value = 0.36", "value = 0.19")
    weak = tmp_path / "weak.toml"
    weak.write_text(text)
    outcome = wrist("tune", "--plain", "--plant", weak, "--points", "6", "--starts", "1")
    assert outcome.code == 1
    assert "command range" in outcome.out


@pytest.mark.slow
def test_corners_of_no_size_leave_only_the_nominal_plant(wrist):
    wide = wrist("tune", "--plain", "--points", "8", "--starts", "1", "--json", "-").json
    none = wrist(
        "tune", "--plain", "--corners", "0,0,0", "--points", "8", "--starts", "1", "--json", "-"
    ).json
    worst = "each_metric_over_all_scenarios"
    assert none["worst_case"]["iae_deg_s"] < wide["worst_case"]["iae_deg_s"]
    assert none["worst_case"][worst]["overshoot_percent"] <= 5.0


@pytest.mark.parametrize("number", [5, 6, 8, 10, 11, 12, 13, 14, 15])
def test_every_figure_of_the_paper_is_redrawn(wrist, tmp_path, number):
    outcome = wrist("simulate", "--figure", number, "--out", tmp_path, "--json", "-")
    assert outcome.code == 0, outcome.err
    assert (tmp_path / f"figure-{number:02d}.png").stat().st_size > 10_000
    assert "not available" in outcome.json["caption"]
