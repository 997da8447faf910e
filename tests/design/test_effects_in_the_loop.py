"""Every effect goes through the closed loop: absent it changes nothing, present it is finite."""

from itertools import pairwise

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.runner import Lanes, play, step_from
from design.evaluation.steps import run
from plants.effects import (
    CompliantStop,
    DraggedInertia,
    Drift,
    Hum,
    Inertia,
    LoadStep,
    Saturation,
    SealedLeak,
    Warming,
)
from plants.effects.wrist.inertia import NULL
from plants.equilibrium import at_pressure, holding_command, obstacle
from plants.wrist import Wrist
from tests.design.effect_samples import FORMS, IDS, WRIST, present

PLAIN = run(WRIST, PI(3.13, 10.4), 15.0, duration=1.5, record=True)
NEARLY = {Saturation: 1e-6, Inertia: 1e2 * NULL, DraggedInertia: 1e2 * NULL}
"""Forms that are absent only in a limit, and how near to it their null lies [deg]."""


@pytest.mark.parametrize("form", FORMS, ids=IDS)
def test_absent_it_changes_nothing_and_present_the_loop_is_finite(form):
    # Two lanes of one kernel: the effect absent and present.
    lanes = [(WRIST + form()).values, (WRIST + present(form)).values]
    both = Wrist.from_values({n: np.array([v[n] for v in lanes]) for n in lanes[0]}, (form,))
    judged, _, t = run(both, PI(3.13, 10.4), 15.0, duration=1.5, record=True)
    for name in ("angle", "pressure", "static_angle", "command", "measured"):
        ours, plain = getattr(t, name), getattr(PLAIN[2], name)
        np.testing.assert_allclose(ours[:, :1], plain, rtol=0.0, atol=NEARLY.get(form, 1e-9))
        assert np.isfinite(ours).all()
        assert np.abs(ours[:, 1]).max() < 250.0
    assert np.isfinite(judged.iae_deg_s).all()


def test_absent_effects_leave_the_kernel_of_the_declared_wrist_alone():
    judged, last, _ = PLAIN
    again, end, _ = run(WRIST, PI(3.13, 10.4), 15.0, duration=1.5)
    assert float(again.iae_deg_s[0]) == float(judged.iae_deg_s[0])
    assert float(end.plant.angle[0]) == float(last.plant.angle[0])


@pytest.mark.parametrize("effect", [Drift(0.5), Hum(2.0, 0.3, 0.0)])
def test_the_controller_sees_the_reading_and_the_judge_the_joint(effect):
    judged, _, t = run(WRIST + effect, PI(3.13, 10.4), 15.0, duration=8.0, record=True)
    time = t.time
    off = 0.5 * time if isinstance(effect, Drift) else 0.3 * np.sin(4.0 * np.pi * time)
    np.testing.assert_allclose(t.measured[:, 0] - t.angle[:, 0], off, atol=1e-9)
    error = 15.0 - t.angle[:-1, 0]
    assert judged.iae_deg_s[0] == pytest.approx(np.abs(error).sum() * 1e-3, rel=1e-9)
    if isinstance(effect, Drift):  # the reading trails the reference, the joint drifts away
        assert abs(t.measured[-1, 0] - 15.0) < 1.0
        assert abs(t.angle[-1, 0] - 15.0) > 3.0


def test_time_goes_on_where_a_loop_begins_later():
    _, _, t = run(WRIST + Drift(0.5), PI(3.13, 10.4), 15.0, duration=0.1, record=True, begin=6.0)
    assert t.measured[0, 0] - t.angle[0, 0] == pytest.approx(3.0)
    early, _, _ = run(WRIST + LoadStep(3.0, 0.5), PI(3.13, 10.4), 15.0, duration=1.0)
    none, _, _ = run(WRIST + LoadStep(3.0, 0.5), PI(3.13, 10.4), 15.0, duration=1.0, begin=-3.0)
    assert early.iae_deg_s[0] < none.iae_deg_s[0]  # the load helps, where it comes


def test_a_run_begins_at_time_0_where_nothing_else_is_said():
    wrist = WRIST + LoadStep(3.0, 0.5)
    told = step_from(wrist, wrist.rest(), 15.0, 1.0, begin=0.0)
    untold = Lanes(told.wrist, told.state, told.reference, told.judge, told.duration)
    one, other = (play(lanes, PI(3.13, 10.4)).metrics for lanes in (told, untold))
    assert one.iae_deg_s[0] == other.iae_deg_s[0]


@pytest.mark.parametrize("start", ["line1", "line2", "inside"])
@pytest.mark.parametrize("form", FORMS, ids=IDS)
def test_a_wrist_at_rest_stays_there(form, start):
    effect = present(form)
    if isinstance(effect, Warming | SealedLeak):
        pytest.skip("warms up, or loses air for good, and so is never at rest")
    if isinstance(effect, LoadStep):
        effect = LoadStep(effect.shift, 100.0)
    if form.FORM == "gradual, with a change of slope":
        effect = form(effect.shift, 100.0)
    wrist = WRIST + effect
    angle = {"line1": 15.0, "line2": -9.0, "inside": 4.0}[start]
    hindered = obstacle(wrist, start, angle) if start != "inside" else None
    if hindered:
        assert form.NAME == "end-stop"
        pytest.skip(hindered)
    state = wrist.rest(start, angle)
    held = np.full(5000, float(holding_command(wrist, state.pressure)))
    went = wrist.simulate(held, state, every=1000)
    assert abs(float(went.state.angle) - angle) < 0.02


@pytest.mark.parametrize("form", FORMS, ids=IDS)
def test_the_rest_at_a_pressure_is_the_rest_at_its_angle(form):
    wrist = WRIST + present(form)
    for line, pressures in (("line1", (105.0, 120.0)), ("line2", (95.0, 80.0))):
        states = [at_pressure(wrist, line, p) for p in pressures]
        for state, pressure in zip(states, pressures, strict=True):
            if obstacle(wrist, line, state.angle) is None:
                assert float(wrist.rest(line, state.angle).pressure) == pytest.approx(pressure, abs=1e-6)
        assert all((b.angle - a.angle) * (b.pressure - a.pressure) > 0.0 for a, b in pairwise(states))


def test_a_compliant_stop_hides_the_joint_from_the_controller():
    assert obstacle(WRIST + CompliantStop(-90.0, 11.0, 0.1), "line1", 15.0) == "the end stop at +11 deg"
