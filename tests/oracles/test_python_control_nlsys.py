"""The wrist as a ``control.nlsys``, stepped by python-control, is the compiled wrist."""

import control
import numpy as np
import pytest

from plants import Wrist
from plants.linearisation import nlsys, wrist_x0


@pytest.mark.parametrize("axis", ["flexion", "deviation"])
@pytest.mark.parametrize("seed", [1, 2])
def test_random_commands_give_the_same_response(axis, seed):
    wrist = getattr(Wrist, axis)()
    volts = np.repeat(np.random.default_rng(seed).uniform(0.0, 4.0, 15), 100)
    time = np.arange(len(volts) + 1) * 1e-3
    theirs = control.input_output_response(nlsys(wrist), time, np.append(volts, 0.0), wrist_x0(wrist))
    ours = wrist.simulate(volts)
    np.testing.assert_allclose(theirs.states[0], ours.pressure, rtol=0, atol=1e-10)
    np.testing.assert_allclose(theirs.states[1], ours.static_angle, rtol=0, atol=1e-10)
    np.testing.assert_allclose(theirs.outputs[1], ours.angle, rtol=0, atol=1e-10)


def test_it_is_a_discrete_system_at_the_sample_time_with_named_signals():
    system = Wrist.flexion().to_control()
    assert system.dt == 0.001
    assert system.input_labels == ["command_V"]
    assert system.output_labels == ["pressure_kPa", "angle_deg"]
    assert (system.nstates, system.state_labels[2]) == (4, "virgin")


def test_python_control_closes_a_loop_around_it():
    # A proportional loop assembled by python-control, against one stepped here.
    wrist = Wrist.deviation()
    gain = control.ss([], [], [], [[0.05]], 0.001, inputs=["error"], outputs=["command_V"])
    error = control.summing_junction(["reference", "-angle_deg"], "error")
    loop = control.interconnect(
        [nlsys(wrist), gain, error], inputs=["reference"], outputs=["angle_deg", "pressure_kPa"], dt=0.001
    )
    time = np.arange(301) * 1e-3
    theirs = control.input_output_response(loop, time, np.full(301, 60.0), wrist_x0(wrist)).outputs[0]
    state, angles = wrist.rest(), []
    for _ in time:
        angles.append(state.angle)
        state = wrist.simulate([0.05 * (60.0 - state.angle)], state).state
    assert angles[-1] > 1.0
    np.testing.assert_allclose(theirs, angles, rtol=0, atol=1e-10)
