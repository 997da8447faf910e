"""``wrist simulate --scenario`` plays a saved worst case again and shows the metrics that were saved."""

import json

import pytest

from design.controllers.pi import PI
from design.robustness.box import box_of
from design.robustness.samples.adversary import worst_case
from design.robustness.samples.scenario_file import save
from plants.files import json_text
from plants.parameters.files import built_in


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    path = tmp_path_factory.mktemp("scenario") / "worst.toml"
    found = worst_case(
        box_of(built_in("flexion")), PI(2.9, 8.8), dead_time=0.03, load=1.0, budget=64, duration=2.0
    )
    save(found, path)
    return found, path


def test_the_metrics_are_those_saved(wrist, saved):
    found, path = saved
    outcome = wrist("simulate", "--scenario", path, "--json", "-")
    assert outcome.code == 0, outcome.err
    assert outcome.json["metrics"] == json.loads(json_text(found.metrics))  # infinite ones are null there
    assert outcome.json["same_as_saved"] is True
    assert outcome.json["parameters"]["Tw"] == {"value": found.case.wrist.Tw, "unit": "s"}
    assert outcome.json["reference_deg"][-1] == found.case.task.references[-1]
    assert len(outcome.json["reference_deg"]) == len(outcome.json["time_s"]) == len(outcome.json["angle_deg"])
    assert "all as saved" in outcome.err.replace("\n", " ")


def test_metrics_that_differ_are_told(wrist, saved, tmp_path):
    found, path = saved
    text = path.read_text().replace(f"Kp = {found.controller.Kp}", "Kp = 3.0", 1)
    (tmp_path / "changed.toml").write_text(text)
    outcome = wrist("simulate", "--scenario", tmp_path / "changed.toml", "--json", "-")
    assert outcome.code == 0
    assert outcome.json["same_as_saved"] is False
    assert "not as saved" in outcome.err.replace("\n", " ")


def test_the_picture_shows_the_references(wrist, saved, tmp_path):
    outcome = wrist("simulate", "--scenario", saved[1], "--out", tmp_path)
    assert outcome.code == 0
    assert (tmp_path / "scenario-flexion.png").read_bytes().startswith(b"\x89PNG")


def test_other_sources_of_a_run_are_refused(wrist, saved):
    for option in (("--gains", "1,2"), ("--recording", "x.csv"), ("--plant", "x.toml"), ("--figure", "8")):
        outcome = wrist("simulate", "--scenario", saved[1], *option)
        assert outcome.code == 2
        assert outcome.err.count("\n") == 1
        assert option[0] in outcome.err


def test_a_plant_file_is_no_scenario(wrist):
    outcome = wrist("simulate", "--scenario", "plants/parameters/flexion.toml")
    assert outcome.code == 2
    assert "[scenario]" in outcome.err
    assert outcome.err.count("\n") == 1
