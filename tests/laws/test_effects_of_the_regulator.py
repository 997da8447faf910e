"""Dead time, dead band, unequal valves and a weak supply change the pressure as they are said to."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.signal import cont2discrete, lfilter

from plants import equilibrium
from plants.effects import (
    CappedPressure,
    CappedTarget,
    CommandedOpenings,
    Creep,
    DeadTime,
    FlowLimits,
    LaminarLeak,
    Latch,
    LeastPressure,
    LimitedFlow,
    OrificeExhaust,
    PlayDeadBand,
    PowerLeak,
    PressureDependentRates,
    SaturatingSag,
    SecondOrderDeadTime,
    TubeDeadTime,
    TwoRates,
    ValveOverlap,
)
from plants.effects.effect import Around
from plants.equilibrium import commanded, holding_command
from plants.linearisation import responses
from tests.laws.effect_steps import DT, ONE_RATE, WRIST, played

STEPS = np.repeat([2.5, 1.0, 3.5, 3.4], 500)
GAIN, REST = WRIST.regulator.gain, WRIST.hysteresis.rest_pressure
BEFORE = REST / GAIN
"""Command [V] that a wrist at rest was held by."""


def late(whole, share=0.0):
    """The commands as they come out of a tube of so many samples and a share of one more."""
    padded = np.concatenate([np.full(whole + 1, BEFORE), STEPS])
    near, far = padded[1 : len(STEPS) + 1], padded[: len(STEPS)]
    return (1.0 - share) * near + share * far


@pytest.mark.parametrize(
    ("delay", "whole", "share"), [(0.0, 0, 0.0), (0.037, 37, 0.0), (0.0365, 36, 0.5), (0.4, 400, 0.0)]
)
def test_a_dead_time_is_the_same_wrist_commanded_later(delay, whole, share):
    ours = (WRIST + DeadTime(delay)).simulate(STEPS)
    plain = WRIST.simulate(late(whole, share))
    np.testing.assert_allclose(ours.pressure, plain.pressure, atol=1e-9)
    np.testing.assert_allclose(ours.angle, plain.angle, atol=1e-9)


def test_a_tube_delays_and_then_lags():
    share = -np.expm1(-DT / 0.04)
    lagged, _ = lfilter([share], [1.0, share - 1.0], late(25), zi=[(1.0 - share) * BEFORE])
    ours = (WRIST + TubeDeadTime(0.025, 0.04)).simulate(STEPS)
    np.testing.assert_allclose(ours.pressure, WRIST.simulate(lagged).pressure, atol=1e-9)


@pytest.mark.parametrize("damping", [0.3, 1.0, 1.4])
def test_a_second_order_lag_delays_and_then_swings(damping):
    natural = 1.0 / 0.05
    swings = ([natural**2], [1.0, 2.0 * damping * natural, natural**2])
    numerator, denominator, _ = cont2discrete(swings, DT, "zoh")
    moved = lfilter(numerator.ravel(), denominator, late(25) - BEFORE) + BEFORE
    ahead = np.append(moved[1:], moved[-1])  # what has come in during a sample has left by its end
    ours = (WRIST + SecondOrderDeadTime(0.025, 0.05, damping)).simulate(STEPS).pressure
    np.testing.assert_allclose(ours[:-1], WRIST.simulate(ahead).pressure[:-1], atol=1e-6)


def test_below_the_least_pressure_that_one_is_held_whatever_lags_behind_it():
    least = 80.0
    commands = np.maximum(STEPS, least / GAIN)
    for behind in ([], [DeadTime(0.03)], [SecondOrderDeadTime(0.02, 0.04, 0.6)]):
        plain, ours = WRIST, WRIST
        for effect in behind:
            plain, ours = plain + effect, ours + effect
        ours = ours + LeastPressure(least)
        np.testing.assert_allclose(
            ours.simulate(STEPS).pressure, plain.simulate(commands).pressure, atol=1e-9
        )


def test_a_pressure_below_the_least_cannot_be_held():
    assert LeastPressure(80.0).obstacle(60.0, 0.0)
    assert LeastPressure(80.0).obstacle(81.0, 0.0) is None


def test_valves_of_one_gain_and_rate_and_a_loss_alike_at_all_pressures_are_redundant():
    alike = CommandedOpenings(15.0, 14.6, 230.0, -7.4, 1.05, 0.98)
    assert alike.redundant(WRIST)
    assert not CommandedOpenings(1.9, 4.3, 230.0, 0.0, 0.5, 1.0).redundant(WRIST)
    assert PowerLeak(70.0, 0.2).redundant(WRIST)
    assert not PowerLeak(70.0, 0.5).redundant(WRIST)


def targets(effect, wanted):
    """Pressures that the regulator aims at, one for each that is commanded [kPa]."""
    c, s, out = effect.sampled(WRIST, DT), effect.rest(WRIST, 100.0, 0.0), []
    for one in wanted:
        s, got = c.target(s, one, Around())
        out.append(float(got))
    return out


def test_a_latch_takes_up_changes_beyond_its_width_in_full():
    wanted = [102.0, 103.5, 105.0, 101.0, 102.0, 97.9, 95.0]
    assert targets(Latch(3.0), wanted) == [100.0, 103.5, 103.5, 103.5, 103.5, 97.9, 97.9]


def test_a_play_follows_at_its_distance():
    assert targets(PlayDeadBand(3.0), [102.0, 104.0, 110.0, 105.0, 103.0, 90.0]) == [
        100,
        101,
        107,
        107,
        106,
        93,
    ]


def test_shut_valves_leave_the_pressure_where_the_error_is_their_overlap():
    pressure, _, _ = played(ONE_RATE + ValveOverlap(3.0), np.full(3000, 150.0 / GAIN))
    assert 147.0 <= pressure[-1] <= 147.1
    assert pressure[-1] == pressure[-500]


@pytest.mark.parametrize("ratio", [0.5, 1.4, 3.0])
def test_exhausting_is_as_much_faster_as_it_is_said_to_be(ratio):
    time = np.arange(501) * DT
    w = ONE_RATE + TwoRates(ratio)
    up, _, _ = played(w, np.full(500, 150.0 / GAIN))
    down, _, _ = played(w, np.full(500, 50.0 / GAIN))
    np.testing.assert_allclose(up, 150.0 - 50.0 * np.exp(-5.0 * time), atol=1e-9)
    np.testing.assert_allclose(down, 50.0 + 50.0 * np.exp(-5.0 * ratio * time), atol=2e-4)


@pytest.mark.parametrize(
    ("effect", "fills", "exhausts"),
    [
        (PressureDependentRates(1.4, -0.3, 0.4), 1.0 - 0.3 * 0.5, 1.4 * (1.0 + 0.4 * 0.5)),
        (OrificeExhaust(1.4, 0.5, base=20.0), 1.0, 1.4 * (170.0 / 120.0) ** 0.5),
    ],
)
def test_speeds_of_filling_and_exhausting_at_150_kPa(effect, fills, exhausts):
    valve = effect.sampled(WRIST, DT).valve
    speeds = [valve(effect.rest(WRIST, 150.0, 0.0), 150.0, e, Around())[1] for e in (1.0, -1.0)]
    assert [float(s) for s in speeds] == pytest.approx([fills, exhausts])


@pytest.mark.parametrize(("volts", "ratio"), [(4.0, 1.0), (0.0, 1.0), (0.0, 0.4)])
def test_a_valve_that_is_open_lets_no_more_through(volts, ratio):
    """Against the differential equation, to either side, limits that change with the pressure (scipy)."""
    effect, k = FlowLimits(90.0, 60.0, ratio, -0.4, 0.5), ONE_RATE.regulator.k_fast

    def rate(_t, p):
        asked, x = k * (GAIN * volts - p), (p - 100.0) / 100.0
        return max(
            min(asked * (1.0 if asked > 0.0 else ratio), 90.0 * (1.0 - 0.4 * x)), -60.0 * (1.0 + 0.5 * x)
        )

    solved = solve_ivp(
        rate, (0.0, 3.0), [REST], rtol=1e-9, atol=1e-9, max_step=1e-3, t_eval=np.arange(3001) * DT
    )
    ours, _, _ = played(ONE_RATE + effect, np.full(3000, volts))
    np.testing.assert_allclose(ours, solved.y[0], atol=0.05)
    assert np.abs(np.diff(ours)).max() < 0.95 * DT * k * abs(GAIN * volts - REST)  # it is limited at first


OPENED = CommandedOpenings(5.0, 3.0, 260.0, -10.0, 0.5, 0.8)
"""Valves that the command opens: filling from 260 kPa, exhausting to -10 kPa through an orifice."""


def change_through(valves, command, pressure):
    """What the docstring of the form says, [kPa/s]; command as a share of its range."""
    out = 100.0 * max((pressure - valves.outside) / 100.0, 0.0) ** valves.exponent
    return (
        valves.fill * command * (valves.supply - pressure)
        - valves.exhaust * (1.0 - valves.closes * command) * out
    )


@pytest.mark.parametrize("volts", [0.0, 1.0, 3.0, 4.0])
@pytest.mark.parametrize("valves", [OPENED, replace(OPENED, exponent=1.2, closes=0.0)])
def test_valves_opened_by_the_command_follow_their_differential_equation(valves, volts):
    """By scipy, whatever the regulator's rates; within the last kPa before it is empty ours is linear."""
    solved = solve_ivp(
        lambda _t, p: [change_through(valves, volts / 4.0, p[0])], (0.0, 3.0), [REST],
        rtol=1e-9, atol=1e-9, t_eval=np.arange(3001) * DT,
    )  # fmt: skip
    for wrist in (ONE_RATE, WRIST):
        ours, _, _ = played(wrist + valves, np.full(3000, volts))
        np.testing.assert_allclose(ours, solved.y[0], atol=0.02 if volts > 0.0 else 0.2)


