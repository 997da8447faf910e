"""Creep, inertia, load, coupling and end stops obey the formulas they are named for."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import lsim

from plants.effects import (
    CompliantStop,
    Coupling,
    Creep,
    DraggedInertia,
    GivingStop,
    GradualLoad,
    HardStop,
    Inertia,
    LoadStep,
    LogCreep,
    PadStop,
    PressureCoupling,
    QuadraticCoupling,
    SpringStop,
    StiffeningInertia,
    TwoTimeCreep,
)
from plants.effects.effect import Around, Nothing
from plants.effects.wrist.creep import LOG_RATIO
from tests.laws.effect_steps import DT, WRIST, moved, ramp


def crept(effect, angles):
    """What a creep adds [deg] to given static angles, from a start at 0."""
    c, s, added = effect.sampled(WRIST, DT), effect.rest(WRIST, 100.0, 0.0), []
    for before, after in pairwise(angles):
        s, _, seen = c.static(s, before, after, Around())
        added.append(seen - after)
    return np.array(added)


@pytest.mark.parametrize(
    ("effect", "parts"),
    [
        (Creep(0.1, 0.5), [(0.1, 0.5)]),
        (TwoTimeCreep(0.06, 0.4, 0.04, 5.0), [(0.06, 0.4), (0.04, 2.0)]),
        (LogCreep(0.15, 0.05), [(0.03, 0.05 * LOG_RATIO**i) for i in range(5)]),
    ],
)
def test_after_a_step_creep_goes_on_exponentially(effect, parts):
    time = np.arange(1, 2001) * DT
    expected = sum(10.0 * g * (1.0 - np.exp(-time / tau)) for g, tau in parts)
    np.testing.assert_allclose(crept(effect, np.full(2001, 10.0)), expected, rtol=1e-9)


def test_creep_is_the_response_of_a_first_order_lag():
    angles = np.cumsum(np.random.default_rng(0).normal(0, 0.1, 1500))
    angles -= angles[0]
    _, lag, _ = lsim(([0.2], [0.3, 1.0]), angles, np.arange(1500) * DT)
    np.testing.assert_allclose(crept(Creep(0.2, 0.3), angles), lag[1:], atol=1e-3)


@pytest.mark.parametrize("inertia", [0.02, 0.0800001, 0.15, 0.5])
def test_inertia_is_the_second_order_response_to_a_broken_line(inertia):
    # Overdamped, critically damped (Tw = 0.16 s) and ringing.
    h = np.interp(np.arange(3001) * DT, [0.0, 0.2, 1.0, 1.5, 3.0], [0.0, 10.0, 10.0, -5.0, 0.0])
    c, y, v = Inertia(inertia).sampled(WRIST, DT), 0.0, Inertia(inertia).rest(WRIST, 100.0, 0.0)
    ours = [0.0]
    for before, after in pairwise(h):
        v, y = c.joint(v, y, before, after, 100.0)
        ours.append(y)
    _, theirs, _ = lsim(([1.0], [inertia**2, WRIST.Tw, 1.0]), h, np.arange(3001) * DT)
    np.testing.assert_allclose(ours, theirs, atol=1e-6)


@pytest.mark.parametrize("inertia", [0.05, 0.15])
@pytest.mark.parametrize(("stiffening", "pressure"), [(0.5, 160.0), (-0.4, 130.0), (0.5, 40.0)])
def test_a_stiffer_joint_is_pulled_as_much_more_as_its_pressure_makes_it(inertia, stiffening, pressure):
    """m^2 y'' + Tw y' + (1 + k) (y - h) = 0, k in proportion to how far the pressure is from rest."""
    effect = StiffeningInertia(inertia, stiffening)
    k = stiffening * (pressure - 100.0) / WRIST.rig.half_range
    time = np.arange(3001) * DT
    h = np.interp(time, [0.0, 0.2, 1.0, 1.5, 3.0], [0.0, 10.0, 10.0, -5.0, 0.0])
    c, y, v = effect.sampled(WRIST, DT), 0.0, effect.rest(WRIST, 100.0, 0.0)
    ours = [0.0]
    for before, after in pairwise(h):
        v, y = c.joint(v, y, before, after, pressure)
        ours.append(y)
    _, theirs, _ = lsim(([1.0 + k], [inertia**2, WRIST.Tw, 1.0 + k]), h, time)
    np.testing.assert_allclose(ours, theirs, atol=2e-3)


