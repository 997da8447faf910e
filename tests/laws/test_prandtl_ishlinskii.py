"""Prandtl-Ishlinskii keeps what a hysteresis law promises, and four equal segments are its special case."""

import control
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from plants import FourSegment, PrandtlIshlinskii, Wrist
from plants.dynamics import step
from plants.errors import InputError
from plants.hysteresis import RoughLoop, law_of
from plants.hysteresis.law import Bend
from plants.kernel import pytrees
from plants.linearisation import nlsys, wrist_x0
from plants.parameters.files import dump, load
from tests.laws.law_strategies import HIGH, LOW, REST, between, paths, pressures, symmetric_loops, trace, walk
from tests.laws.second_law import LOOP, counted_from, second_law_set, sums_of_plays

ROUNDING = 1e-10
starts = st.sampled_from(["line1", "line2", "inside"])
shares = st.floats(0.0, 1.0)


def rough(outer, inner, gap, rest):
    """What is guessed of a loop of which this is known."""
    known = RoughLoop.of_equal_plays(outer, inner, gap, rest, LOW, HIGH)
    return PrandtlIshlinskii.from_values(PrandtlIshlinskii.guess(known))


def as_plays(loop: FourSegment) -> PrandtlIshlinskii:
    """The sum of one play that four segments of equal slopes are."""
    weight = loop.a1 - loop.s
    return PrandtlIshlinskii(loop.s, (weight,), loop.w1 / weight, rest_pressure=loop.rest_pressure)


@given(symmetric_loops(), starts, between(-15.0, 15.0), paths)
def test_four_segments_of_equal_slopes_are_one_play(loop, start, angle, path):
    plays = as_plays(loop)
    before = loop.rest_between(angle)[start]
    one, other = loop.resting(start, angle, before), plays.resting(start, angle, before)
    for after in path:
        one, other = loop.step(one, before, after), plays.step(other, before, after)
        assert abs(float(one.h) - float(other.h)) < 1e-12
        before = after


@given(symmetric_loops(), paths)
def test_from_rest_too_where_the_transit_has_no_slope(loop, path):
    flat = FourSegment(loop.a1, loop.w1, loop.a2, loop.w2, 0.0, loop.rest_pressure)
    plays = as_plays(flat)
    for last in range(len(path)):
        history = path[: last + 1]
        assert abs(float(walk(flat, history).h) - float(walk(plays, history).h)) < 1e-12


@given(sums_of_plays(), paths, between(-25.0, 25.0))
def test_counted_from_another_angle_it_is_the_same_law_from_its_first_move_on(loop, path, zero):
    """A plant that never moved rests at -zero there."""
    moved = counted_from(loop, zero)
    here, there = (trace(of, path, REST, of.unmoved(at)) for of, at in ((loop, 0.0), (moved, -zero)))
    np.testing.assert_allclose(there[1], here[1] - zero, atol=1e-9)
    np.testing.assert_allclose(
        np.asarray(there[2].plays) + moved.rest_pressure, np.asarray(here[2].plays) + loop.rest_pressure,
        atol=1e-9,
    )  # fmt: skip


@given(sums_of_plays(), paths, pressures, st.integers(2, 50))
def test_cutting_a_monotone_move_into_pieces_changes_nothing(loop, path, after, cuts):
    memory, before = walk(loop, path), path[-1]
    whole = loop.step(memory, before, after)
    _, _, pieces = trace(loop, [after], before, memory, cuts)
    np.testing.assert_allclose(pytrees.leaves(pieces), pytrees.leaves(whole), rtol=0, atol=ROUNDING)


@given(sums_of_plays(), paths, pressures, shares, shares)
def test_a_larger_swing_wipes_out_a_smaller_one(loop, path, end, share, inner):
    turn = path[-1] + share * (end - path[-1])
    back = turn + inner * (path[-1] - turn)
    direct = walk(loop, [*path, end])
    detour = walk(loop, [*path, turn, back, end])
    np.testing.assert_allclose(pytrees.leaves(detour), pytrees.leaves(direct), rtol=0, atol=ROUNDING)


@given(sums_of_plays(), paths)
def test_every_memory_lies_between_the_outer_branches(loop, path):
    x, h, _ = trace(loop, path, REST, loop.initial())
    assert (h >= loop.ascending(x) - ROUNDING).all()
    assert (h <= loop.descending(x) + ROUNDING).all()


@given(sums_of_plays(), paths)
def test_the_angle_never_moves_against_the_pressure(loop, path):
    x, h, _ = trace(loop, path, REST, loop.initial())
    assert (np.diff(h) * np.sign(np.diff(x)) >= -ROUNDING).all()


