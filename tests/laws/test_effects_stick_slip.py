"""A joint with friction sticks until the breakaway and slides as its equation says."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plants.effects import FreeSlip, Presliding, RubbingSlip
from tests.laws.effect_steps import DT, WRIST

TW = WRIST.Tw


def joint(effect, angles, angle=0.0):
    """Angles of the joint [deg], (n,), under given static angles, from rest."""
    c, s, found = effect.sampled(WRIST, DT), effect.rest(WRIST, 100.0, angle), [angle]
    for before, after in pairwise(angles):
        s, angle = c.joint(s, angle, before, after, 100.0)
        found.append(float(angle))
    return np.array(found)


def slid(begin, end, friction, angle, rate):
    """The sliding joint between two times [s] under a static angle that grows at a rate [deg/s]."""
    time = np.clip(np.arange(begin, end + DT / 2, DT), begin, end)
    found = solve_ivp(
        lambda t, y: (rate * t - friction - y) / TW, (begin, end), [angle], t_eval=time, rtol=1e-10
    )
    return found.y[0]


@pytest.mark.parametrize(
    ("effect", "friction"), [(FreeSlip(1.0, 0.3), 0.0), (RubbingSlip(1.0, 0.5, 0.1), 0.5)]
)
def test_under_a_ramp_it_holds_breaks_away_and_slides_as_the_differential_equation_does(effect, friction):
    rate = 2.0
    angles = rate * DT * np.arange(1001)
    ours = joint(effect, angles)
    assert not ours[:500].any()  # the breakaway of 1 deg is reached at 0.5 s
    expected = slid(0.5, 1.0, friction, 0.0, rate)
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


def test_a_contact_that_gives_follows_by_its_share():
    angles = 0.9 * np.sin(0.002 * np.arange(3000))
    np.testing.assert_allclose(joint(Presliding(1.0, 0.5, 0.2, 0.1), angles), 0.1 * angles, atol=1e-12)
