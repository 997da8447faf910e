"""Where a loop of constant parameters has its gain crossing, and what is left of its phase there."""

import control
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from design.robustness.certificates.constant.uncertain_loop import UncertainLoop
from design.robustness.certificates.constant.uncertain_search import crossing, growths, slack, smallest

numbers = {
    "slope": st.floats(0.02, 2.0), "rate": st.floats(0.2, 80.0), "lag": st.floats(1.0, 40.0),
    "gain": st.floats(0.5, 2.0), "Kp": st.floats(0.0, 10.0), "Ki": st.floats(0.1, 40.0),
    "dead_time": st.floats(0.0, 0.1),
}  # fmt: skip


def open_loop(loop, p, omega):
    """L(j omega) as it is written."""
    slope, rate, lag, gain = p
    s = 1j * omega
    return slope * rate * lag * gain * (loop.Kp * s + loop.Ki) / (s * (s + rate) * (s + lag))


@given(**numbers)
def test_at_the_crossing_the_gain_is_one_and_what_is_left_of_the_phase_is_told(
    slope, rate, lag, gain, Kp, Ki, dead_time
):
    p = np.array([slope, rate, lag, gain])
    loop = UncertainLoop(Kp, Ki, tuple(p), (0.1,) * 4, dead_time)
    omega = float(crossing(loop, p))
    L = open_loop(loop, p, omega)
    assert abs(L) == pytest.approx(1.0, rel=1e-6)
    left = np.pi + np.unwrap([-np.pi / 2, *np.angle(open_loop(loop, p, np.geomspace(1e-6, omega, 4000)))])[-1]
    assert float(slack(loop, p)) == pytest.approx(left - dead_time * omega, abs=1e-5)


@given(**{**numbers, "dead_time": st.just(0.0)})
def test_slack_is_the_phase_margin_of_python_control(slope, rate, lag, gain, Kp, Ki, dead_time):
    p = np.array([slope, rate, lag, gain])
    loop = UncertainLoop(Kp, Ki, tuple(p), (0.1,) * 4)
    k = slope * rate * lag * gain
    system = control.tf([k * Kp, k * Ki], np.polymul([1.0, rate, 0.0], [1.0, lag]))
    _, margin, _, omega = control.margin(system)
    assume(np.isfinite(omega))
    assert float(crossing(loop, p)) == pytest.approx(omega, rel=1e-4)
    assert np.degrees(float(slack(loop, p))) == pytest.approx(margin, abs=1e-2)


def test_a_parameter_that_is_no_longer_positive_has_no_slack():
    loop = UncertainLoop(1.0, 2.0, (0.3, 5.0, 6.0, 1.0), (0.1,) * 4)
    for i in range(4):
        p = np.array(loop.centre)
        for value in (0.0, -1.0):
            p[i] = value
            assert float(slack(loop, p)) == -np.pi


@pytest.mark.parametrize("dead_time", [0.0, 0.04])
def test_rays_leave_stability_where_the_slack_is_lost_and_no_ray_of_many_does_sooner(dead_time):
    loop = UncertainLoop(3.0, 12.0, (0.3, 5.0, 6.0, 1.0), (0.03, 0.8, 0.9, 0.0), dead_time)
    draw = np.random.default_rng(4).uniform(-1.0, 1.0, (400, 4)) * (1.0, 1.0, 1.0, 0.0)
    draw /= np.abs(draw).max(axis=1, keepdims=True)
    found = growths(loop, draw)
    zero = min(c / r for c, r in zip(loop.centre, loop.radius, strict=True) if r)
    inside = found < zero * (1.0 - 1e-9)
    at = loop.at(found[inside][:, None] * draw[inside])
    assert np.abs(slack(loop, at)).max() < 1e-6
    for share in (0.3, 0.7, 0.999):
        assert (slack(loop, loop.at(share * found[:, None] * draw)) > 0.0).all()
    least = smallest(loop)
    assert least.confirmed
    assert least.growth <= found.min() * (1.0 + 2e-4)
    p = [least.parameters[n] for n in ("slope", "rate", "lag", "gain")]
    k = p[0] * p[1] * p[2] * p[3]
    s = least.root
    late = k * (loop.Kp * s + loop.Ki) * np.exp(-s * dead_time)
    assert abs(s * (s + p[1]) * (s + p[2]) + late) < 1e-8 * abs(late)
    assert s.real > 0.0
    away = np.abs(np.array(p) - loop.centre) / np.where(np.array(loop.radius) > 0.0, loop.radius, 1.0)
    assert away.max() == pytest.approx(least.growth, rel=1e-9)


@pytest.mark.parametrize(
    "loop",
    [
        UncertainLoop(4.7, 1.6, (0.11, 1.0, 24.0, 0.62), (0.022, 0.2, 4.8, 0.12), 0.1),
        UncertainLoop(0.16, 1.1, (0.78, 19.0, 3.2, 1.2), (0.16, 3.8, 0.64, 0.24)),
        UncertainLoop(9.0, 8.5, (0.18, 12.0, 12.0, 0.91), (0.036, 2.4, 2.4, 0.18), 0.02),
    ],
)
def test_a_root_is_found_in_loops_of_every_kind(loop):
    """Newton's method with a wrong slope finds that of a loop whose lags are alike, and not of these."""
    found = smallest(loop)
    p = [found.parameters[n] for n in ("slope", "rate", "lag", "gain")]
    s = found.root
    assert open_loop(loop, p, s / 1j) * np.exp(-s * loop.dead_time) == pytest.approx(-1.0, abs=1e-9)
    assert s.real > 0.0
    assert found.confirmed