@given(sums_of_plays(), paths, st.lists(between(0.0, 40.0), min_size=12, max_size=12))
def test_more_pressure_at_all_times_gives_more_angle_at_all_times(loop, path, more):
    assert PrandtlIshlinskii.MONOTONE
    low, high, before = loop.initial(), loop.initial(), (REST, REST)
    for after, extra in zip(path, more, strict=False):
        low, high = loop.step(low, before[0], after), loop.step(high, before[1], after + extra)
        assert float(low.h) <= float(high.h) + ROUNDING
        before = after, after + extra


@given(sums_of_plays(), paths)
def test_a_far_sweep_ends_on_an_outer_branch(loop, path):
    far = HIGH + 2.0 * loop.reach + 200.0
    up, down = walk(loop, [*path, far]).h, walk(loop, [*path, -far]).h
    assert abs(float(up - loop.ascending(far))) < ROUNDING
    assert abs(float(down - loop.descending(-far))) < ROUNDING


@given(sums_of_plays(), paths, pressures, between(-3.0, 3.0), between(-3.0, 3.0))
def test_a_bend_shifts_each_branch_by_its_own_and_between_them_in_proportion(loop, path, after, low, high):
    memory, before = walk(loop, path), path[-1]
    plain, bent = loop.step(memory, before, after), loop.step(memory, before, after, Bend(low, high, 1.0))
    up, down = float(loop.ascending(after)), float(loop.descending(after))
    share = (float(plain.h) - up) / (down - up)
    assert float(bent.h) == pytest.approx(float(plain.h) + low + share * (high - low), abs=1e-6)
    assert bent.plays == plain.plays
    for start, shift in (("line1", low), ("line2", high)):
        there = loop.resting(
            start, float((loop.ascending if start == "line1" else loop.descending)(after)), after
        )
        on_line = loop.step(there, after, after, Bend(low, high, 1.0))
        assert float(on_line.h) == pytest.approx(float(there.h) + shift, abs=1e-6)


@given(sums_of_plays(), pressures, between(-1.0, 1.0), between(-1.0, 1.0), between(0.02, 0.98))
def test_inside_a_bent_loop_it_rests_at_the_angle_where_it_was_put(loop, pressure, low, high, share):
    bent = float(loop.ascending(pressure)) + low, float(loop.descending(pressure)) + high
    assume(bent[1] - bent[0] > 0.1)
    angle = bent[0] + share * (bent[1] - bent[0])
    memory = loop.resting("inside", angle, pressure, low, high)
    assert float(memory.h) == angle
    held = loop.step(memory, pressure, pressure, Bend(low, high, 1.0))
    assert float(held.h) == pytest.approx(angle, abs=1e-6)
    np.testing.assert_allclose(held.plays, memory.plays, rtol=0, atol=1e-9)


@given(sums_of_plays(), between(-60.0, 60.0))
def test_the_curve_and_the_branches_are_undone_by_their_inverses(loop, angle):
    assert abs(float(loop.curve(loop.uncurved(angle)) - angle)) < ROUNDING
    assert abs(float(loop.uncurved(loop.curve(angle)) - angle)) < ROUNDING
    assert abs(float(loop.ascending(loop.ascending_pressure(angle)) - angle)) < ROUNDING
    assert abs(float(loop.descending(loop.descending_pressure(angle)) - angle)) < ROUNDING


@given(sums_of_plays(), paths, st.lists(between(-40.0, 40.0), min_size=1, max_size=8))
def test_the_inverse_goes_to_the_angle_along_a_whole_way_of_reversals(loop, path, angles):
    memory, before = walk(loop, path), path[-1]
    for angle in angles:
        after = loop.pressure_for(memory, before, angle)
        memory, before = loop.step(memory, before, after), after
        assert abs(float(memory.h) - angle) < 1e-9
    assert loop.pressure_for(memory, before, memory.h) == before


@given(sums_of_plays(), paths, shares)
def test_an_angle_within_reach_takes_a_pressure_within_range(loop, path, share):
    memory, before = walk(loop, path), path[-1]
    low, high = loop.reachable(LOW, HIGH)
    after = loop.pressure_for(memory, before, loop.clamped(low + share * (high - low), LOW, HIGH))
    assert low > high or LOW - 1e-9 <= after <= HIGH + 1e-9


@given(sums_of_plays(), paths)
def test_no_slope_lies_outside_those_of_the_branches(loop, path):
    x, h, _ = trace(loop, path, REST, loop.initial())
    moves = np.abs(np.diff(x)) > 1e-3
    slopes = np.diff(h)[moves] / np.diff(x)[moves]
    for within in (None, (LOW, HIGH)):
        known = loop.branches(LOW, HIGH, within).values()
        assert (slopes >= min(known) - 1e-6).all()
        assert (slopes <= max(known) + 1e-6).all()


