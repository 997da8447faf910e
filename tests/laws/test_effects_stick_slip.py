"""A joint with friction sticks until the breakaway and slides as its differential equation says."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plants.dynamics import turned
from plants.effects.wrist.inertia import Inertia
from plants.effects.wrist.stick_slip import SPRINGS, BristleFriction, FreeSlip, MaxwellSlip, RubbingSlip
from tests.laws.effect_steps import DT, WRIST

TW = WRIST.Tw
MASSLESS = BristleFriction(1.0, 0.6, 3.0, 20.0)


def joint(effect, angles, dt=DT, beside=()):
    """Angles of the joint [deg], (n,), under given static angles, from rest at 0."""
    wrist = replace(WRIST, effects=(*beside, effect))
    c, s, angle = wrist.sampled(dt), [e.rest(wrist, 100.0, 0.0) for e in wrist.effects], 0.0
    found = [angle]
    for before, after in pairwise(angles):
        s, angle = turned(angle, s, before, after, 100.0, c)
        found.append(float(angle))
    return np.array(found)


@pytest.mark.parametrize(
    ("effect", "friction"), [(FreeSlip(1.0, 0.3), 0.0), (RubbingSlip(1.0, 0.5, 0.1), 0.5)]
)
def test_under_a_ramp_it_holds_breaks_away_and_slides_as_the_differential_equation_does(effect, friction):
    rate = 2.0
    ours = joint(effect, rate * DT * np.arange(1001))
    assert not ours[:500].any()  # the breakaway of 1 deg is reached at 0.5 s
    expected = solve_ivp(
        lambda t, y: (rate * t - friction - y) / TW, (0.5, 1.0), [0.0], t_eval=np.linspace(0.5, 1.0, 501),
        rtol=1e-10,
    ).y[0]  # fmt: skip
    np.testing.assert_allclose(ours[500:], expected, atol=0.02)


def test_under_a_slow_ramp_it_sticks_and_slips_in_turn():
    """The pull changes by rate - pull/Tw from breakaway to residue, by the rate while the joint sticks."""
    rate, breakaway, residue = 0.5, 1.0, 0.3
    ours = joint(FreeSlip(breakaway, residue), rate * DT * np.arange(20_001))
    sticks = (breakaway - residue) / rate
    slides = TW * np.log((breakaway - rate * TW) / (residue - rate * TW))
    begins = np.flatnonzero(np.diff((np.diff(ours) > 0.0).astype(int)) == 1) * DT
    np.testing.assert_allclose(np.diff(begins), sticks + slides, atol=5.0 * DT)


def test_after_a_reversal_it_stays_until_the_pull_has_turned_round():
    up, down = 0.01 * np.arange(1001), 10.0 - 0.01 * np.arange(601)
    ours = joint(RubbingSlip(1.0, 0.5, 0.2), np.concatenate([up, np.full(3000, 10.0), down]))
    at = ours[4000]
    assert at == pytest.approx(10.0 - 0.6, abs=0.02)  # where 0.5 + 0.2 (1 - 0.5) deg of pull are left
    stuck = down >= at - 1.0 + 0.02
    np.testing.assert_allclose(ours[4001:][stuck], at, atol=1e-12)
    assert ours[-1] < at - 1.0


@pytest.mark.parametrize(
    "effect",
    [RubbingSlip(1.0, 0.5, 0.2), FreeSlip(1.0, 0.3), BristleFriction(1.0, 0.5), MaxwellSlip(1.0, 8.0)],
)
def test_friction_is_the_same_in_both_directions(effect):
    """Sticking, sliding and sticking again are odd in the static angle, on the way out and back."""
    path = np.concatenate([0.004 * np.arange(1501), np.full(2000, 6.0), 6.0 - 0.004 * np.arange(2501)])
    there = joint(effect, path)
    assert np.ptp(there) > 5.0
    np.testing.assert_allclose(joint(effect, -path), -there, atol=1e-12)


def lugre(breakaway, sliding, stribeck, stiffness, static, end, inertia=0.0):
    """LuGre's joint, without mass or with it, by scipy's implicit integrator: angle at every ms."""

    def bristles(speed, pull):
        most = breakaway * (sliding + (1.0 - sliding) * np.exp(-((speed / stribeck) ** 2)))
        return stiffness * (speed - abs(speed) * pull / most)

    def massless(t, state):
        angle, pull = state
        speed = (static(t) - angle - pull) / TW
        return [speed, bristles(speed, pull)]

    def massive(t, state):
        angle, pull, speed = state
        return [speed, bristles(speed, pull), (static(t) - angle - pull - TW * speed) / inertia**2]

    time, rates = np.arange(0.0, end + DT / 2, DT), massive if inertia else massless
    start = [0.0] * (3 if inertia else 2)
    found = solve_ivp(rates, (0.0, end), start, "Radau", time, rtol=1e-8, atol=1e-10, max_step=0.002)
    return time, found.y[0]


@pytest.mark.slow
@pytest.mark.parametrize("every", [1, 5])
def test_bristles_are_lugres_law(every):
    """At 1 ms, and at the 5 ms at which a log is fitted."""

    def static(t):
        return 4.0 * np.sin(2.5 * t)

    time, expected = lugre(1.0, 0.6, 3.0, 20.0, static, 5.0)
    ours = joint(BristleFriction(1.0, 0.6, 3.0, 20.0), static(time[::every]), every * DT)
    assert np.abs(ours - expected[::every]).max() < (0.002 if every == 1 else 0.03)
    plain = solve_ivp(lambda t, y: (static(t) - y) / TW, (0.0, 5.0), [0.0], t_eval=time, rtol=1e-9).y[0]
    assert np.abs(plain - expected).max() > 0.5  # what friction makes of it


@pytest.mark.slow
@pytest.mark.parametrize("every", [1, 5])
def test_a_mass_on_bristles_swings_until_they_hold_it(every):
    def static(t):
        return 4.0 * np.sign(np.sin(1.9 * t)) + 1.5 * np.sin(4.1 * t)

    inertia = 0.15
    time, expected = lugre(1.0, 0.6, 3.0, 20.0, static, 5.0, inertia)
    ours = joint(BristleFriction(1.0, 0.6, 3.0, 20.0), static(time[::every]), every * DT, [Inertia(inertia)])
    assert np.abs(ours - expected[::every]).max() < (0.02 if every == 1 else 0.05)
    for less in (
        joint(BristleFriction(), static(time), DT, [Inertia(inertia)]),
        joint(MASSLESS, static(time)),
    ):
        assert np.abs(less - expected).max() > 0.5  # without friction, and without a mass


def test_bristles_bend_before_the_joint_slides():
    """Under a small load the joint follows by 1 / (1 + stiffness) of it."""
    load = 0.2 * (1.0 - np.cos(np.linspace(0.0, np.pi, 3001)))
    ours = joint(BristleFriction(5.0, 1.0, 10.0, 24.0), load)
    assert ours[-1] == pytest.approx(load[-1] / 25.0, rel=0.1)


@pytest.mark.parametrize("every", [1, 5])
def test_springs_slip_one_after_the_other_as_their_differential_equation_says(every):
    """Of all turning points the loop remembers, as a sum of plays of the joint's own angle (scipy)."""
    breakaway, stiffness = 1.5, 8.0
    most = breakaway * (2.0 * np.arange(SPRINGS) + 1.0) / SPRINGS**2
    assert most.sum() == pytest.approx(breakaway)

    def static(t):
        return 3.0 * np.sin(2.5 * t) + 1.5 * np.sin(6.1 * t)

    def rates(t, state):
        angle, pulls = state[0], state[1:]
        speed = (static(t) - angle - np.clip(pulls, -most, most).sum()) / TW
        slips = (np.abs(pulls) >= most) & (pulls * speed > 0.0)
        return np.concatenate([[speed], np.where(slips, 0.0, stiffness / SPRINGS * speed)])

    time = np.arange(0.0, 4.0 + DT / 2, DT)
    solved = solve_ivp(rates, (0.0, 4.0), np.zeros(1 + SPRINGS), t_eval=time, rtol=1e-8, max_step=2e-4).y[0]
    ours = joint(MaxwellSlip(breakaway, stiffness), static(time[::every]), every * DT)
    assert np.abs(ours - solved[::every]).max() < (0.003 if every == 1 else 0.02)
    plain = solve_ivp(lambda t, y: (static(t) - y) / TW, (0.0, 4.0), [0.0], t_eval=time, rtol=1e-9).y[0]
    assert np.abs(plain - solved).max() > 0.5  # what friction makes of it


