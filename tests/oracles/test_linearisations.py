"""The linearisation on a branch is what the wrist does on that branch, and what c2d makes of its lags."""

import control
import numpy as np
import pytest

from plants import Regulator, Wrist, dynamics, wrist
from plants.linearisation import RATES, branch_slopes, branch_ss

BRANCHES = tuple(branch_slopes(Wrist.flexion()))

DT = 0.001
AXES = ["flexion", "deviation"]
OMEGA = np.geomspace(1e-2, 0.99 * np.pi / DT, 60)


def rate(w: Wrist, name: str) -> float:
    return float(w.regulator.k_fast if name == "fast" else w.regulator.k_slow)


def slope(w: Wrist, branch: str) -> float:
    p = w.hysteresis
    return float({"transit": p.s, "line1": p.a1, "line2": p.a2}[branch])


cases = pytest.mark.parametrize(
    ("axis", "branch", "speed"), [(a, b, r) for a in AXES for b in BRANCHES for r in RATES]
)


@cases
def test_the_poles_are_those_of_the_two_lags(axis, branch, speed):
    w = getattr(Wrist, axis)()
    found = np.sort(branch_ss(w, branch, speed).poles().real)
    np.testing.assert_allclose(found, np.sort(np.exp([-rate(w, speed) * DT, -DT / w.Tw])), rtol=1e-12)


@cases
def test_the_steady_state_is_gain_times_slope(axis, branch, speed):
    w = getattr(Wrist, axis)()
    assert branch_ss(w, branch, speed).dcgain() == pytest.approx(
        w.regulator.gain * slope(w, branch), rel=1e-9
    )


@cases
def test_it_is_a_held_regulator_before_a_lag_with_straight_line_input(axis, branch, speed):
    # Both by python-control: zero-order hold for the regulator, first-order hold for the lag.
    w = getattr(Wrist, axis)()
    air = control.ss(control.tf([w.regulator.gain], [1.0 / rate(w, speed), 1.0]))
    hand = control.ss(control.tf([slope(w, branch)], [w.Tw, 1.0]))
    series = control.sample_system(air, DT, "zoh"), control.sample_system(hand, DT, "foh")
    theirs = np.prod([control.frequency_response(s, OMEGA).complex for s in series], axis=0)
    ours = control.frequency_response(branch_ss(w, branch, speed), OMEGA).complex
    np.testing.assert_allclose(ours, theirs, rtol=1e-9)


@cases
def test_the_step_response_is_that_of_the_continuous_lags(axis, branch, speed):
    # Whose pressure is no straight line within a sample: a difference of second order in 1 ms.
    w = getattr(Wrist, axis)()
    k, g = rate(w, speed), w.regulator.gain * slope(w, branch)
    time = np.arange(3001) * DT
    continuous = control.tf([g], np.polymul([1.0 / k, 1.0], [w.Tw, 1.0]))
    theirs = control.step_response(continuous, time).outputs
    ours = control.step_response(branch_ss(w, branch, speed), time).outputs
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=3e-6 * g)


def on_branch(w: Wrist, branch: str) -> tuple[wrist.State, float]:
    """A wrist at rest in the middle of a branch, and the sign of the moves that stay on it."""
    start = {"line1": "line1", "line2": "line2", "transit": "inside"}[branch]
    return w.rest(start, 6.0), -1.0 if branch == "line2" else 1.0


@cases
def test_a_small_move_of_the_nonlinear_wrist_is_the_linear_one(axis, branch, speed):
    w = getattr(Wrist, axis)()
    if speed == "fast":  # far from the commanded pressure the rate is the fast one
        w = w.with_values(k_slow=w.regulator.k_fast)
    state, sign = on_branch(w, branch)
    hold, small = state.pressure / w.regulator.gain, sign * 1e-5
    moved = w.simulate(np.full(400, hold + small), state)
    time = np.arange(401) * DT
    linear = control.forced_response(branch_ss(w, branch, speed), time, np.full(401, small)).outputs
    # At the slow rate the rate itself changes with the square of the error, so far below 1e-5.
    np.testing.assert_allclose((moved.angle - 6.0) / small, linear / small, rtol=1e-5, atol=1e-6)
    assert abs(moved.angle[-1] - 6.0) > 1e-8


@cases
def test_finite_differences_of_one_sample_are_the_state_matrices(axis, branch, speed):
    w = getattr(Wrist, axis)()
    if speed == "fast":
        w = w.with_values(k_slow=w.regulator.k_fast)
    state, sign = on_branch(w, branch)
    hold, c = state.pressure / w.regulator.gain, w.sampled()

    def moved(volts: float, angle: float) -> np.ndarray:
        after = dynamics.step(state._replace(angle=6.0 + angle), hold + volts, c)
        return np.array([after.pressure - state.pressure, after.angle - 6.0], float)

    size = 1e-4
    system = branch_ss(w, branch, speed)
    by_command = moved(sign * size, 0.0) / (sign * size)
    by_angle = moved(0.0, size) / size
    np.testing.assert_allclose(by_command, system.B[:, 0], rtol=2e-5)
    np.testing.assert_allclose(by_angle, system.A[:, 1], rtol=1e-9, atol=1e-9)


def test_far_from_the_commanded_pressure_the_rate_is_the_fast_one():
    w = Wrist.flexion()
    far = w.with_values(e0=1e-3).simulate([4.0] * 2)
    lag = w.as_lag_regulator(1.0 / w.regulator.k_fast).simulate([4.0] * 2)
    assert isinstance(w.as_lag_regulator().regulator, Regulator)
    np.testing.assert_allclose(far.pressure, lag.pressure, rtol=1e-9)


@pytest.mark.parametrize(("branch", "speed"), [("line3", "fast"), ("line1", "mean")])
def test_other_names_are_refused(branch, speed):
    with pytest.raises(ValueError, match=r"unknown (branch|regulator rate)"):
        branch_ss(Wrist.flexion(), branch, speed)
