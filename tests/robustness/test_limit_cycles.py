"""Limit cycles are those of python-control where it knows them, and those of a plain simulation."""

from functools import cache

import control
import numpy as np
import pytest

from design.controllers.pi import PI
from design.open_loops import loop_tf
from design.robustness.predictions.harmonic_balance import balances, loop_gain
from design.robustness.predictions.limit_cycles import LimitCycle, limit_cycles, simulated, statements
from design.robustness.predictions.orbits import Swings, large_swings
from design.status import Status
from plants import Wrist
from plants.effects import DeadTime
from reports.robustness.reasons import cycle_words
from reports.robustness.statements import statement_record
from tests.oracles.plain_loop import Plant, closed_loop

FLEXION, DEVIATION = Wrist.flexion(), Wrist.deviation()
CALM = [
    (FLEXION, 1.2, 2.2),
    (FLEXION, 3.13, 10.4),
    (DEVIATION, 3.13, 10.4),
    (FLEXION + DeadTime(0.05), 3.13, 10.4),
]


@cache
def hunting() -> tuple[list[LimitCycle], Swings]:
    return limit_cycles(FLEXION, PI(1.0, 40.0)), large_swings(FLEXION, PI(1.0, 40.0))


@pytest.mark.slow
def test_around_backlash_the_balance_is_python_controls():
    # One rate and no transit slope: PI, two lags and backlash, which python-control knows.
    w = FLEXION.with_values(k_slow=9.0, k_fast=9.0, s=0.0)
    p = w.hysteresis
    s = control.tf("s")
    H = p.a1 * (5.0 + 60.0 / s) / (s / 9.0 + 1.0) / (w.Tw * s + 1.0)
    gap = (p.w1 + p.w2) / p.a1
    theirs = control.describing_function_response(
        H,
        control.friction_backlash_nonlinearity(gap),
        np.geomspace(17.0, 60.0, 30),
        np.geomspace(1.0, 15.0, 40),
    ).intersections
    ours = balances(w, PI(5.0, 60.0))
    assert len(ours) == len(theirs) == 2
    F, sampled = control.friction_backlash_nonlinearity(gap), loop_tf(w, PI(5.0, 60.0), "line1", "slow")
    for (A, omega, _), (a, o) in zip(ours, sorted(theirs), strict=True):
        assert (A, omega) == pytest.approx((a, o), rel=3e-2)  # theirs knows of no sampling
        assert abs(1.0 + complex(sampled(np.exp(1j * omega * 1e-3))) * F.describing_function(A)) < 1e-7


def test_what_is_found_solves_the_balance_and_loebs_sign_is_that_of_the_gain_as_it_grows():
    found = balances(FLEXION, PI(1.0, 40.0))
    assert [stable for _, _, stable in found] == [False, True]
    omega = np.geomspace(1.0, 30.0, 20_000)
    for A, w, stable in found:
        assert abs(1.0 + loop_gain(FLEXION, PI(1.0, 40.0), A, w)[0, 0]) < 1e-6
        # A cycle attracts where the loop gain at -180 degrees falls below one as the cycle grows.
        size = []
        for a in (0.98 * A, 1.02 * A):
            G = loop_gain(FLEXION, PI(1.0, 40.0), a, omega)[0]
            at = np.flatnonzero((G.imag[:-1] * G.imag[1:] < 0.0) & (G.real[1:] < 0.0))
            size.append(min(np.abs(G[at]), key=lambda g: abs(g - 1.0)))
        assert bool(size[0] > 1.0 > size[1]) is stable
        assert bool(size[0] < 1.0 < size[1]) is not stable


def test_an_integral_gain_far_above_the_proportional_one_hunts_as_predicted():
    cycles, swings = hunting()
    assert [(c.stable, c.confirmed, c.clipped) for c in cycles] == [(False, True, False), (True, True, False)]
    repels, attracts = cycles
    assert repels.seen_amplitude_kPa < attracts.seen_amplitude_kPa
    assert (swings.persisting, swings.amplitude_kPa) == (
        16,
        pytest.approx(attracts.seen_amplitude_kPa, rel=1e-2),
    )


