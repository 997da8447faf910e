"""What is proved of recommended gains: the loop that runs on the target, from the tasks' own starts."""

import pytest

from design.controllers.pi import PI
from design.controllers.pi_two_dof import TwoDofPI
from design.robustness.requirement import requirement, requirement_record
from design.studies.decision import settings
from design.studies.proof import kept_proof, proof
from design.studies.stages import Stages
from plants.effects import Creep
from plants.parameters.files import built_in
from plants.wrist import Wrist
from reports.shared.card import CardRow, proof_words

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def weighted():
    """A PI with a weight of the reference, behind 50 ms."""
    return proof(Wrist.flexion(), TwoDofPI.of(Wrist.flexion(), 2.0, 6.0, 0.7), 0.05)


def test_the_sampled_loop_with_dead_time_is_proved_from_the_tasks(weighted):
    assert (weighted["status"], weighted["covers_task"], weighted["dead_time_s"]) == ("proved", True, 0.05)
    assert weighted["rung"].startswith("discrete-time")


def test_the_rate_is_half_the_slowest_poles(weighted):
    """Of flexion at (2, 6) with 50 ms that is 0.294 1/s, over branches and rates."""
    assert weighted["rate_1_s"] == pytest.approx(0.147, abs=0.002)


def test_a_filter_of_the_angle_makes_another_loop():
    found = proof(Wrist.flexion(), TwoDofPI.of(Wrist.flexion(), 2.0, 6.0, 1.0, 0.02), 0.05)
    assert (found["status"], found["why"]) == (
        "open", "the controller has a filter of the angle, which no certificate knows",
    )  # fmt: skip
    assert {r["status"] for r in found["rungs"]} == {"open"}


def test_of_a_plant_with_effects_that_no_certificate_includes_no_rate_is_told():
    plant = Wrist.flexion() + Creep(0.05, 5.0)
    found = proof(plant, TwoDofPI.of(plant, 2.0, 6.0, 0.7), 0.0)
    assert (found["status"], found["rate_1_s"], found["left_out"]) == ("open", None, ["creep"])
    row = CardRow("flexion", "PI", {"Kp": 2.0, "Ki": 6.0}, [], found, {})
    assert proof_words(row) == "open: certificates do not include creep"


@pytest.mark.suite
def test_a_loop_with_a_limit_cycle_is_not_proved():
    found = proof(Wrist.flexion(), PI.of(Wrist.flexion(), 1.0, 40.0), 0.05)
    assert (found["status"], found["covers_task"]) == ("open", False)


def test_a_proof_is_kept_for_exactly_its_gains_plant_and_dead_time(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr("design.studies.proof.proof", lambda *a: asked.append(a) or {"n": len(asked)})
    stages, stated = Stages(tmp_path), requirement(built_in("flexion"))
    gains = PI.of(stated.wrist, 2.0, 6.0)
    assert kept_proof(stages, "flexion", stated, gains, 0.05) == {"n": 1}
    assert kept_proof(Stages(tmp_path, read_only=True), "flexion", stated, gains, 0.05) == {"n": 1}
    other = requirement(built_in("flexion"), given={"Tw": (0.13, 0.19)})
    reader = Stages(tmp_path, read_only=True)
    assert kept_proof(reader, "flexion", stated, PI.of(stated.wrist, 2.0, 6.1), 0.05) == {"n": 2}
    assert kept_proof(reader, "flexion", stated, gains, 0.04) == {"n": 3}
    assert kept_proof(reader, "flexion", other, gains, 0.05) == {"n": 4}


def test_a_decision_shows_the_check_of_a_design_for_exactly_its_gains_and_requirement(tmp_path):
    stated = requirement(built_in("flexion"))
    gains = PI.of(stated.wrist, 2.0, 6.0)
    about = {"requirement": requirement_record(stated), "gains": settings(gains)}
    stages = Stages(tmp_path)
    checked = stages.done("check-flexion", {**about, "seed": 0}, lambda: {"samples": 20_000})
    reader = Stages(tmp_path, read_only=True)
    assert reader.kept("check-flexion", about) == checked
    assert reader.kept("check-flexion", {**about, "gains": settings(PI.of(stated.wrist, 2.0, 6.1))}) is None
    other = requirement(built_in("flexion"), given={"Tw": (0.13, 0.19)})
    assert reader.kept("check-flexion", {**about, "requirement": requirement_record(other)}) is None
    assert reader.kept("check-deviation", about) is None


def test_a_check_that_was_cut_off_or_is_of_another_version_is_not_shown(tmp_path):
    stages = Stages(tmp_path)
    stages.done("check", {"x": 1}, lambda: {"y": 2})
    kept = tmp_path / "check.json"
    whole = kept.read_text()
    kept.write_text(whole.replace('"key": "', '"key": "0'))
    assert stages.kept("check", {"x": 1}) is None
    kept.write_text(whole[: len(whole) // 2])
    assert stages.kept("check", {"x": 1}) is None


def test_a_stage_that_other_sources_made_is_done_again(tmp_path, monkeypatch):
    stages = Stages(tmp_path)
    assert stages.done("check", {"x": 1}, lambda: {"y": 2}) == {"y": 2}
    assert stages.done("check", {"x": 1}, lambda: {"y": 3}) == {"y": 2}
    monkeypatch.setattr("design.studies.stages.source_digest", lambda: "other sources")
    assert stages.kept("check", {"x": 1}) is None
    assert stages.done("check", {"x": 1}, lambda: {"y": 3}) == {"y": 3}
