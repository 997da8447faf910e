"""A revised plant goes through every command as a declared one does."""

import json
from dataclasses import replace

import pytest

from plants import built_in
from plants.effects import Creep, DeadTime, HardStop
from plants.parameters.files import dump

VALUES = {"dead-time.delay": 0.1, "creep.gain": 0.064, "creep.time_constant": 3.0}


@pytest.fixture
def revised(tmp_path):
    """Path of flexion with dead time and creep."""
    path = tmp_path / "revised.toml"
    dump(built_in("flexion").revised([DeadTime, Creep], VALUES, {"creep.gain": 0.001}, "p1"), path)
    return path


def test_show_prints_effects_with_form_parameters_and_provenance(wrist, revised):
    outcome = wrist("show", "--plant", revised)
    assert outcome.code == 0
    lines = [line.strip() for line in outcome.out.splitlines()]
    assert "dead-time: transport (regulator)" in lines
    at = lines.index("creep: one time constant (wrist)")
    assert lines[at + 1].startswith("creep.gain")
    assert "what creeps, over the static angle; fitted to p1, s.e. 0.001" in lines[at + 2]
    shown = wrist("show", "--plant", revised, "--json", "-").json
    assert shown["creep.gain"] == {
        "value": 0.064, "unit": "1", "provenance": {"kind": "fitted", "data": "p1", "std_error": 0.001},
    }  # fmt: skip
    assert set(shown) == {*built_in("flexion").parameters, *VALUES}


def test_simulate_open_and_closed(wrist, revised):
    open_loop = wrist("simulate", "--plant", revised, "--json", "-").json
    assert open_loop["angle_deg"][-1] > wrist("simulate", "--json", "-").json["angle_deg"][-1] + 0.3
    late = wrist("simulate", "--plant", revised, "--gains", "3.13,10.4", "--json", "-").json
    soon = wrist("simulate", "--gains", "3.13,10.4", "--json", "-").json
    assert late["metrics"]["overshoot_percent"] > 10.0 > soon["metrics"]["overshoot_percent"]


def test_an_angle_that_is_read_late_is_late_in_every_loop(wrist, tmp_path):
    base, path = built_in("flexion"), tmp_path / "late.toml"
    dump(replace(base, rig=replace(base.rig, angle_delay=0.1)), path)
    assert wrist("show", "--plant", path).code == 0
    open_loop, declared = (wrist("simulate", *of, "--json", "-").json for of in (("--plant", path), ()))
    assert open_loop["angle_deg"] == declared["angle_deg"]  # as the joint moves
    late = wrist("simulate", "--plant", path, "--gains", "3.13,10.4", "--json", "-").json
    soon = wrist("simulate", "--gains", "3.13,10.4", "--json", "-").json
    assert late["metrics"]["overshoot_percent"] > 10.0 > soon["metrics"]["overshoot_percent"]
    plain = ("--plain", "--nominal", "--points", "5", "--starts", "1", "--json", "-")
    tuned = wrist("tune", "--plant", path, *plain)
    assert "the angle is read 0.1 s late" in tuned.err
    assert tuned.json["Ki"] < wrist("tune", *plain).json["Ki"]
    made = wrist("export", "plant", "--plant", path, "--out", tmp_path / "c", "--json", "-").json
    assert made["settings"]["dead-time.delay"] == 0.1


@pytest.mark.slow
def test_tune_finds_gains_for_the_plant_as_it_is(wrist, revised):
    arguments = ("--points", "8", "--starts", "1", "--nominal", "--json", "-")
    found = wrist("tune", "--plain", "--plant", revised, *arguments)
    assert found.code == 0, found.out
    declared = wrist("tune", "--plain", *arguments).json
    assert found.json["feasible"]
    assert found.json["Ki"] < declared["Ki"]


@pytest.mark.slow
def test_tune_says_no_behind_an_end_stop(wrist, tmp_path):
    path = tmp_path / "stopped.toml"
    values = {"end-stop.low": -90.0, "end-stop.high": 11.0}
    dump(built_in("flexion").revised([HardStop], values, {}, "p1"), path)
    outcome = wrist(
        "tune", "--plain", "--plant", path, "--points", "5", "--starts", "1", "--corners", "0,0,0"
    )
    assert outcome.code == 1
    said = " ".join(outcome.out.split())
    assert said.startswith("no: the end stop at +11 deg keeps the wrist from holding 0 to +15 deg from ")


@pytest.mark.suite
def test_compare_of_one_plant_is_of_that_plant_alone(wrist, revised, tmp_path):
    out = tmp_path / "report"
    outcome = wrist(
        "compare",
        "--plain",
        "--plant",
        revised,
        "--points",
        "6",
        "--samples",
        "0",
        "--mpc-plants",
        "0",
        "--out",
        out,
        "--json",
        "-",
    )
    assert outcome.code in (0, 1), outcome.err
    assert {"comparison.html", "comparison.json", "comparison.csv"} <= {p.name for p in out.iterdir()}
    record = json.loads((out / "comparison.json").read_text())
    assert record == outcome.json
    assert list(record["plants"]) == ["flexion"]
    assert record["plants"]["flexion"]["dead-time.delay"]["value"] == 0.1
    assert {r["motion"] for r in record["rows"]} == {"flexion"}
    tuned = {s["motion"]: s for s in record["standings"] if s["controller"] == "tuned"}
    assert tuned["flexion"]["Ms"] <= 2.001
    assert "creep.gain" in (out / "comparison.html").read_text()


def test_a_wrong_effect_is_refused_in_one_line(wrist, revised):
    revised.write_text(revised.read_text().replace("[effects.creep", "[effects.crepe"))
    outcome = wrist("show", "--plant", revised)
    assert outcome.code == 2
    assert outcome.err.count("\n") == 1
    assert "unknown effect 'crepe'" in outcome.err