def test_the_cycle_that_is_seen_is_that_of_the_plain_loop():
    _, attracts = hunting()[0]
    angles, _ = closed_loop(Plant(FLEXION.values), 1.0, 40.0, 15.0, 20.0)
    y = np.array(angles[12_000:])
    assert 0.5 * np.ptp(y) > 1.0  # a step of 15 degrees does not come to rest
    up = np.flatnonzero((y[:-1] < y.mean()) & (y[1:] >= y.mean()))
    frequency = 2.0 * np.pi * (len(up) - 1) / ((up[-1] - up[0]) * 1e-3)
    about = limit_cycles(FLEXION, PI(1.0, 40.0), 15.0)[-1]
    assert frequency == pytest.approx(about.seen_frequency_rad_s, rel=1e-2)
    assert 0.5 * np.ptp(y) == pytest.approx(about.seen_amplitude_deg, rel=2e-2)
    assert about.amplitude_kPa == pytest.approx(attracts.amplitude_kPa)  # parallel lines: wherever it swings


def test_small_steps_come_to_rest_in_the_plain_loop_and_large_ones_never_do():
    # Between the two lies the cycle that repels.
    ends = {}
    for step in (2.0, 15.0):
        plant = Plant(FLEXION.values, float(FLEXION.rest("line1", 0.0).pressure), 0.0, virgin=False)
        angles, _ = closed_loop(plant, 1.0, 40.0, step, 25.0)
        ends[step] = 0.5 * np.ptp(angles[-4000:])
    assert ends[2.0] < 0.05 < 5.0 < ends[15.0]
    assert ends[2.0] < hunting()[0][0].seen_amplitude_deg < ends[15.0]


def test_a_small_cycle_on_the_transit_behind_a_dead_time_is_confirmed():
    cycles = limit_cycles(FLEXION + DeadTime(0.05), PI(5.0, 100.0))
    small = cycles[0]
    assert (small.stable, small.confirmed) == (True, True)
    assert small.amplitude_kPa < 5.0
    # In the transit alone the slope is s and the rate as good as slow: the linear
    # loop is unstable there.
    assert abs(small.amplitude_deg / small.amplitude_kPa) < FLEXION.hysteresis.s


def test_a_cycle_beyond_the_range_is_said_to_be_and_refuted():
    cycles = limit_cycles(FLEXION, PI(5.0, 100.0))
    beyond = cycles[-1]
    assert (beyond.clipped, beyond.confirmed) == (True, False)
    assert beyond.seen_amplitude_kPa < 0.5 * beyond.amplitude_kPa
    assert "beyond the command range" in cycle_words(beyond)
    assert "refuted: the simulated loop has one of " in cycle_words(beyond)


def test_a_cycle_that_is_not_there_is_refuted():
    made_up = LimitCycle(4.0, 30.0, 3.0, 100.0, True, False)
    told = simulated(FLEXION, PI(1.2, 2.2), made_up)
    assert (told.confirmed, told.seen_amplitude_kPa) == (False, None)
    repelling = simulated(FLEXION, PI(1.2, 2.2), LimitCycle(4.0, 30.0, 3.0, 100.0, False, False))
    assert repelling.confirmed is False


@pytest.mark.parametrize(("wrist", "Kp", "Ki"), CALM)
def test_where_none_is_predicted_no_large_swing_persists(wrist, Kp, Ki):
    cycles, swings = limit_cycles(wrist, PI(Kp, Ki)), large_swings(wrist, PI(Kp, Ki))
    assert (cycles, swings.persisting) == ([], 0)
    (said,) = statements(cycles, swings)
    assert (said.status, said.holds, said.value) == (Status.PREDICTED, True, 0.0)


def test_deviation_whose_lines_are_not_parallel_has_its_cycles_confirmed_away_from_zero():
    for reference in (0.0, 8.0):
        cycles = limit_cycles(DEVIATION, PI(5.0, 100.0), reference)
        assert [c.stable for c in cycles] == [False, True]
        assert all(c.confirmed for c in cycles)


def test_statements_tell_each_cycle_and_that_the_loop_goes_on_swinging():
    cycles, swings = hunting()
    first, *others = statements(cycles, swings)
    assert first.holds is False
    assert first.value == pytest.approx(swings.amplitude_deg, rel=1e-2)
    assert [o.holds for o in others] == [True, True]
    assert [o.value for o in others] == [c.amplitude_deg for c in cycles]
    assert statement_record(others[1])["seen_frequency_rad_s"] == cycles[1].seen_frequency_rad_s


def test_a_predicted_cycle_that_nothing_shows_leaves_the_question_open():
    unseen = [LimitCycle(4.0, 30.0, 3.0, 100.0, True, False)]
    assert statements(unseen, Swings(16, 120.0, 0, 0.0, 0.0, 0.0))[0].holds is None
    assert statements([], Swings(16, 120.0, 3, 30.0, 4.0, 3.0))[0].holds is False
