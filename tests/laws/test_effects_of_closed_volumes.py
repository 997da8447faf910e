"""A pressure that is a curve over the command, and air that nothing replaces, do what they are said to."""

import numpy as np
import pytest
from scipy.linalg import expm

from plants.effects import Hyperbola, LaminarLeak, SealedLeak, ValveOverlap
from plants.equilibrium import holding_command
from tests.laws.effect_steps import DT, ONE_RATE, WRIST

GAIN, REST = WRIST.regulator.gain, WRIST.hysteresis.rest_pressure
RANGE = 2.0 * WRIST.rig.half_range
STEPS = np.repeat([2.5, 1.0, 3.5, 3.4, 0.2], 500)
CURVATURES = [-0.6, -0.2, 0.3, 0.9]


def curved(straight, curvature):
    return straight / (1.0 - curvature * straight / RANGE)


def straight(pressure, curvature):
    return pressure / (1.0 + curvature * pressure / RANGE)


@pytest.mark.parametrize("curvature", CURVATURES)
@pytest.mark.parametrize("more", [None, ValveOverlap(3.0)])
def test_a_hyperbola_is_the_pressure_of_a_regulator_seen_through_it(curvature, more):
    """What other effects do to the regulator, they do to what is still straight."""
    before = WRIST.with_values(rest_pressure=straight(REST, curvature))
    plain, ours = (before, WRIST) if more is None else (before + more, WRIST + more)
    expected = curved(plain.simulate(STEPS).pressure, curvature)
    np.testing.assert_allclose((ours + Hyperbola(curvature)).simulate(STEPS).pressure, expected, rtol=1e-9)


@pytest.mark.parametrize("curvature", CURVATURES)
@pytest.mark.parametrize("pressure", [20.0, 90.0, 150.0])
def test_a_pressure_on_a_hyperbola_is_held_by_its_inverse(curvature, pressure):
    wrist = WRIST + Hyperbola(curvature)
    asked = straight(pressure, curvature) / GAIN
    if asked > WRIST.rig.command_range[1]:
        pytest.skip("the command does not reach this pressure")
    assert float(holding_command(wrist, pressure)) == pytest.approx(asked, abs=1e-9)


@pytest.mark.parametrize("curvature", CURVATURES)
def test_slopes_of_a_hyperbola_are_those_of_its_curve(curvature):
    ends, h = (60.0, 140.0), 1e-4
    found = [
        (curved(q + h, curvature) - curved(q - h, curvature)) / (2.0 * h)
        for q in (straight(p, curvature) for p in ends)
    ]
    linear = Hyperbola(curvature).linear(WRIST, np.ones(1), DT, ends)
    for slopes in linear.slopes.values():
        assert slopes == pytest.approx(tuple(sorted(found)), rel=1e-6)


def test_a_hyperbola_has_no_pole():
    law = Hyperbola(2.0).sampled(WRIST, DT)
    for pressure in (-1e4, -RANGE, 0.0, 50.0, 1e4):
        for target in (-1e4, 0.0, 0.4 * RANGE, 0.5 * RANGE, 1e4):
            error, _ = law.valve((), pressure, target - pressure, None)
            assert np.isfinite(law.chamber((), pressure, target, pressure + 0.1 * error))


def test_a_sealed_leak_is_the_differential_equation_that_it_says():
    rate, k, target = 0.4, ONE_RATE.regulator.k_fast, 3.0 * GAIN
    system = np.array([[-k, -k, k * target], [rate, 0.0, 0.0], [0.0, 0.0, 0.0]])  # of P, what is lost, and 1
    sample = expm(system * DT)
    state, expected = np.array([REST, 0.0, 1.0]), []
    for _ in range(4001):
        expected.append(state[0])
        state = sample @ state
    ours = (ONE_RATE + SealedLeak(rate)).simulate(np.full(4000, 3.0)).pressure
    assert expected[0] < max(expected) > 2.0 * expected[-1]  # it rises, and sags for good
    np.testing.assert_allclose(ours, expected, atol=0.1 * rate)  # of first order in the sample


def test_air_comes_back_into_a_closed_volume_below_the_outside():
    ours = (ONE_RATE + SealedLeak(0.2)).simulate(np.full(5000, -1.0)).pressure
    assert ours.min() < ours[-1] < 0.0


def test_a_sealed_leak_holds_no_bound_and_a_leak_does():
    assert SealedLeak(0.01).no_bound(WRIST)
    assert LaminarLeak(0.01).no_bound(WRIST) is None
