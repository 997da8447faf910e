"""What is proved of recommended gains: the loop that runs on the target, from the tasks' own starts."""

import pytest

from design.controllers.pi import PI
from design.controllers.pi_two_dof import TwoDofPI
from design.robustness.requirement import requirement
from design.studies.proof import kept_proof, proof
from design.studies.stages import Stages
from plants.parameters.files import built_in
from plants.wrist import Wrist


@pytest.fixture(scope="module")
def weighted():
    """A PI with a weight of the reference, behind 50 ms."""
    return proof(Wrist.flexion(), TwoDofPI.of(Wrist.flexion(), 2.0, 6.0, 0.7), 0.05)


def test_the_sampled_loop_with_dead_time_is_proved_from_the_tasks(weighted):
    assert (weighted["status"], weighted["covers_task"], weighted["dead_time_s"]) == ("proved", True, 0.05)
    assert weighted["rung"].startswith("sampled")


def test_the_rate_is_half_the_slowest_poles(weighted):
    """Of flexion at (2, 6) with 50 ms that is 0.294 1/s, over branches and rates."""
    assert weighted["rate_1_s"] == pytest.approx(0.147, abs=0.002)


def test_a_filter_of_the_angle_makes_another_loop():
    found = proof(Wrist.flexion(), TwoDofPI.of(Wrist.flexion(), 2.0, 6.0, 1.0, 0.02), 0.05)
    assert (found["status"], found["why"]) == (
        "open", "the controller has a filter of the angle, which no certificate knows",
    )  # fmt: skip
    assert {r["status"] for r in found["rungs"]} == {"open"}


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
