"""The sampled lag is the continuous one behind a first-order hold, as python-control has it."""

from itertools import pairwise

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plants import lag
from tests.laws.law_strategies import between

TW = [0.01, 0.13, 0.16, 1.0]


def response(Tw: float, dt: float, h: np.ndarray) -> np.ndarray:
    c = lag.sampled(Tw, dt)
    y = [0.0]
    for before, after in pairwise(h):
        y.append(float(lag.step(y[-1], before, after, c)))
    return np.array(y)


@pytest.mark.parametrize("Tw", TW)
def test_random_input_drawn_as_straight_lines_gives_the_response_of_python_control(Tw):
    h = np.cumsum(np.random.default_rng(1).normal(size=2001))
    h -= h[0]
    time = np.arange(2001) * 0.001
    theirs = control.forced_response(control.tf([1], [Tw, 1]), time, h).outputs
    np.testing.assert_allclose(response(Tw, 0.001, h), theirs, rtol=0, atol=1e-11 * np.abs(h).max())


@pytest.mark.parametrize("Tw", TW)
@pytest.mark.parametrize("dt", [0.001, 0.02])
def test_it_is_the_first_order_hold_of_python_control(Tw, dt):
    c = lag.sampled(Tw, dt)
    ours = control.tf([c.after, c.before], [1.0, -c.keep], dt)
    theirs = control.sample_system(control.ss(control.tf([1], [Tw, 1])), dt, method="foh")
    at = np.geomspace(1e-2, 0.99 * np.pi / dt, 50)
    a, b = (control.frequency_response(s, at).complex for s in (ours, theirs))
    np.testing.assert_allclose(a, b, rtol=1e-11)


@given(between(0.005, 5.0), between(-30.0, 30.0), between(-30.0, 30.0))
def test_a_ramp_is_followed_as_the_closed_form_says(Tw, start, slope):
    # y' = (h - y) / Tw with h = start + slope t from y = start: y = h - slope Tw (1 - exp(-t / Tw)).
    time = np.arange(101) * 0.001
    h = start + slope * time
    c = lag.sampled(Tw, 0.001)
    y = start
    for before, after in pairwise(h):
        y = float(lag.step(y, before, after, c))
    assert abs(y - (h[-1] + slope * Tw * np.expm1(-time[-1] / Tw))) < 1e-11


@given(between(0.005, 5.0), st.floats(1e-5, 0.1))
def test_the_three_weights_add_up_to_one_and_are_all_positive(Tw, dt):
    c = lag.sampled(Tw, dt)
    assert abs(c.keep + c.before + c.after - 1.0) < 1e-15 * 4
    assert min(c) > 0.0


@given(between(0.005, 5.0), between(-30.0, 30.0), between(-30.0, 30.0), between(-30.0, 30.0))
def test_the_angle_stays_between_what_it_was_and_what_it_is_driven_to(Tw, angle, before, after):
    y = float(lag.step(angle, before, after, lag.sampled(Tw, 0.001)))
    assert min(angle, before, after) - 1e-12 <= y <= max(angle, before, after) + 1e-12
