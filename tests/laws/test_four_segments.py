"""Four segments: what they are guessed from, what makes no loop, and which of them are what."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plants import FourSegment
from plants.hysteresis import RoughLoop
from tests.laws.law_strategies import between


@given(between(0.1, 1.0), between(0.0, 0.9), between(1.0, 40.0), between(50.0, 150.0))
def test_a_first_guess_has_the_slopes_and_the_width_that_were_seen(outer, share, gap, rest):
    """The dead zone after a reversal is as wide on the pressure axis as twice the gap."""
    inner = share * outer
    loop = FourSegment.from_values(
        FourSegment.guess(RoughLoop.of_equal_plays(outer, inner, gap, rest, 0.0, 200.0))
    )
    assert loop.problem(0.0, 200.0) is None
    assert loop.steepness == pytest.approx((outer, outer))
    assert (loop.flattest, loop.rest_pressure) == (inner, rest)
    high = loop.ascending(rest + 50.0)
    met = rest + 50.0 - 2.0 * gap  # where the transit back from line 1 meets line 2
    assert high - inner * 2.0 * gap == pytest.approx(loop.descending(met), abs=1e-9)


def loop(**changed):
    return FourSegment(
        **{"a1": 0.3, "w1": 5.0, "a2": 0.35, "w2": 6.0, "s": 0.08, "rest_pressure": 100.0, **changed}
    )


def test_a_transit_as_steep_as_a_line_and_lines_that_meet_make_no_loop():
    assert loop().problem(0.0, 200.0) is None
    assert "a1 = 0.3" in loop(s=0.3).problem(0.0, 200.0)
    assert "a2 = 0.2" in loop(s=0.25, a2=0.2).problem(0.0, 200.0)
    assert loop(s=0.299).problem(0.0, 200.0) is None
    # The lines meet where (a2 - a1)(P - rest) + w1 + w2 = 0: 0.2 (P - 100) = -11 at 45 kPa.
    crossing = loop(a1=0.1, a2=0.3)
    assert crossing.problem(45.5, 200.0) is None
    assert crossing.problem(44.5, 200.0)
    steeper = loop(a1=0.3, a2=0.1)
    assert steeper.problem(0.0, 154.5) is None
    assert steeper.problem(0.0, 155.5)
    assert loop(a1=0.5, a2=0.25, w1=3.0, w2=2.0).problem(0.0, 120.0)  # by 0.25 at 20 kPa: just together
    assert loop(w1=0.0, w2=0.0, a2=0.3).problem(0.0, 200.0)  # no gap is no loop


@given(st.sampled_from(["ascending", "descending"]), between(-30.0, 30.0))
def test_lines_are_straight_and_undone_by_their_inverses(side, angle):
    made = loop()
    slope, offset = (made.a1, -made.w1) if side == "ascending" else (made.a2, made.w2)
    line, inverse = getattr(made, side), getattr(made, f"{side}_pressure")
    pressure = float(inverse(angle))
    assert float(line(pressure)) == pytest.approx(angle, abs=1e-9)
    assert angle == pytest.approx(slope * (pressure - 100.0) + offset, abs=1e-9)


def test_roles_name_every_parameter_that_a_spread_moves():
    roles = FourSegment.roles(FourSegment.kinds())
    assert roles == {"outer": ("a1", "a2"), "inner": ("s",), "width": ("w1", "w2")}
    wide = loop(**{n: 2.0 * loop().values[n] for n in roles["width"]})
    at = np.linspace(0.0, 200.0, 5)
    gap, doubled = (x.descending(at) - x.ascending(at) - 0.05 * (at - 100.0) for x in (loop(), wide))
    np.testing.assert_allclose(doubled, 2.0 * gap)
