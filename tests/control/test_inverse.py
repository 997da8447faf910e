"""The inverses are right inverses: of the loop over random reversal histories, of the regulator by brentq."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import brentq

from plants import one_page
from plants.actuator import inverse, regulator
from plants.actuator.regulator import Regulator
from plants.hysteresis import FourSegment, Memory
from plants.kernel.graphs import jacobians
from plants.wrist import Wrist

LOW, HIGH = 0.0, 197.6


@st.composite
def loops(draw):
    """Loops that run forwards between the two pressures, with lines of different slope and offset."""
    slope, share = st.floats(0.1, 0.8), st.floats(0.0, 0.95)
    a1, a2 = draw(slope), draw(slope)
    width = st.floats(0.2, 15.0)
    s = draw(share) * min(a1, a2)
    p = FourSegment(a1, draw(width), a2, draw(width), s, draw(st.floats(80.0, 120.0)))
    assume(p.problem(LOW, HIGH) is None)
    low, high = p.reachable(LOW, HIGH)
    assume(low < high)  # a loop that is wider than the range reaches no angle whatever its memory
    return p


histories = st.lists(st.floats(LOW, HIGH), max_size=12)


def at_the_end(p, history):
    """Memory, and pressure, of a loop that was virgin at rest and taken to one pressure after the other."""
    memory, pressure = Memory(0.0, 1.0), p.rest_pressure
    for after in history:
        memory, pressure = p.step(memory, pressure, after), after
    return memory, pressure


@given(loops(), histories, st.floats(0.0, 1.0))
def test_the_loop_goes_to_the_angle_that_was_asked_for(p, history, share):
    memory, pressure = at_the_end(p, history)
    low, high = p.reachable(LOW, HIGH)
    angle = low + share * (high - low)
    after = p.pressure_for(memory, pressure, angle)
    assert LOW - 1e-9 <= after <= HIGH + 1e-9
    assert abs(p.step(memory, pressure, after).h - angle) <= 1e-9


@given(loops(), histories, st.lists(st.floats(0.0, 1.0), min_size=2, max_size=8))
def test_it_does_so_along_a_whole_way_of_reversals(p, history, shares):
    memory, pressure = at_the_end(p, history)
    low, high = p.reachable(LOW, HIGH)
    for share in shares:
        angle = low + share * (high - low)
        after = p.pressure_for(memory, pressure, angle)
        memory, pressure = p.step(memory, pressure, after), after
        assert abs(memory.h - angle) <= 1e-9


@given(loops(), histories)
def test_asked_for_its_own_angle_it_stays(p, history):
    memory, pressure = at_the_end(p, history)
    assert p.pressure_for(memory, pressure, memory.h) == pressure


@given(loops(), histories, st.floats(0.0, 1.0))
def test_no_shorter_move_gives_the_angle(p, history, share):
    memory, pressure = at_the_end(p, history)
    low, high = p.reachable(LOW, HIGH)
    angle = low + share * (high - low)
    after = p.pressure_for(memory, pressure, angle)
    shorter = pressure + np.linspace(0.0, 0.999, 50) * (after - pressure)
    assume(abs(after - pressure) > 1e-6 and abs(angle - memory.h) > 1e-6)
    assert (np.abs(p.step(memory, pressure, shorter).h - angle) > 1e-12).all()


@given(st.floats(-29.9, 29.1), st.lists(st.floats(0.5, 3.9), max_size=4))
def test_the_page_that_imports_nothing_agrees(angle, commands):
    p = Wrist.flexion().values
    held = [v for v in commands for _ in range(300)]
    before, h, _ = one_page.wrist(p, held)[-1]
    virgin = float(h == 0.0 and not any(x[1] for x in one_page.wrist(p, held)))
    after = float(Wrist.flexion().hysteresis.pressure_for(Memory(h, virgin), before, angle))
    # A regulator that is at its command within one sample, and a lag that is not there: P and h alone.
    quick = {**p, "k_fast": 4e4, "k_slow": 4e4, "e0": 1e-3, "Tw": 1e-6}
    path = [x[0] for x in one_page.wrist(p, held)[1:]] + [after]
    assert abs(one_page.wrist(quick, [x / p["gain"] for x in path])[-1][1] - angle) <= 1e-9


def test_angles_beyond_the_range_are_clamped_to_its_ends():
    p = Wrist.flexion().hysteresis
    low, high = p.reachable(LOW, HIGH)
    assert (low, high) == (pytest.approx(-30.0), pytest.approx(29.136))
    for angle, end, pressure in ((40.0, high, HIGH), (-40.0, low, LOW)):
        assert p.clamped(angle, LOW, HIGH) == end
        found = p.pressure_for(Memory(0.0, 1.0), 100.0, p.clamped(angle, LOW, HIGH))
        assert found == pytest.approx(pressure, abs=1e-9)


@given(loops(), histories)
def test_the_corner_is_where_transit_and_line_meet(p, history):
    memory, pressure = at_the_end(p, history)
    slope = p.s * (1.0 - memory.virgin)
    for up, line in ((True, p.ascending), (False, p.descending)):
        corner = p.corner_pressure(memory, pressure, up)
        assert memory.h + slope * (corner - pressure) == pytest.approx(line(corner), abs=1e-9)
        assert corner >= pressure - 1e-7 if up else corner <= pressure + 1e-7


@given(
    st.floats(0.1, 100.0), st.floats(0.0, 1.0), st.floats(0.1, 200.0), st.floats(-190.0, 190.0)
)  # fmt: skip
def test_the_command_gives_the_pressure_and_brentq_finds_the_same_error(k_fast, share, e0, error):
    k_slow = 0.01 + share * max(k_fast - 0.01, 0.0)
    c = regulator.sampled(Regulator(49.4, max(k_fast, k_slow), k_slow, e0), 0.001)
    change = regulator.share(error, c) * error
    found = float(inverse.error_for(change, c))
    known = brentq(lambda e: regulator.share(e, c) * e - change, -200.0, 200.0, xtol=1e-13, rtol=1e-14)
    assert found == pytest.approx(known, abs=1e-8)
    after = 100.0 + change
    command = inverse.command_for(100.0, after, c)
    assert regulator.step(100.0, command, c) == pytest.approx(after, abs=1e-11)


@pytest.mark.parametrize(("apart", "close"), [(1e3, 1e-12), (1e4, 2e-5)])
def test_the_error_is_found_however_far_the_rates_are_apart(apart, close):
    """Between the rates the change grows steeply with the error, so that a start on one side is far off."""
    error = 100.0 * np.geomspace(3e-3, 3.0, 400)
    c = regulator.sampled(Regulator(49.4, 100.0, 100.0 / apart, 100.0), 0.001)
    found = inverse.error_for(regulator.share(error, c) * error, c)
    np.testing.assert_allclose(found, error, rtol=close)


def test_a_regulator_without_variation_is_inverted_in_closed_form():
    c = regulator.sampled(Regulator.lag(49.4, 0.111), 0.001)
    expected = (100.0 + 0.7 / -np.expm1(-0.001 / 0.111)) / 49.4
    assert inverse.command_for(100.0, 100.7, c) == pytest.approx(expected, rel=1e-14)


def test_the_graph_of_the_compiler_has_the_slopes_of_the_branches():
    p = Wrist.flexion().hysteresis

    def law(memory, pressure_and_angle):
        pressure, angle = pressure_and_angle
        return (p.pressure_for(memory, pressure, angle),)

    on_line = jacobians(law, Memory(0.0, 1.0), (100.0, 12.0))[1]
    transit = jacobians(law, Memory(12.0, 0.0), (150.0, 11.0))[1]
    assert on_line[0] == pytest.approx([0.0, 1.0 / p.a1])
    assert transit[0] == pytest.approx([1.0, 1.0 / p.s])
