"""The loop closes, keeps minor loops inside the major one, and forgets what a larger swing wipes out."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from plants.hysteresis import Memory
from tests.laws.law_strategies import HIGH, REST, loops, paths, pressures, trace, walk

VIRGIN = Memory(0.0, 1.0)
ROUNDING = 1e-9


@given(loops(), paths, pressures, pressures)
def test_after_one_cycle_every_cycle_retraces_the_same_loop(loop, path, one, other):
    cycle = [one, other]
    memory = walk(loop, [*path, one, *cycle[::-1]])  # at `one`, after one full cycle
    _, second, memory = trace(loop, cycle[::-1], one, memory)
    _, third, _ = trace(loop, cycle[::-1], one, memory)
    np.testing.assert_allclose(second, third, rtol=0, atol=ROUNDING)


@given(loops(), paths, pressures, pressures)
def test_the_rising_branch_never_lies_above_the_falling_one(loop, path, one, other):
    low, high = sorted((one, other))
    memory = walk(loop, [*path, low, high, low])
    _, rising, memory = trace(loop, [high], low, memory)
    _, falling, _ = trace(loop, [low], high, memory)
    assert (rising <= falling[::-1] + ROUNDING).all()


@given(loops(), pressures, pressures, st.lists(st.floats(0.0, 1.0), min_size=1, max_size=10))
def test_minor_loops_stay_inside_the_major_one(loop, one, other, shares):
    low, high = sorted((one, other))
    start = walk(loop, [high, low, high, low])
    xr, rising, top = trace(loop, [high], low, start)
    xf, falling, _ = trace(loop, [low], high, top)
    x, h, _ = trace(loop, [low + s * (high - low) for s in shares], high, top)
    # Both branches are straight between their corners, so their pieces bound the angle closely.
    slack = max(loop.a1, loop.a2) * (high - low) / 40 / 4 + ROUNDING
    assert (h >= np.interp(x, xr, rising) - slack).all()
    assert (h <= np.interp(x, xf[::-1], falling[::-1]) + slack).all()


@given(loops(), paths, pressures, st.floats(0.0, 1.0), st.integers(1, 3))
def test_a_minor_loop_ends_where_it_began(loop, path, turn, share, times):
    # Return-point memory: back at a turning point, the excursion from it is forgotten.
    before = path[-1]
    inner = turn + share * (before - turn)  # between the turning point and the one before it
    at_turn = walk(loop, [*path, turn])
    back = walk(loop, [inner, turn] * times, turn, at_turn)
    assert abs(float(back.h) - float(at_turn.h)) < ROUNDING
    assert float(back.virgin) == float(at_turn.virgin)


@given(loops(), paths, pressures, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_a_larger_swing_wipes_out_a_smaller_one(loop, path, end, share, inner):
    before = path[-1]
    turn = before + share * (end - before)
    back = turn + inner * (before - turn)
    direct = walk(loop, [*path, end])
    detour = walk(loop, [*path, turn, back, end])
    assert abs(float(direct.h) - float(detour.h)) < ROUNDING


@given(loops(parallel=True), paths, paths)
def test_two_histories_merge_once_the_pressure_has_swept_the_widest_transit(loop, one, other):
    far = REST + 2.0 * HIGH + (loop.w1 + loop.w2) / (loop.a1 - loop.s)
    ends = [walk(loop, [*path, far, *one]) for path in (one, other)]
    assert abs(float(ends[0].h) - float(ends[1].h)) < ROUNDING


@given(loops(), paths, paths)
def test_the_order_of_two_wrists_is_kept(loop, path, common):
    # Of two wrists under the same pressure, the one at the larger angle never falls below the other.
    low = walk(loop, [*path, 0.0, 60.0])
    high = walk(loop, [*path, 200.0, 60.0])
    assert float(low.h) <= float(high.h) + ROUNDING
    for after, before in zip(common, [60.0, *common[:-1]], strict=True):
        low, high = walk(loop, [after], before, low), walk(loop, [after], before, high)
        assert float(low.h) <= float(high.h) + ROUNDING