def test_linear_valves_that_exclude_each_other_are_a_first_order_lag():
    """The command's range is 0 to 4 V, of 49.4 kPa/V."""
    lag = CommandedOpenings(5.0, 5.0, 4.0 * GAIN, 0.0, 1.0, 1.0)
    volts = np.repeat([3.0, 1.0, 2.5], 700)
    np.testing.assert_allclose(played(WRIST + lag, volts)[0], played(ONE_RATE, volts)[0], atol=1e-3)


@pytest.mark.parametrize("pressure", [30.0, 100.0, 170.0])
def test_a_pressure_is_held_by_the_command_that_lets_in_what_goes_out(pressure):
    wrist = WRIST + OPENED
    command = float(holding_command(wrist, pressure))
    held = brentq(lambda v: change_through(OPENED, v / 4.0, pressure), 0.0, 4.0)
    assert command == pytest.approx(held, abs=1e-6)
    assert abs(command - pressure / GAIN) > 0.02  # where a regulator would hold it


@pytest.mark.parametrize(("pressure", "beyond"), [(-9.9, False), (220.0, False), (245.0, True)])
def test_a_pressure_that_no_command_holds_is_held_outside_the_range(pressure, beyond):
    """At 4 V the pressure rests where 5 (260 - P) is 60 ((P + 10) / 100)^0.5."""
    most = brentq(lambda p: change_through(OPENED, 1.0, p), 0.0, 260.0)
    assert 220.0 < most < 245.0
    held = float(holding_command(WRIST + OPENED, pressure))
    assert (not 0.0 <= held <= 4.0) == beyond