def test_every_slope_of_the_branches_occurs():
    path = [HIGH, LOW, *np.random.default_rng(0).uniform(LOW, HIGH, 60)]
    x, h, _ = trace(LOOP, path, REST, LOOP.initial(), 400)
    slopes = np.diff(h) / np.diff(x)
    for slope in LOOP.branches(LOW, HIGH).values():
        assert np.abs(slopes - slope).min() < 1e-9


@given(sums_of_plays(), between(-60.0, 120.0), between(60.0, 200.0))
def test_the_outer_branches_are_as_flat_and_as_steep_as_it_says(loop, low, width):
    """Over any pressures: slopes of both branches looked at closely there, and in a little more."""
    told = loop.branches(low, low + width)
    least = told.get("outer branch, flattest", told.get("outer branch"))
    most = told.get("outer branch, steepest", told.get("outer branch"))

    def seen(more):
        x = np.linspace(low - more, low + width + more, 4001)
        return np.concatenate([np.diff(of(x)) for of in (loop.ascending, loop.descending)]) / np.diff(x)[0]

    assert least <= seen(0.0).min() + 1e-9
    assert most >= seen(0.0).max() - 1e-9
    assert np.abs(seen(0.01 * width) - least).min() < 1e-9
    assert np.abs(seen(0.01 * width) - most).min() < 1e-9
    assert told["after a reversal"] == pytest.approx(least * loop.v0 / (loop.v0 + sum(loop.v)))


@given(sums_of_plays(), between(-60.0, 120.0), between(20.0, 200.0))
def test_pressures_that_are_never_left_leave_the_slopes_between_the_angles_that_they_reach(loop, low, width):
    """From the descending branch at the least pressure to the ascending one at the largest, or, of a loop so
    wide that no angle is reached from every memory, between those ends the other way round."""
    told = loop.branches(low, low + width, (low, low + width))
    least = told.get("outer branch, flattest", told.get("outer branch"))
    most = told.get("outer branch, steepest", told.get("outer branch"))
    down, up = sorted(float(angle) for angle in loop.reachable(low, low + width))

    def seen(more):
        x = np.linspace(*(loop.ascending_pressure(angle) for angle in (down - more, up + more)), 4001)
        return np.diff(loop.ascending(x)) / np.diff(x)

    assume(up - down > 0.1)
    assert least <= seen(0.0).min() + 1e-9
    assert most >= seen(0.0).max() - 1e-9
    assert np.abs(seen(0.01 * (up - down)) - least).min() < 1e-9
    assert np.abs(seen(0.01 * (up - down)) - most).min() < 1e-9


@given(sums_of_plays(), between(0.0, 6.0))
def test_the_output_curve_has_a_slope_of_its_own_beyond_each_knot(loop, beyond):
    """Written out piece by piece, on either side of its centre."""
    s, middle = loop.span, loop.curve(loop.centre)
    for sign, first, second in ((1.0, loop.c1, loop.c2), (-1.0, loop.b1, loop.b2)):
        for u, expected in (
            (min(beyond, s), min(beyond, s)),
            (s + min(beyond, s), s + first * min(beyond, s)),
            (2.0 * s + beyond, s + first * s + second * beyond),
        ):
            risen = loop.curve(loop.centre + sign * u) - middle
            assert float(risen) == pytest.approx(sign * expected, abs=1e-9)
    assert loop.curve(0.0) == 0.0


@given(starts, between(-20.0, 20.0))
def test_a_plant_at_rest_does_not_move(start, angle):
    wrist = Wrist.of(second_law_set())
    state = wrist.rest(start, angle)
    memory = wrist.hysteresis.step(state.memory, state.pressure, state.pressure)
    np.testing.assert_allclose(pytrees.leaves(memory), pytrees.leaves(state.memory), rtol=0, atol=1e-9)
    held = step(state, state.pressure / wrist.regulator.gain, wrist.sampled())
    np.testing.assert_allclose(pytrees.leaves(held), pytrees.leaves(state), rtol=0, atol=1e-9)


@given(sums_of_plays(), paths, between(-50.0, 50.0))
def test_a_corrected_memory_stays_in_the_loop_and_moves_towards_what_was_asked(loop, path, shift):
    memory, pressure = walk(loop, path), path[-1]
    after = loop.moved(memory, shift, pressure)
    assert loop.ascending(pressure) - ROUNDING <= after.h <= loop.descending(pressure) + ROUNDING
    assert -ROUNDING <= float(after.h - memory.h) * np.sign(shift) <= abs(shift) + ROUNDING
    same = loop.moved(memory, 0.0, pressure)
    np.testing.assert_allclose(pytrees.leaves(same), pytrees.leaves(memory), rtol=0, atol=ROUNDING)


