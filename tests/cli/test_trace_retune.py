"""Tuning again on the revised plant helps on the very rig, and says no in one line where it cannot."""

from dataclasses import replace

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.steps import run
from design.synthesis.requirements import Limits
from design.synthesis.retune import RetunedResponse, judged, retune, simulated
from design.synthesis.tuning import Region
from plants import Wrist, built_in
from plants.effects import DeadTime, Drift, HardStop
from plants.files import json_text
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.trace.trace import trace_campaign
from reports.trace.control_words import control_sentence
from reports.trace.record import control_record
from tests.rig.campaign import make_rig, record

pytestmark = pytest.mark.slow

TASK = built_in("flexion").rig.task


def with_effect(form, **values):
    """Flexion with one effect."""
    named = {f"{form.NAME}.{n}": v for n, v in values.items()}
    return built_in("flexion").revised([form], named, {}, "a rig")


@pytest.fixture(scope="module")
def late(tmp_path_factory):
    """A rig with 0.1 s of dead time, and the trace of its short campaign."""
    rig = make_rig("flexion", ["dead-time"], 11, {"dead-time": 1})
    dead = rig.hidden.dead_time._replace(transport_s=0.1)
    rig = replace(rig, hidden=rig.hidden._replace(dead_time=dead))
    folder = tmp_path_factory.mktemp("rigs") / "late"
    record(rig, folder, short=True)
    return rig, trace_campaign(load_campaign(folder), built_in("flexion"))


@pytest.mark.suite
def test_on_a_rig_with_dead_time_the_retuned_pi_settles_far_sooner_than_the_declared_one(late):
    rig, trace = late
    control = retune(trace.fit.fitted, trace.revised, rig.closed_loop, "the rig that was measured")
    old, new = control.declared.judged, control.revised.judged
    assert control.declared.refusal is None  # it holds every limit on the plant that it was tuned on
    assert {"overshoot_percent", "delay_margin_s", "settling_time_s"} <= set(control.declared.broken)
    assert new.settling_time_s < 4.0
    assert old.settling_time_s > 2.0 * new.settling_time_s
    assert not new.broken
    assert not new.oscillates
    assert new.iae_deg_s < old.iae_deg_s
    assert not control.revised.broken
    words = control_sentence(control)
    assert words.startswith("On the rig that was measured, the PI tuned on the declared wrist (Kp ")
    assert "meets every limit" in words


def test_a_plant_that_cannot_reach_the_step_is_said_in_one_line():
    control = retune(
        built_in("flexion"), with_effect(HardStop, low=-90.0, high=11.0), region=Region(points=5), starts=1
    )
    assert control.revised.tuning is None
    assert control.revised.judged is None
    words = control_sentence(control)
    assert "\n" not in words
    assert "the end stop at +11 deg keeps the wrist from holding" in words
    assert control_record(control)["revised"]["Kp"] is None


def test_what_was_not_revised_is_tuned_once_and_stands():
    plant = built_in("flexion")
    control = retune(plant, plant, region=Region(points=6), starts=1)
    assert control.same
    assert control.declared is control.revised
    assert "remains" in control_sentence(control)


@pytest.fixture(scope="module")
def drifting():
    """What a sensor that drifts makes of the tuning."""
    return retune(built_in("flexion"), with_effect(Drift, rate=0.1), region=Region(points=6), starts=1)


def test_a_drift_of_the_sensor_is_left_out_of_the_tuning_but_not_of_the_judgement(drifting):
    control = drifting
    assert control.left_out == ("gyro-drift",)
    assert control.revised.refusal is None
    assert control.revised.tuning.Kp == pytest.approx(control.declared.tuning.Kp)
    assert "steady_error_percent" in control.revised.judged.broken
    assert "gyro-drift" in control_sentence(control)


@pytest.mark.parametrize("gains", [(3.0, 10.0), (12.0, 60.0)])
def test_a_step_is_judged_as_the_tuner_judges_it(gains):
    plant = with_effect(DeadTime, delay=0.05)
    wrist = Wrist.of(plant)
    pi = PI(*gains, wrist.regulator.gain, wrist.hysteresis.rest_pressure)
    metrics, _, _ = run(wrist, pi, 15.0)
    held = wrist.hysteresis.rest_pressure / wrist.regulator.gain
    found = judged(simulated(wrist)(*gains).run, Limits(), held, wrist.rig.task)
    assert found.iae_deg_s == pytest.approx(float(metrics.iae_deg_s[0]))
    assert found.overshoot_percent == pytest.approx(float(metrics.overshoot_percent[0]))
    assert found.settling_time_s == pytest.approx(float(metrics.settling_time_s[0]))
    assert found.total_variation_V == pytest.approx(float(metrics.total_variation_V[0]))
    assert found.steady_error_deg >= float(metrics.steady_state_error_deg[0])


def test_a_loop_that_goes_on_swinging_oscillates_and_one_that_rings_down_does_not():
    time = np.arange(10_000) * 1e-3
    swing = np.sin(2.0 * np.pi * time)
    for angle, oscillates in ((15.0 + swing, True), (15.0 + 5.0 * swing * np.exp(-time), False)):
        found = judged(RetunedResponse(time, angle, np.full(10_000, 2.0)), Limits(), 2.0, TASK)
        assert found.oscillates is oscillates
        assert bool(np.isinf(found.settling_time_s)) is oscillates


def test_a_step_that_never_settles_is_null_in_json(drifting):
    assert np.isinf(drifting.revised.judged.settling_time_s)
    assert '"settling_time_s": null' in json_text(control_record(drifting)["revised"])
