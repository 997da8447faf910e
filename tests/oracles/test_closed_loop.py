"""The compiled closed loop is the one that a page of plain Python computes."""

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.steps import holding, run
from plants import Wrist
from tests.oracles.plain_loop import Plant, closed_loop

AXES = ["flexion", "deviation"]
GAINS = [(1.2, 2.2), (5.0, 10.0), (9.0, 27.0), (30.0, 100.0), (0.0, 6.0), (4.0, 0.0)]
"""From the paper's stand-in to a pair that clips the command; without either part as well."""


def both(axis, gains, reference, start="virgin", angle=0.0, seconds=4.0):
    w = getattr(Wrist, axis)()
    state = w.rest(start, angle)
    _, _, t = run(w, PI(*gains), reference, state, duration=seconds, record=True)
    plant = Plant(w.values, float(state.pressure), angle, start == "virgin")
    angles, commands = closed_loop(plant, *gains, reference, seconds)
    assert t.angle.shape == (len(angles) + 1, 1)
    return t, np.array(angles), np.array(commands)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("gains", GAINS)
@pytest.mark.parametrize("reference", [15.0, -15.0])
def test_steps_from_rest(axis, gains, reference):
    t, angles, commands = both(axis, gains, reference)
    np.testing.assert_allclose(t.angle[:-1, 0], angles, rtol=0, atol=1e-8)
    np.testing.assert_allclose(t.command[:-1, 0], commands, rtol=0, atol=1e-8)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize(("start", "angle"), [("line1", 15.0), ("line2", -15.0), ("inside", 5.0)])
def test_steps_from_a_held_angle(axis, start, angle):
    t, angles, commands = both(axis, (5.0, 10.0), 0.0, start, angle)
    assert commands[0] != 100.0 / 49.4
    np.testing.assert_allclose(t.angle[:-1, 0], angles, rtol=0, atol=1e-8)
    np.testing.assert_allclose(t.command[:-1, 0], commands, rtol=0, atol=1e-8)


def test_the_strong_pair_clips_at_both_ends_and_the_integrator_does_not_wind_up():
    for reference in (15.0, -15.0):
        t, _, commands = both("flexion", (30.0, 100.0), reference)
        assert commands[0] == (4.0 if reference > 0 else 0.0)
        assert abs(t.angle[-1, 0] - reference) < 0.5


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize(
    ("start", "angle"), [("virgin", 0.0), ("line1", 10.0), ("line2", -8.0), ("inside", 3.0)]
)
def test_a_loop_that_is_where_it_should_be_stays_there(axis, start, angle):
    w = getattr(Wrist, axis)()
    _, last, t = run(w, PI(5.0, 10.0), angle + 1e-9, w.rest(start, angle), duration=1.0, record=True)
    assert np.abs(t.angle - angle).max() < 1e-8
    assert abs(float(last.plant.pressure[0]) - w.rest(start, angle).pressure) < 1e-6


def test_a_controller_that_knows_another_gain_still_holds_the_start():
    w = Wrist.flexion()
    state = w.rest("line1", 12.0)
    held = holding(w, PI(5.0, 10.0, gain=40.0), state)
    pi = PI(5.0, 10.0, gain=40.0)
    command = (pi.rest_pressure + held.integral) / pi.gain
    assert command * w.regulator.gain == pytest.approx(state.pressure, rel=1e-12)


def test_lanes_of_gains_and_references_are_loops_of_their_own():
    w = Wrist.deviation()
    Kp, Ki, reference = np.array([1.2, 5.0, 30.0]), np.array([2.2, 10.0, 100.0]), np.array([15.0, -15.0, 7.0])
    judged, _, t = run(w, PI(Kp, Ki), reference, duration=2.0, record=True)
    for i in range(3):
        one, _, alone = run(w, PI(Kp[i], Ki[i]), reference[i], duration=2.0, record=True)
        np.testing.assert_array_equal(t.angle[:, i], alone.angle[:, 0])
        assert judged[i].iae_deg_s == one[0].iae_deg_s
