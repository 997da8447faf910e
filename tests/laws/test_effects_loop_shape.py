"""Plays beside the loop, one that engages smoothly, and curved transits are what their laws say; a wrist with
them rests where it says."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plants.effects.wrist.creep import Creep
from plants.effects.wrist.loop_shape import CurvedTransit, OneMorePlay, SeveralPlays, SmoothLoop
from plants.equilibrium import at_pressure
from plants.measured.campaigns.begin import Begin
from plants.measured.fitting.stage import begun
from tests.laws.effect_steps import WRIST, moved, ramp

PATH = ramp(100.0, 160.0, 120.0, 140.0, 60.0, 110.0, rate=200.0)
SEVERAL = SeveralPlays(0.05, 0.02, 0.08, 30.0)


def played(thresholds, weights):
    """The sum of plays [deg] along the path, each play by its definition."""
    found = []
    plays = [0.0] * len(thresholds)
    for x in PATH - 100.0:
        plays = [max(min(p, x + r), x - r) for p, r in zip(plays, thresholds, strict=True)]
        found.append(sum(w * p for w, p in zip(weights, plays, strict=True)))
    return np.array(found)


@pytest.mark.parametrize(
    ("effect", "thresholds", "weights"),
    [
        (OneMorePlay(0.1, 12.0), (12.0,), (0.1,)),
        (SeveralPlays(0.05, -0.02, 0.08, 30.0), (7.5, 15.0, 30.0), (0.05, -0.02, 0.08)),
    ],
)
def test_plays_are_added_to_what_the_loop_gives(effect, thresholds, weights):
    instant = WRIST.with_values(Tw=1e-9)
    _, plain = moved(instant, PATH)
    _, ours = moved(instant + effect, PATH)
    np.testing.assert_allclose(ours[1:] - plain[1:], played(thresholds, weights)[1:], atol=1e-7)


def test_a_play_that_engages_smoothly_is_bouc_wens_law():
    weight, most, power = 0.12, 20.0, 1.7
    x = 45.0 * np.sin(np.linspace(0.0, 9.0, 4001))

    def rate(t, z):
        move = 45.0 * np.cos(t)
        return [move * (1.0 - (abs(z[0]) / most) ** power if move * z[0] > 0.0 else 1.0)]

    z = solve_ivp(rate, (0.0, 9.0), [0.0], t_eval=np.linspace(0.0, 9.0, 4001), rtol=1e-9, max_step=0.01).y[0]
    instant = WRIST.with_values(Tw=1e-9)
    _, plain = moved(instant, 100.0 + x)
    _, ours = moved(instant + SmoothLoop(weight, most, power), 100.0 + x)
    np.testing.assert_allclose(ours - plain, weight * (x - z), atol=2e-3)


@pytest.mark.parametrize("power", [0.5, 1.0, 1.5])
@pytest.mark.parametrize("share", [0.6, 1.0])
@pytest.mark.parametrize("up", [True, False], ids=["up", "down"])
def test_a_curved_transit_meets_the_line_ahead_with_its_slope(up, share, power):
    """Between lines that are not as steep as each other, dh/dx = s + share (a - s) way^power, a of the line
    ahead and way what is gone of the gap."""
    wrist = WRIST.with_values(a2=0.8 * WRIST.hysteresis.a1)
    loop, ends = wrist.hysteresis, (60.0, 150.0) if up else (150.0, 60.0)
    steep = loop.a1 if up else loop.a2

    def rate(x, h):
        low, high = loop.ascending(x), loop.descending(x)
        way = np.clip((high - h[0] if up else h[0] - low) / (high - low), 0.0, 1.0)
        return [loop.s + share * (steep - loop.s) * way**power]

    path = np.concatenate([ramp(100.0, 250.0 - ends[0], ends[0]), ramp(*ends)[1:]])
    h, _ = moved(wrist + CurvedTransit(share, power), path)
    turn = len(path) - len(ramp(*ends))
    back = path[turn:]
    free = solve_ivp(rate, ends, [h[turn]], t_eval=back, rtol=1e-10, max_step=0.5).y[0]
    kept = np.clip(free, loop.ascending(back), loop.descending(back))
    np.testing.assert_allclose(h[turn:], kept, atol=2e-3)
    plain, _ = moved(wrist, path)
    assert np.abs(h - plain)[turn:].max() > 0.05


@pytest.mark.parametrize("effect", [SEVERAL, SmoothLoop(0.1, 20.0, 1.5)])
@pytest.mark.parametrize("start", ["line1", "line2", "inside"])
def test_a_wrist_with_plays_and_creep_stays_at_rest(start, effect):
    wrist = WRIST + effect + Creep(0.1, 0.5)
    state = wrist.rest(start, 9.0)
    _, angle = moved(wrist, np.full(3000, float(state.pressure)), state=state)
    np.testing.assert_allclose(angle, 9.0, atol=1e-9)


def test_the_rest_at_a_pressure_is_the_rest_at_its_angle():
    wrist = WRIST + SEVERAL
    state = at_pressure(wrist, "line1", 130.0)
    assert float(wrist.rest("line1", state.angle).pressure) == pytest.approx(130.0, abs=1e-6)


def test_a_recording_that_begins_elsewhere_begins_at_the_angle_that_was_seen():
    wrist = WRIST + SEVERAL
    _, angle = moved(wrist, np.full(500, 140.0), state=begun(wrist, Begin(140.0, 16.0, False)))
    np.testing.assert_allclose(angle, 16.0, atol=1e-9)


def test_slopes_lie_between_none_of_the_plays_engaged_and_all():
    added = (WRIST + SEVERAL).effects[0].linear(WRIST, 1.0, 0.001, (0.0, 200.0)).added
    assert added["ascending"] == added["inner"] == pytest.approx((0.0, 0.15))
    curved = CurvedTransit(1.0).linear(WRIST, 1.0, 0.001, (0.0, 200.0)).slopes
    assert list(curved) == ["inner"]
    steepest = max(map(float, WRIST.hysteresis.steepness)) / WRIST.hysteresis.s
    assert curved["inner"] == pytest.approx((1.0, steepest))


@pytest.mark.parametrize("wider", [0.8, 1.25])
def test_a_curved_transit_becomes_as_steep_as_the_steeper_line(wider):
    loop = WRIST.hysteresis
    lines = WRIST.with_values(a2=wider * loop.a1)
    slope = CurvedTransit(1.0).linear(lines, 1.0, 0.001, (0.0, 200.0)).slopes["inner"][1] * loop.s
    assert slope == pytest.approx(loop.a1 * max(1.0, wider))
