"""`wrist design`: all the way, with the keys that others read, and on from what is finished."""

import json
import os
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from design.studies.design_study import asked_of_trace
from design.studies.stages import Stages
from design.tuner.gains_file import read
from plants.parameters.files import built_in, load

FLEXION = Path(__file__).parents[2] / "plants/measured/examples/flexion"
MOTIONS = (FLEXION, FLEXION.with_name("deviation"))
MADE = os.environ.get("WRIST_DESIGN")
"""What `make design` made of these two, where it is at hand; else the test makes one, of one motion at less
effort."""


@pytest.mark.suite
def test_it_goes_all_the_way_and_on_from_what_is_finished(wrist, tmp_path):
    out = tmp_path / "design"
    if MADE:
        shutil.copytree(MADE, out)
        asked, samples, begun = MOTIONS, 20000, mtimes(out)
    else:
        less = ("--samples", "400", "--budget", "3000", "--points", "10", "--no-alternatives")
        asked, samples, begun = (FLEXION, *less), 400, {}
    first = wrist("design", *asked, "--out", out, "--json", tmp_path / "d.json")
    assert first.code == 0, first.err
    record = json.loads((tmp_path / "d.json").read_text())
    found = record["recommended"]["flexion"]
    assert found["gains"].keys() == {"Kp", "Ki", "b", "Tf"}
    assert all(v == float(f"{v:.3g}") for v in found["gains"].values())
    assert read(out / "gains-flexion.toml") == (found["gains"]["Kp"], found["gains"]["Ki"])
    assert found["evidence"]["samples"]["broken"] == 0
    assert found["evidence"]["samples"]["total"] == samples
    assert found["evidence"]["worst_case"]["broken"] == 0
    assert found["evidence"]["proved"].keys() >= {"status", "rate_1_s", "dead_time_s", "covers_task"}
    assert {r["guarantee"] for r in record["prices"]} == {
        "nominal", "memory and corners", "dead time", "worst case found", "proved",
    }  # fmt: skip
    assert record["trace"]["flexion"]["verdict"] == "nothing-missing"
    assert load(out / "plant-flexion.toml").axis == "flexion"
    for made in ("gains-flexion.toml", "c-flexion/Makefile", "design.html", "design.json"):
        assert (out / made).stat().st_size > 100, made
    assert "meet every limit with up to 50 ms of dead time" in " ".join(first.out.split())
    motion = "deviation" if MADE else "flexion"
    assert first.out.splitlines()[-1] == f"next: make -C {out / f'c-{motion}'} check"
    before = mtimes(out)
    assert len(before) == 6 * len(record["recommended"])
    assert before == (begun or before)
    (out / "stages" / "proof-flexion.json").write_text("cut o")  # as Ctrl-C may leave it
    again = wrist("design", *asked, "--out", out, "--json", tmp_path / "e.json")
    assert again.code == 0, again.err
    after = mtimes(out)
    assert [name for name in after if after[name] != before[name]] == ["proof-flexion.json"]
    assert json.loads((tmp_path / "e.json").read_text()) == record
    # The gains of the file are judged by the same judge.
    gains, plant = out / "gains-flexion.toml", out / "plant-flexion.toml"
    judged = wrist(
        "robust", "--gains", gains, "--plant", plant, "--samples", "300", "--budget", "600", "--json", "-"
    ).json
    assert judged["worst_case"]["violated"] == []


def mtimes(out: Path) -> dict[str, int]:
    """When each stage of a design was written."""
    return {p.name: p.stat().st_mtime_ns for p in (out / "stages").iterdir()}


def test_a_stage_is_done_once_for_a_question(tmp_path):
    calls = []

    def work():
        calls.append(1)
        return {"n": len(calls)}

    stages = Stages(tmp_path)
    assert stages.done("a", {"x": 1}, work) == {"n": 1}
    assert stages.done("a", {"x": 1}, work) == {"n": 1}
    assert stages.done("a", {"x": 2}, work) == {"n": 2}
    assert stages.done("b", {"x": 2}, work) == {"n": 3}
    (tmp_path / "b.json").write_text("{")
    assert stages.done("b", {"x": 2}, work) == {"n": 4}
    reader = Stages(tmp_path, read_only=True)
    assert reader.done("b", {"x": 2}, work) == {"n": 4}
    assert reader.done("b", {"x": 3}, work) == {"n": 5}
    assert stages.done("b", {"x": 2}, work) == {"n": 4}  # as it was


def test_another_task_in_the_file_of_a_plant_is_another_question(tmp_path):
    """Its parameters may be the same, and a stage that was finished would bring back the task before."""
    start = built_in("flexion")
    shorter = replace(start, rig=replace(start.rig, task=replace(start.rig.task, step=8.0)))
    stricter = replace(start, rig=replace(start.rig, limits={**start.rig.limits, "settling_time_s": 3.0}))
    stages, asked = Stages(tmp_path), (None, start, shorter, stricter)
    for i, given in enumerate(asked):
        assert stages.done("trace", asked_of_trace("sum", given, 0), lambda i=i: {"n": i}) == {"n": i}
    again = stages.done("trace", asked_of_trace("sum", stricter, 0), lambda: {"n": -1})
    assert again == {"n": 3}


def test_bad_campaigns_are_told_before_anything_is_done(wrist, tmp_path):
    outcome = wrist("design", FLEXION, FLEXION, "--out", tmp_path / "d")
    assert outcome.code == 2
    assert "given before" in outcome.err
    assert not (tmp_path / "d").exists()
    nothing = wrist("design", tmp_path / "none", "--out", tmp_path / "d")
    assert nothing.code == 2
    assert len(nothing.err.strip().splitlines()) == 1