def test_small_motions_through_valves_are_those_of_their_equilibrium():
    """Gain and rate at the ends of the pressures and between them, by differences of the law written out."""
    linear = OPENED.linear(WRIST, np.ones(1), DT, (40.0, 160.0))
    rates, gains = [], []
    for pressure in np.linspace(40.0, 160.0, 5):
        command = brentq(lambda v, p=pressure: change_through(OPENED, v, p), 0.0, 1.0)
        up, down = (change_through(OPENED, command, pressure + h) for h in (1e-4, -1e-4))
        rates.append((down - up) / 2e-4)
        more, less = (change_through(OPENED, command + h, pressure) for h in (1e-6, -1e-6))
        gains.append((more - less) / 2e-6 / rates[-1] / (4.0 * GAIN))
    assert linear.flows == pytest.approx((min(rates), max(rates)), rel=1e-5)
    assert linear.slopes["ascending"] == pytest.approx((min(gains), max(gains)), rel=1e-5)
    shown = {r.rate for r in responses(WRIST + OPENED, np.array([1.0]))}
    assert all(rate.endswith("/s") for rate in shown)


def test_the_pressure_ends_at_the_supply():
    volts = np.full(3000, 190.0 / GAIN)
    capped, _, _ = played(ONE_RATE + CappedPressure(150.0), volts)
    free, _, _ = played(ONE_RATE, volts)
    np.testing.assert_allclose(capped, np.minimum(free, 150.0), atol=1e-9)
    aimed, _, _ = played(ONE_RATE + CappedTarget(150.0), volts)
    np.testing.assert_allclose(aimed, 150.0 - 50.0 * np.exp(-5.0 * np.arange(3001) * DT), atol=1e-9)