@given(sums_of_plays(), between(-60.0, 60.0), pressures)
def test_a_recalled_memory_rests_at_the_measured_angle_or_on_the_nearest_branch(loop, angle, pressure):
    memory = loop.recalled(angle, pressure)
    nearest = min(max(angle, loop.ascending(pressure)), loop.descending(pressure))
    assert abs(float(memory.h) - nearest) < ROUNDING
    held = loop.step(memory, pressure, pressure)
    np.testing.assert_allclose(pytrees.leaves(held), pytrees.leaves(memory), rtol=0, atol=1e-9)


@given(sums_of_plays())
def test_parameters_go_by_names_and_by_leaves(loop):
    assert law_of(loop.values) is PrandtlIshlinskii
    assert PrandtlIshlinskii.from_values(loop.values) == loop
    assert pytrees.like(loop, pytrees.leaves(loop)) == loop
    assert pytrees.like(loop.initial(), pytrees.leaves(loop.initial())) == loop.initial()


def test_the_compiled_plant_is_the_law_in_plain_python():
    wrist = Wrist.of(second_law_set())
    volts = np.repeat(np.random.default_rng(1).uniform(0.0, 4.0, 12), 50)
    state, c, angles = wrist.rest(), wrist.sampled(), [0.0]
    for v in volts:
        state = step(state, v, c)
        angles.append(float(state.angle))
    ours = wrist.simulate(volts)
    np.testing.assert_allclose(ours.angle, angles, rtol=0, atol=1e-10)
    np.testing.assert_allclose(pytrees.leaves(ours.state), pytrees.leaves(state), rtol=0, atol=1e-10)


def test_python_control_steps_the_same_plant():
    wrist = Wrist.of(second_law_set())
    volts = np.repeat(np.random.default_rng(2).uniform(0.0, 4.0, 8), 50)
    time = np.arange(len(volts) + 1) * 1e-3
    theirs = control.input_output_response(nlsys(wrist), time, np.append(volts, 0.0), wrist_x0(wrist))
    np.testing.assert_allclose(theirs.outputs[1], wrist.simulate(volts).angle, rtol=0, atol=1e-10)


def test_slopes_of_the_output_curve_may_be_as_much_flatter_as_steeper_and_those_of_the_mirrored_joint_too():
    kinds = PrandtlIshlinskii.kinds()
    bounds = {(kinds[n].low, kinds[n].high) for n in ("b2", "b1", "c1", "c2")}
    assert len(bounds) == 1
    low, high = bounds.pop()
    assert low * high == pytest.approx(1.0)


def test_a_first_guess_has_the_slopes_and_the_width_that_were_seen():
    loop = rough(0.36, 0.08, 20.0, 90.0)
    assert loop.problem(LOW, HIGH) is None
    assert loop.steepness == pytest.approx((0.36, 0.36))
    assert (loop.flattest, loop.rest_pressure) == pytest.approx((0.08, 90.0))
    half = 0.5 * (loop.ascending_pressure(0.0) - loop.descending_pressure(0.0))
    assert half == pytest.approx(20.0 * (0.36 - 0.08) / 0.36)


def test_a_file_gives_the_set_back(tmp_path):
    path = tmp_path / "plays.toml"
    dump(second_law_set(), path)
    assert 'hysteresis = "prandtl-ishlinskii"' in path.read_text(encoding="utf-8")
    assert load(path) == second_law_set()
    assert Wrist.of(load(path)).hysteresis == LOOP


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("prandtl-ishlinskii", "preisach", "unknown hysteresis law 'preisach'; known are four-segment"),
        ("[parameters.v2]", "[parameters.w2]", "unknown parameter 'w2'"),
        ("[parameters.reach]", "[parameters.v7]", "unknown parameter 'v7'"),
        ("value = 0.12", "value = -0.12", "parameter 'v1': value -0.12 is outside its bounds"),
        ("value = 34.0", "value = 0.0", "parameter 'reach': value 0 is outside its bounds"),
    ],
)
def test_a_bad_file_is_refused_in_one_line(tmp_path, old, new, words):
    path = tmp_path / "plays.toml"
    dump(second_law_set(), path)
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load(path)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_plays_without_a_weight_are_refused(tmp_path):
    path = tmp_path / "plays.toml"
    dump(second_law_set(PrandtlIshlinskii(0.3, (0.0, 0.0), 10.0)), path)
    with pytest.raises(InputError, match="no play has a weight, so there is no loop; check v1, v2, v0"):
        load(path)
