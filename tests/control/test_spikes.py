"""A reading that no plant can have made costs a controller in Python a sample, not its run."""

import math

import numpy as np
import pytest

from design.controllers.controller import Measured
from design.controllers.lqi import LQI
from design.controllers.measurement.screened import Screened
from design.controllers.pi import PI
from design.evaluation.steps import run
from design.mpc.formulations.linear import linear_mpc
from design.mpc.formulations.real_time import real_time_mpc
from design.mpc.problem import MPCProblem, robust
from plants import Wrist
from plants import dynamics as law
from plants.wrist import SAMPLE_TIME

WRIST = Wrist.flexion()
FEEDBACK = LQI(600.0, -640.0, -70.0, 8.0, slope=0.22, Tw=WRIST.Tw, bandwidth=45.0, gain=WRIST.regulator.gain)
STEP = 15.0
SPIKES = {
    "1e9 kPa": (None, 1e9),
    "1e300 kPa": (None, 1e300),
    "1e9 deg": (1e9, None),
    "no number": (math.nan, None),
    "no pressure": (None, math.nan),
    "300 kPa": (None, 300.0),
}


def angles(controller, spike, at=5.0, duration=8.0):
    """Angles [deg] of a step from rest, one sample of which shows a spike (angle, pressure) at a time [s]."""
    c, k = WRIST.sampled(), controller.sampled()
    state, held, found = WRIST.rest(), controller.holding(100.0), []
    for i in range(round(duration / SAMPLE_TIME)):
        angle, pressure = float(state.angle), float(state.pressure)
        if i == round(at / SAMPLE_TIME):
            angle, pressure = (x if y is None else y for x, y in zip((angle, pressure), spike, strict=True))
        held, command = k.act(held, Measured(STEP - angle, angle, pressure))
        state = law.step(state, min(max(float(command), 0.0), 4.0), c)
        found.append(float(state.angle))
    return np.array(found)


@pytest.fixture(scope="module")
def undisturbed():
    return angles(FEEDBACK, (None, None))


@pytest.mark.slow
@pytest.mark.parametrize("spike", SPIKES.values(), ids=list(SPIKES))
def test_a_screened_state_feedback_is_back_within_a_second(undisturbed, spike):
    found = angles(Screened.of(FEEDBACK, WRIST), spike)
    assert np.abs(found - undisturbed)[6000:].max() < 0.01


def test_alone_it_is_not(undisturbed):
    assert np.abs(angles(FEEDBACK, (None, 1e9)) - undisturbed)[6000:].max() > 5.0


def test_without_a_spike_the_screen_changes_nothing(undisturbed):
    assert np.array_equal(angles(Screened.of(FEEDBACK, WRIST), (None, None)), undisturbed)


@pytest.mark.parametrize("inner", [PI.of(WRIST, 3.1, 10.4), FEEDBACK], ids=["PI", "LQI"])
def test_the_compiled_loop_takes_it_as_any_controller(inner):
    alone, _, _ = run(WRIST, inner, STEP, duration=2.0)
    screened, _, _ = run(WRIST, Screened.of(inner, WRIST), STEP, duration=2.0)
    assert float(screened.iae_deg_s[0]) == pytest.approx(float(alone.iae_deg_s[0]), rel=1e-12)


@pytest.mark.parametrize("kind", [linear_mpc, real_time_mpc])
@pytest.mark.parametrize("spike", SPIKES.values(), ids=list(SPIKES))
def test_an_MPC_goes_on_and_solves_in_the_next_period(kind, spike):
    controller = kind(MPCProblem(WRIST))
    state, angle, pressure = controller.init(Measured(0.0, 0.0, 100.0)), 0.0, 100.0
    plant, c, rungs = WRIST.rest(), WRIST.sampled(), []
    for k in range(100):
        angle, pressure = float(plant.angle), float(plant.pressure)
        if k == 30:
            angle, pressure = (x if y is None else y for x, y in zip((angle, pressure), spike, strict=True))
        state, command, info = controller.step(state, Measured(STEP - angle, angle, pressure))
        assert 0.0 <= command <= 4.0
        rungs.append(info.rung)
        for _ in range(20):
            plant = law.step(plant, command, c)
    assert rungs.count("solved") >= 99 - (spike[1] == 300.0)  # which a plant can make within 20 ms
    assert abs(float(plant.angle) - STEP) < 0.1


@pytest.mark.parametrize("kind", [linear_mpc, real_time_mpc])
@pytest.mark.parametrize(
    "at", [(0.0, math.nan), (math.nan, 100.0), (0.0, 400.0), (0.0, -50.0), (1e300, 1e300)]
)
def test_an_MPC_begins_with_a_number_in_range_whatever_is_seen(kind, at):
    controller = kind(robust(WRIST))
    angle, pressure = at
    state = controller.init(Measured(0.0, angle, pressure))
    assert 0.0 <= state.command <= 4.0
    solved = 0
    for _ in range(60):
        state, command, info = controller.step(state, Measured(STEP, 0.0, 100.0))
        assert 0.0 <= command <= 4.0
        solved += info.rung == "solved"
    assert solved == 60