@pytest.mark.parametrize("every", [1, 5])
def test_a_mass_on_springs_that_slip_is_its_differential_equation(every):
    breakaway, stiffness, inertia = 1.5, 8.0, 0.15
    most = breakaway * (2.0 * np.arange(SPRINGS) + 1.0) / SPRINGS**2

    def static(t):
        return 3.0 * np.sin(2.5 * t) + 1.5 * np.sin(6.1 * t)

    def rates(t, state):
        angle, speed, pulls = state[0], state[1], state[2:]
        slips = (np.abs(pulls) >= most) & (pulls * speed > 0.0)
        force = static(t) - angle - np.clip(pulls, -most, most).sum() - TW * speed
        return np.concatenate(
            [[speed, force / inertia**2], np.where(slips, 0.0, stiffness / SPRINGS * speed)]
        )

    time = np.arange(0.0, 4.0 + DT / 2, DT)
    solved = solve_ivp(rates, (0.0, 4.0), np.zeros(2 + SPRINGS), t_eval=time, rtol=1e-8, max_step=2e-4).y[0]
    ours = joint(MaxwellSlip(breakaway, stiffness), static(time[::every]), every * DT, [Inertia(inertia)])
    assert np.abs(ours - solved[::every]).max() < (0.01 if every == 1 else 0.05)
    plain = joint(MaxwellSlip(breakaway, stiffness), static(time))
    assert np.abs(plain - solved).max() > 0.5


def test_a_mass_under_friction_without_one_is_redundant():
    for friction in (FreeSlip(1.0, 0.3), RubbingSlip(1.0, 0.5, 0.2)):
        assert Inertia(0.1).redundant(WRIST + Inertia(0.1) + friction)
    assert not Inertia(0.1).redundant(WRIST + Inertia(0.1) + BristleFriction(1.0, 0.5))


def test_no_friction_is_the_lag():
    angles = np.sin(0.01 * np.arange(1000))
    from plants import lag

    expected, c = [0.0], lag.sampled(TW, DT)
    for before, after in pairwise(angles):
        expected.append(float(lag.step(expected[-1], before, after, c)))
    for effect in (FreeSlip(), RubbingSlip(), BristleFriction(), MaxwellSlip()):
        np.testing.assert_allclose(joint(effect, angles), expected, atol=2e-5)