def test_the_supply_sags_by_what_is_filled_and_recovers():
    effect = CappedPressure(200.0, 0.2, 3.0)
    c, s = effect.sampled(WRIST, DT), effect.rest(WRIST, 100.0, 0.0)
    s, _ = c.supply(s, 100.0, 140.0)
    assert s.sag == pytest.approx(8.0)
    for _ in range(2000):
        s, after = c.supply(s, 140.0, 140.0)
    assert s.sag == pytest.approx(8.0 * np.exp(-2.0 / 3.0))
    s, after = c.supply(s, 199.0, 250.0)
    assert float(after) == pytest.approx(199.0)  # a pressure that is there is not taken back


def test_a_sag_saturates_at_its_deepest():
    effect = SaturatingSag(200.0, 0.5, 100.0, 30.0)
    c, s = effect.sampled(WRIST, DT), effect.rest(WRIST, 100.0, 0.0)
    for _ in range(3000):  # filled by 1 kPa, and emptied again, for ever
        s, _ = c.supply(s, 100.0, 101.0)
        s, _ = c.supply(s, 101.0, 100.0)
    assert 29.5 < float(s.sag) < 30.0


@pytest.mark.parametrize(("flow", "laminar"), [(3.0, 30.0), (1.5, 500.0), (3.0, 0.5)])
def test_a_tube_fills_no_faster_than_its_flow(flow, laminar):
    """Full command from rest: far below what the regulator would do, the flow alone decides (scipy)."""
    supply, most = 190.0, 4.0

    def rate(time, pressure):
        drop = supply - pressure
        regulated = WRIST.regulator.k_slow * (most * GAIN - pressure)  # at least
        assert (flow * drop / np.sqrt(1.0 + drop / laminar) < 8.0 * regulated).all()
        return flow * drop / np.sqrt(1.0 + drop / laminar)

    count = 150
    time = np.arange(count) * DT
    expected = solve_ivp(rate, (0.0, count * DT), [REST], t_eval=time, rtol=1e-9, atol=1e-9).y[0]
    limited = WRIST + LimitedFlow(supply, 0.0, 8.0, flow, laminar)
    ours = limited.simulate([most] * count).pressure
    assert expected[-1] - REST > 1.0
    np.testing.assert_allclose(ours[:count], expected[: len(ours)], atol=0.01 * (expected[-1] - REST))


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.7])
def test_a_leak_is_the_differential_equation_that_it_says(exponent):
    flow, k = 8.0, ONE_RATE.regulator.k_fast

    def rate(_t, p):
        return k * (GAIN * 3.0 - p) - flow * (p / 100.0) ** exponent

    solved = solve_ivp(rate, (0.0, 1.0), [REST], rtol=1e-10, atol=1e-10, t_eval=np.arange(1001) * DT)
    ours = (ONE_RATE + PowerLeak(flow, exponent)).simulate(np.full(1000, 3.0)).pressure
    np.testing.assert_allclose(ours, solved.y[0], atol=0.02 * flow / k)  # of first order in the sample