def test_drag_takes_from_the_speed_what_its_square_does():
    # m y'' = -d y' |y'| alone, from 100 deg/s: v = v0 / (1 + drag v0 t).
    c = DraggedInertia(0.14, 0.03).sampled(WRIST, DT)
    free, dragged = c._replace(drag=0.0), c
    s = DraggedInertia().rest(WRIST, 100.0, 0.0)._replace(velocity=100.0)
    (one, _), (other, _) = free.joint(s, 0.0, 0.0, 0.0, 100.0), dragged.joint(s, 0.0, 0.0, 0.0, 100.0)
    assert other.velocity == pytest.approx(one.velocity / (1.0 + 0.03 * DT * one.velocity), rel=1e-12)


@pytest.mark.parametrize(("other", "shift"), [(0.0, 0.0), (50.0, 1.0 + 0.25), (-50.0, -1.0 + 0.25)])
def test_the_other_motion_shifts_the_angle(other, shift):
    static = QuadraticCoupling(0.02, 1.0).sampled(WRIST, DT).static
    assert static(Nothing(), 3.0, 4.0, Around(0.0, other))[1:] == pytest.approx((3.0 + shift, 4.0 + shift))
    linear = Coupling(0.02).sampled(WRIST, DT).static(Nothing(), 3.0, 4.0, Around(0.0, other))
    assert linear[2] == pytest.approx(4.0 + 0.02 * other)


def test_pressure_of_the_other_motion_works_the_loop_like_its_own():
    path = ramp(100.0, 160.0, 80.0, 120.0)
    h, angle = moved(WRIST + PressureCoupling(0.1), path, other=50.0)
    # The same loop at 5 kPa more, which it came to in the first sample.
    own_h, own_angle = moved(WRIST, np.concatenate([[100.0], path[1:] + 5.0]))
    np.testing.assert_allclose(h, own_h, atol=1e-12)
    np.testing.assert_allclose(angle, own_angle, atol=1e-12)


def test_a_load_comes_at_its_moment_and_stays():
    at = [
        LoadStep(1.5, 2.0).sampled(WRIST, DT).static(Nothing(), 4.0, 4.0, Around(t))[2] for t in (0, 1.9, 3)
    ]
    assert at == pytest.approx([4.0, 4.0, 5.5])
    gradual = GradualLoad(1.0, 2.0, 0.4, 0.25).sampled(WRIST, DT)
    half = gradual.static(Nothing(), 4.0, 4.0, Around(2.2))
    assert half[1:] == pytest.approx((5.0, 4.0 + (0.2 + DT) / 0.4 * 2.0))


def test_a_hard_stop_stops_and_a_giving_one_gives():
    path = ramp(100.0, 180.0, rate=50.0)
    _, free = moved(WRIST, path)
    _, hard = moved(WRIST + HardStop(-20.0, 11.0), path)
    np.testing.assert_allclose(hard[free < 11.0], free[free < 11.0], atol=1e-12)
    np.testing.assert_allclose(hard[free > 11.5], 11.0)
    static = GivingStop(-20.0, 11.0, 0.1).sampled(WRIST, DT).static
    assert static(Nothing(), 10.0, 16.0, Around())[1:] == pytest.approx((10.0, 11.5))
    assert static(Nothing(), -30.0, -20.0, Around())[1:] == pytest.approx((-21.0, -20.0))
    assert CompliantStop(-20.0, 11.0, 0.1).sampled(WRIST, DT).sensor(Nothing(), 16.0, Around()) == 11.5


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_springs_and_pads_come_to_rest_where_their_push_is_that_of_the_joint(side):
    stops = dict(low=-10.0, high=10.0)
    spring, pad = (e.sampled(WRIST, DT) for e in (SpringStop(**stops, give=0.2), PadStop(**stops, push=1.5)))
    keep = np.exp(-DT / WRIST.Tw)
    y = z = side * 9.0
    h = side * 16.0
    for _ in range(3000):
        y = spring.stop(Nothing(), h + keep * (y - h))
        z = pad.stop(Nothing(), h + keep * (z - h))
    assert y == pytest.approx(side * (10.0 + 0.2 * 6.0), abs=1e-6)
    over = abs(z) - 10.0
    assert 1.5 * over**2 == pytest.approx(16.0 - abs(z), abs=1e-6)


@pytest.mark.parametrize("inertia", [0.0, 0.05, 0.079, 0.081, 0.1, 0.3])
def test_a_bound_is_claimed_until_a_joint_that_rings_turns_back(inertia):
    """For half a period of its poles, those of m s^2 + Tw s + 1 (numpy); for ever where they are real."""
    roots = np.roots([inertia**2, WRIST.Tw, 1.0])
    ends = Inertia(inertia).bound_ends(WRIST)
    if np.isreal(roots).all():
        assert ends is None
    else:
        assert ends == pytest.approx(np.pi / abs(roots[0].imag))
