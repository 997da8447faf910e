"""What every hysteresis law says of its outer branches, of its first slope and of rough parameters is what a
walk along its loop shows."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from plants import FourSegment, PrandtlIshlinskii
from plants.hysteresis import RoughLoop
from tests.laws.law_strategies import HIGH, LOW, REST, between, loops, pressures, walk
from tests.laws.second_law import sums_of_plays

ANY = st.one_of(loops(), sums_of_plays())


@given(ANY, pressures)
def test_a_branch_is_its_rise_less_or_more_its_half(loop, pressure):
    (up, down), (below, above) = loop.rise(pressure), loop.halves(pressure)
    assert up - below == pytest.approx(loop.ascending(pressure), abs=1e-9)
    assert down + above == pytest.approx(loop.descending(pressure), abs=1e-9)
    assert below + above == pytest.approx(
        loop.descending(pressure) - loop.ascending(pressure) + up - down, abs=1e-9
    )


@given(loops(), between(5.0, 90.0))
def test_four_segments_rise_without_their_offsets(loop, far):
    """Which stand in the halves, so that softening leaves the loop its width."""
    assert loop.rise(REST) == (0.0, 0.0)
    assert loop.halves(REST + far) == (loop.w1, loop.w2) == loop.halves(REST)
    assert loop.rise(REST + far) == pytest.approx((loop.a1 * far, loop.a2 * far))


@given(sums_of_plays(), pressures)
def test_plays_rise_in_the_middle_between_their_branches(loop, pressure):
    up, down = loop.rise(pressure)
    assert up == down == pytest.approx(0.5 * (loop.ascending(pressure) + loop.descending(pressure)))


@given(ANY, pressures, pressures, st.booleans())
def test_a_move_back_begins_along_the_first_slope(loop, start, end, virgin):
    """Unless the output curve bends just there, or the other branch is met at once."""
    assume(abs(end - start) > 1.0)
    memory = loop.initial() if virgin else walk(loop, [LOW, start, end])
    at = REST if virgin else end
    back = at + (1e-4 if (virgin or end < start) else -1e-4)
    moved = float(loop.step(memory, at, back).h) - float(memory.h)
    slope = moved / (back - at)
    if isinstance(loop, FourSegment):
        gap = loop.descending(back) - loop.ascending(back)
        assume(gap > 1e-3)
        assert slope == pytest.approx(float(loop.first_slope(memory)), abs=1e-6)
        assert float(loop.first_slope(memory)) == (0.0 if float(memory.virgin) else loop.s)
    else:
        assert loop.first_slope(memory) == loop.flattest


@pytest.mark.slow
@given(ANY)
def test_outer_branches_are_straight_where_it_says_so(loop):
    p = np.linspace(LOW - 200.0, HIGH + 200.0, 4001)
    bends = max(
        float(np.abs(np.diff(np.vectorize(f)(p), 2)).max()) for f in (loop.ascending, loop.descending)
    )
    if loop.straight():
        assert bends < 1e-9
    elif (
        any(
            loop.uncurved(loop.descending(p[0]))
            < loop.centre + k * loop.span
            < loop.uncurved(loop.ascending(p[-1]))
            for k in (-2.0, -1.0, 1.0, 2.0)
        )
        and min(abs(a - b) for a, b in pairwise((loop.b2, loop.b1, 1.0, loop.c1, loop.c2))) > 1e-3
    ):
        assert bends > 1e-9
    plain = PrandtlIshlinskii(0.08, (0.28,), 20.0)
    assert plain.straight()
    for slope in ("b2", "b1", "c1", "c2"):
        assert not PrandtlIshlinskii(0.08, (0.28,), 20.0, **{slope: 1.5}).straight()


def test_each_branch_has_its_side():
    one, other = FourSegment(0.4, 6.0, 0.36, 6.0, 0.08), PrandtlIshlinskii(0.08, (0.28,), 20.0)
    found = one.branches(LOW, HIGH)
    assert {b: one.sides(b) for b in found} == {
        "transit": ("inner",), "line1": ("ascending",), "line2": ("descending",)
    }  # fmt: skip
    for side, branch in (("ascending", one.ascending), ("descending", one.descending)):
        (name,) = (b for b in found if one.sides(b) == (side,))
        assert branch(121.0) - branch(120.0) == pytest.approx(found[name])
    assert {b: other.sides(b) for b in other.branches(LOW, HIGH)} == {
        "after a reversal": ("inner",), "outer branch": ("ascending", "descending")
    }  # fmt: skip


@settings(max_examples=60)
@given(
    between(0.05, 2.0), between(0.0, 60.0), between(0.05, 2.0), between(0.0, 60.0), between(0.0, 2.0),
    between(20.0, 150.0), st.lists(between(0.0, 1.0), min_size=5, max_size=5),
)  # fmt: skip
def test_within_the_bounds_that_keep_lines_apart_there_is_a_loop(a1, w1, a2, w2, s, rest, shares):
    """Of any five numbers, up to the edges, at which the lines may touch; the mean slope lies within, and so
    does the mean offset where it is not next to nothing."""
    loop = FourSegment(a1, w1, a2, w2, s, rest)
    bounds = loop.kept_apart(LOW, HIGH)
    assert set(bounds) == {"a1", "w1", "a2", "w2", "s"}
    corners = [[k >> bit & 1 for bit in range(5)] for k in range(32)]
    for at in (shares, *corners):
        inside = {n: low + (1e-6 + x * (1.0 - 2e-6)) * (high - low)
                  for x, (n, (low, high)) in zip(at, bounds.items(), strict=True)}  # fmt: skip
        assert FourSegment(**inside, rest_pressure=rest).problem(LOW, HIGH) is None
    assert bounds["a1"][0] <= 0.5 * (a1 + a2) <= bounds["a1"][1]
    assert bounds["w1"] == bounds["w2"]
    assert bounds["a1"] == bounds["a2"]
    width = 0.5 * (w1 + w2)
    if width > 0.02 * 2.0 * 200.0:
        assert bounds["w1"][0] < width < bounds["w1"][1]
    assert not PrandtlIshlinskii(0.08, (0.28,), 20.0).kept_apart(LOW, HIGH)


@pytest.mark.parametrize("law", [FourSegment, PrandtlIshlinskii])
@given(between(0.2, 1.0), between(0.0, 0.15), between(2.0, 30.0), between(50.0, 150.0), between(60.0, 150.0))
def test_a_rough_loop_is_as_steep_and_as_wide_as_it_was_said_to_be(law, outer, inner, gap, rest, reach):
    known = RoughLoop.of_equal_plays(outer, inner, gap, rest, rest - reach, rest + reach)
    found = law.from_values(law.guess(known))
    assert found.rest_pressure == pytest.approx(rest)
    assert found.problem(rest - reach, rest + reach) is None
    assert float(found.flattest) == pytest.approx(inner)
    # Once all of it is engaged: half the distance of its branches, over the slope that makes it.
    for slope, branch in zip(found.steepness, (found.ascending, found.descending), strict=True):
        assert float(slope) == pytest.approx(outer)
        assert branch(rest + 1.0) - branch(rest) == pytest.approx(outer)
    half = 0.5 * (found.descending(rest) - found.ascending(rest))
    assert half == pytest.approx((outer - inner) * gap)


@given(ANY, between(-30.0, 30.0))
def test_at_rest_at_an_angle_pressures_are_those_of_the_branches_and_their_middle(loop, angle):
    rests = loop.rest_between(angle)
    assert loop.ascending(rests["line1"]) == pytest.approx(angle, abs=1e-6)
    assert loop.descending(rests["line2"]) == pytest.approx(angle, abs=1e-6)
    assert rests["inside"] == pytest.approx(0.5 * (rests["line1"] + rests["line2"]))


@given(ANY, between(-200.0, 200.0))
def test_an_angle_is_kept_within_what_all_memories_reach(loop, angle):
    low, high = loop.reachable(LOW, HIGH)
    assume(low < high)
    assert (low, high) == (loop.descending(LOW), loop.ascending(HIGH))
    kept = float(loop.clamped(angle, LOW, HIGH))
    assert kept == pytest.approx(min(max(angle, low), high))