def test_a_laminar_leak_sags_exponentially_where_nothing_is_given():
    shut = ONE_RATE.with_values(k_fast=1e-12, k_slow=1e-12) + LaminarLeak(0.3)
    ours = shut.simulate(np.full(2000, 3.0)).pressure
    np.testing.assert_allclose(ours, REST * np.exp(-0.3 * DT * np.arange(2001)), rtol=1e-9)


@pytest.mark.parametrize("leak", [LaminarLeak(0.3), PowerLeak(20.0, 0.5), PowerLeak(20.0, 2.0)])
@pytest.mark.parametrize("pressure", [0.0, -5.0, -80.0])
def test_a_chamber_without_gauge_pressure_has_nothing_to_lose(leak, pressure):
    part = leak.sampled(ONE_RATE, 1e-3)
    _, after = part.supply((), pressure, pressure + 0.25)
    assert after == pressure + 0.25
    _, lost = part.supply((), 50.0, 50.0)
    assert lost < 50.0


def test_a_leaking_chamber_rests_where_the_regulator_gives_what_is_lost():
    k = ONE_RATE.regulator.k_fast
    wrist = ONE_RATE + LaminarLeak(0.3)
    assert float(commanded(wrist, 80.0)) == pytest.approx(80.0 * (1.0 + 0.3 / k), rel=0.02)
    held = np.full(3000, float(holding_command(wrist, REST)))
    np.testing.assert_allclose(wrist.simulate(held).pressure, REST, atol=1e-9)
    plain = wrist.simulate(np.full(20000, BEFORE)).pressure[-1]
    assert plain == pytest.approx(REST / (1.0 + 0.3 / k), rel=0.01)  # below what was commanded


def test_behind_a_tube_a_leaking_wrist_at_rest_stays_there():
    wrist = WRIST + DeadTime(0.05) + ValveOverlap(2.0) + LaminarLeak(0.05)
    state = wrist.rest("line1", 15.0)
    held = np.full(500, float(holding_command(wrist, state.pressure)))
    went = wrist.simulate(held, state).pressure
    np.testing.assert_allclose(went, float(state.pressure), atol=1e-9)


def test_what_holds_a_leak_is_searched_only_where_it_matters(monkeypatch):
    """A state at rest is found by many steps, of which each would else be a search of its own."""
    wrist = WRIST + LaminarLeak(0.05) + DeadTime(0.03) + Creep(0.1, 4.0)
    asked = []
    searched = equilibrium.commanded
    monkeypatch.setattr(equilibrium, "commanded", lambda *seen: asked.append(seen) or searched(*seen))
    state = equilibrium.at_rest(wrist, "line1", 8.0)
    assert len(asked) == 1  # for the dead time's memory of what was commanded
    assert state.effects[0] is not None
    for port in ("static", "drive", "bend", "stop"):
        equilibrium.effects_at_rest(wrist, 120.0, 4.0, port)
    assert len(asked) == 1
    command = float(equilibrium.holding_command(wrist, state.pressure))
    held = wrist.simulate(np.full(3000, command), state=state)
    assert abs(held.angle - 8.0).max() < 1e-6
