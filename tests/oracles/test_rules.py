"""The textbook rules give the numbers of their papers, from a reaction curve that is fitted right."""

from types import SimpleNamespace

import numpy as np
import pytest

from design.synthesis.tuning_rules import (
    PAPER_FACTOR,
    PAPER_GAINS,
    Reaction,
    amigo,
    baselines,
    first_order,
    paper_range,
    reaction_curve,
    simc,
    ziegler_nichols,
)
from plants import Regulator, Wrist

WRIST = Wrist.flexion()


def reaction(gain: float, time_constant: float, dead_time: float) -> Reaction:
    nothing = np.zeros(0)
    return Reaction(gain, time_constant, dead_time, 0.0, nothing, nothing, nothing)


def times(pi) -> tuple[float, float]:
    """Proportional gain [kPa/deg] and integral time [s]."""
    return float(pi.Kp), float(pi.Kp / pi.Ki)


@pytest.mark.parametrize(
    ("process", "gain", "integral_time"),
    [  # worked from the two formulas of the 2004 paper by hand
        ((2.0, 1.0, 1.0), 0.125, 1.0),
        ((1.0, 1.0, 0.5), 0.15 + 2.0 * (0.35 - 0.5 / 2.25), 0.175 + 6.5 / 8.75),
        ((0.5, 4.0, 1.0), 0.3 + 8.0 * (0.35 - 0.16), 0.35 + 208.0 / 71.0),
    ],
)
def test_amigo(process, gain, integral_time):
    assert times(amigo(WRIST, reaction(*process))) == pytest.approx((gain, integral_time), rel=1e-12)


@pytest.mark.parametrize(
    ("process", "gain", "integral_time"),
    [((2.0, 1.0, 0.1), 4.5, 1.0 / 3.0), ((1.0, 3.0, 0.9), 3.0, 3.0)],
)
def test_ziegler_nichols(process, gain, integral_time):
    assert times(ziegler_nichols(WRIST, reaction(*process))) == pytest.approx(
        (gain, integral_time), rel=1e-12
    )


@pytest.mark.parametrize(
    ("k_fast", "Tw", "lag", "dead", "integral_time"),
    [
        # Half of the smaller lag to each side; half a sample of 1 ms to the dead time.
        (10.0, 0.30, 0.35, 0.0505, 0.35),  # regulator the smaller lag, integral time the lag
        (2.0, 0.04, 0.52, 0.0205, 8 * 0.0205),  # wrist the smaller lag, integral time cut to 8 dead times
    ],
)
def test_simc_with_the_closed_loop_as_quick_as_the_dead_time(k_fast, Tw, lag, dead, integral_time):
    pi = simc(WRIST.with_values(k_fast=k_fast, Tw=Tw, a1=0.5))
    assert times(pi) == pytest.approx((lag / (0.5 * (dead + dead)), integral_time), rel=1e-12)


def test_first_order_with_dead_time_is_the_textbook_response():
    time = np.array([0.0, 0.2, 0.7, 1.7])
    expected = [0.0, 0.0, 3.0 * (1 - np.exp(-1.0)), 3.0 * (1 - np.exp(-3.0))]
    np.testing.assert_allclose(first_order(time, 3.0, 0.5, 0.2), expected, atol=1e-15)


@pytest.mark.parametrize("truth", [(0.3, 0.25, 0.08), (0.1, 1.0, 0.3), (1.0, 0.1, 0.01)])
def test_the_fit_recovers_a_process_that_is_a_lag_with_dead_time(truth):
    time = np.arange(5001) * 0.001
    process = SimpleNamespace(
        hysteresis=WRIST.hysteresis, regulator=WRIST.regulator, rest=WRIST.rest, effects=(), rig=WRIST.rig,
        simulate=lambda command, start: SimpleNamespace(
            time=time, angle=7.0 + first_order(time, *truth) * (command[0] * 49.4 - 100.0)
        ),
    )  # fmt: skip
    found = reaction_curve(process)
    assert (found.gain, found.time_constant, found.dead_time) == pytest.approx(truth, rel=1e-4)
    assert found.rmse < 1e-4


def test_a_wrist_of_one_lag_has_the_reaction_curve_of_that_lag():
    # A regulator of one rate before a wrist too quick to be seen.
    w = Wrist(Regulator.lag(49.4, 0.4), WRIST.hysteresis, 0.005)
    found = reaction_curve(w)
    assert found.gain == pytest.approx(WRIST.hysteresis.a1, rel=1e-3)
    assert found.time_constant == pytest.approx(0.4, rel=1e-2)
    assert found.dead_time == pytest.approx(0.005, abs=0.002)
    assert found.rmse < 0.02


@pytest.mark.parametrize("axis", ["flexion", "deviation"])
def test_the_fit_is_the_least_one_around(axis):
    found = reaction_curve(getattr(Wrist, axis)(), duration=3.0)
    size, best = 50.0, (found.gain, found.time_constant, found.dead_time)
    seen = slice(None, None, 10)

    def misfit(x: tuple[float, ...]) -> float:
        return float(np.sum((size * first_order(found.time[seen], *x) - found.angle[seen]) ** 2))

    for i in range(3):
        for factor in (0.98, 1.02):
            moved = tuple(v * factor if i == j else v for j, v in enumerate(best))
            assert misfit(moved) > misfit(best)


def test_the_range_around_the_stand_in_has_its_corners_a_factor_away():
    middle, *corners = paper_range()
    assert middle == PAPER_GAINS
    ratios = {(round(Kp / middle[0], 12), round(Ki / middle[1], 12)) for Kp, Ki in corners}
    low, high = round(1.0 / PAPER_FACTOR, 12), PAPER_FACTOR
    assert ratios == {(low, low), (low, high), (high, low), (high, high)}


@pytest.mark.parametrize("axis", ["flexion", "deviation"])
def test_baselines_know_the_regulator_that_they_are_made_for(axis):
    w = getattr(Wrist, axis)().with_values(gain=40.0, rest_pressure=80.0)
    found = baselines(w)
    assert set(found) == {"paper", "SIMC", "AMIGO", "Ziegler-Nichols"}
    assert {(pi.gain, pi.rest_pressure) for pi in found.values()} == {(40.0, 80.0)}
    assert (found["paper"].Kp, found["paper"].Ki) == PAPER_GAINS
