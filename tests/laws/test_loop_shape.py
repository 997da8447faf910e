"""The angle never leaves the band between line 1 and line 2, and meets each line where it should."""

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from plants import Wrist
from plants.hysteresis import Memory
from tests.laws.law_strategies import HIGH, LOW, REST, between, loops, paths, pressures, trace, walk

VIRGIN = Memory(0.0, 1.0)
ROUNDING = 1e-10


@given(loops(), paths)
def test_no_line_is_overstepped(loop, path):
    x, h, _ = trace(loop, path, REST, VIRGIN)
    assert (h >= loop.ascending(x) - ROUNDING).all()
    assert (h <= loop.descending(x) + ROUNDING).all()


@given(loops(), between(0.001, 0.999))
def test_upward_from_rest_the_wrist_stands_still_until_w1_over_a1(loop, share):
    edge = REST + loop.w1 / loop.a1
    inside = walk(loop, [REST + share * (edge - REST)])
    assert (float(inside.h), float(inside.virgin)) == (0.0, 1.0)
    beyond = edge + share * (HIGH - edge)
    left = walk(loop, [beyond])
    assert (float(left.h), float(left.virgin)) == (loop.ascending(beyond), 0.0)


@given(loops(), between(0.001, 0.999))
def test_downward_from_rest_the_wrist_stands_still_until_w2_over_a2(loop, share):
    edge = REST - loop.w2 / loop.a2
    inside = walk(loop, [REST + share * (edge - REST)])
    assert (float(inside.h), float(inside.virgin)) == (0.0, 1.0)
    beyond = edge + share * (LOW - edge)
    left = walk(loop, [beyond])
    assert (float(left.h), float(left.virgin)) == (loop.descending(beyond), 0.0)


@given(loops(), st.lists(between(-0.999, 0.999), min_size=1, max_size=8))
def test_wandering_within_the_dead_zone_leaves_no_trace(loop, shares):
    path = [REST + s * (loop.w1 / loop.a1 if s > 0 else loop.w2 / loop.a2) for s in shares]
    memory = walk(loop, path)
    assert (float(memory.h), float(memory.virgin)) == (0.0, 1.0)


@given(loops(), pressures, pressures)
def test_falling_from_line_1_the_angle_takes_the_transit_until_line_2(loop, one, other):
    after, before = sorted((one, other))
    memory = loop.step(Memory(loop.ascending(before), 0.0), before, after)
    transit = loop.ascending(before) - loop.s * (before - after)
    assert abs(float(memory.h) - min(transit, loop.descending(after))) < ROUNDING


@given(loops(), pressures, pressures)
def test_rising_from_line_2_the_angle_takes_the_transit_until_line_1(loop, one, other):
    before, after = sorted((one, other))
    memory = loop.step(Memory(loop.descending(before), 0.0), before, after)
    transit = loop.descending(before) + loop.s * (after - before)
    assert abs(float(memory.h) - max(transit, loop.ascending(after))) < ROUNDING


@given(loops(parallel=True), paths)
def test_rising_far_enough_ends_on_line_1_and_falling_on_line_2_whatever_came_before(loop, path):
    far = 2.0 * HIGH + (loop.w1 + loop.w2) / (loop.a1 - loop.s)  # the widest transit, and some more
    up, down = walk(loop, [*path, REST + far]), walk(loop, [*path, REST - far])
    assert (float(up.h), float(up.virgin)) == (loop.ascending(REST + far), 0.0)
    assert (float(down.h), float(down.virgin)) == (loop.descending(REST - far), 0.0)


@given(loops(), paths)
def test_the_angle_never_moves_against_the_pressure(loop, path):
    x, h, _ = trace(loop, path, REST, VIRGIN)
    assert (np.diff(h) * np.sign(np.diff(x)) >= -ROUNDING).all()


@given(loops(), between(-60.0, 60.0))
def test_line_pressures_are_the_inverse_of_the_lines(loop, h):
    assert abs(loop.ascending(loop.ascending_pressure(h)) - h) < ROUNDING
    assert abs(loop.descending(loop.descending_pressure(h)) - h) < ROUNDING


@given(
    st.sampled_from(["flexion", "deviation"]), st.sampled_from(["line1", "line2", "inside"]), between(-15, 15)
)
def test_a_wrist_at_rest_lies_in_the_band_and_stays_there(axis, start, angle):
    wrist = getattr(Wrist, axis)()
    state = wrist.rest(start, angle)
    assume(LOW <= state.pressure <= HIGH)
    p = wrist.hysteresis
    assert p.ascending(state.pressure) - ROUNDING <= angle <= p.descending(state.pressure) + ROUNDING
    held = wrist.simulate([state.pressure / wrist.regulator.gain] * 200, state)
    assert np.abs(held.angle - angle).max() < 1e-9
