"""While a branch is not left and the rate is one, the closed loop is the linear one of python-control."""

import control
import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.steps import run
from design.open_loops import loop_tf
from plants import Wrist

SAMPLES = 3000
AXES = ["flexion", "deviation"]


def linear_step(w: Wrist, pi: PI, branch: str, size: float) -> np.ndarray:
    time = np.arange(SAMPLES + 1) * 0.001
    closed = control.feedback(loop_tf(w, pi, branch, "fast"), 1)
    return np.asarray(control.forced_response(closed, time, np.full(SAMPLES + 1, size)).outputs)


def simulated(w: Wrist, pi: PI, start: str, angle: float, size: float):
    _, _, t = run(w, pi, angle + size, w.rest(start, angle), duration=SAMPLES * 0.001, record=True)
    assert 0.0 < t.command.min() < t.command.max() < 4.0
    return t.angle[:, 0], t.static_angle[:, 0], t.pressure[:, 0]


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("gains", [(0.5, 2.0), (2.0, 15.0), (6.0, 20.0)])
@pytest.mark.parametrize("size", [0.4, -0.4])
def test_between_the_lines_a_small_step_is_linear_whichever_way_it_goes(axis, gains, size):
    w = getattr(Wrist, axis)().as_lag_regulator()
    pi, p = PI(*gains), w.hysteresis
    angle, h, pressure = simulated(w, pi, "inside", 3.0, size)
    # Strictly inside the band all the way: the loop never touched a line.
    assert (h > p.ascending(pressure)).all()
    assert (h < p.descending(pressure)).all()
    np.testing.assert_allclose(angle - 3.0, linear_step(w, pi, "transit", size), rtol=0, atol=1e-9)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize(("branch", "size"), [("line1", 8.0), ("line2", -8.0)])
@pytest.mark.parametrize("gains", [(0.3, 1.5), (0.8, 4.0), (2.0, 8.0)])
def test_along_one_line_a_step_without_reversal_is_linear(axis, branch, size, gains):
    w = getattr(Wrist, axis)().as_lag_regulator()
    pi = PI(*gains)
    angle, _, pressure = simulated(w, pi, branch, 0.0, size)
    theirs = linear_step(w, pi, branch, size)
    # The pressure turns where the linear loop overshoots; up to there the wrist is on its line.
    turned = np.flatnonzero(np.diff(pressure) * np.sign(size) < 0.0)
    until = int(turned[0]) + 1 if turned.size else SAMPLES + 1
    assert until > 300
    np.testing.assert_allclose(angle[:until], theirs[:until], rtol=0, atol=1e-9)


@pytest.mark.parametrize("axis", AXES)
def test_after_the_reversal_the_loop_leaves_the_line_and_linear_theory_with_it(axis):
    w = getattr(Wrist, axis)().as_lag_regulator()
    pi = PI(2.0, 15.0)
    (angle, _, _), theirs = simulated(w, pi, "line1", 0.0, 8.0), linear_step(w, pi, "line1", 8.0)
    assert np.abs(angle - theirs).max() > 0.1


@pytest.mark.parametrize("axis", AXES)
def test_equal_slopes_make_the_loop_linear_through_every_reversal(axis):
    # A wrist whose lines are as flat as its transit has no hysteresis left between them.
    w = getattr(Wrist, axis)().as_lag_regulator()
    s = 0.25
    w = w.with_values(a1=s, a2=s, s=s, w1=1.0, w2=1.0)
    pi = PI(3.0, 40.0)
    angle, _, pressure = simulated(w, pi, "line1", 0.0, 8.0)
    assert (np.diff(pressure) < -1e-3).any()
    np.testing.assert_allclose(angle, linear_step(w, pi, "line1", 8.0), rtol=0, atol=1e-9)
