"""The hybrid MPC's model of the regulator is odd and continuous, and a period of it is one of the wrist."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from design.mpc.formulations.hybrid_model import Piecewise, _greedy, gained, move, piecewise, sampled_lag
from design.mpc.problem import MPCProblem
from plants import Wrist
from plants.dynamics import step
from plants.errors import InputError

PROBLEM = MPCProblem(Wrist.flexion())
rises = st.lists(st.floats(0.1, 50.0), min_size=1, max_size=6)


@given(st.data(), rises)
def test_the_segments_are_the_law_on_either_side_of_zero(data, widths):
    heights = data.draw(st.lists(st.floats(0.01, 40.0), min_size=len(widths), max_size=len(widths)))
    knots, values = (np.concatenate([[0.0], np.cumsum(x)]) for x in (widths, heights))
    law = Piecewise(knots, values, 0.3, 0.02)
    segments = law.segments
    assert len(segments) == 2 * len(widths) - 1
    ends = [s[0] for s in segments] + [segments[-1][1]]
    np.testing.assert_allclose(ends, [*(-knots[:0:-1]), *knots[1:]], atol=1e-12)
    for (a, b, slope, intercept), (start, *_) in zip(segments, [*segments[1:], (ends[-1],)], strict=True):
        assert b == start
        e = np.linspace(a, b, 5)
        np.testing.assert_allclose(slope * e + intercept, law(e), rtol=1e-9, atol=1e-9 * values[-1])
    assert law(-knots) == pytest.approx(-values)
    assert law.rate_error == pytest.approx(15.0)


@pytest.mark.parametrize("wrist", [Wrist.flexion(), Wrist.deviation()])
def test_what_a_period_gains_is_what_the_wrist_does(wrist):
    """Against the law of the plant, sample by sample."""
    problem, c = MPCProblem(wrist), wrist.sampled()
    for error in (-90.0, -3.0, 0.5, 12.0, 80.0):
        state = wrist.rest()
        start = float(state.pressure)
        for _ in range(problem.substeps):
            state = step(state, (start + error) / wrist.regulator.gain, c)
        assert float(gained(problem, error)) == pytest.approx(float(state.pressure) - start, abs=1e-9)


@pytest.mark.parametrize("pieces", [1, 2, 3, 5])
def test_the_knots_miss_little_more_than_the_best_of_as_many_pieces(pieces):
    """Of all laws of as many chords between points of a coarse grid, by dynamic programming."""
    most, n = 197.6, 161
    law, grid = piecewise(PROBLEM, most, pieces), np.linspace(0.0, most, n)
    exact = gained(PROBLEM, grid)
    missed = np.full((n, n), np.inf)
    for i in range(n):
        for j in range(i + 1, n):
            chord = np.interp(grid[i : j + 1], grid[[i, j]], exact[[i, j]])
            missed[i, j] = np.abs(chord - exact[i : j + 1]).max()
    best = missed[0]
    for _ in range(pieces - 1):
        best = np.array([np.max([best, missed[:, j]], axis=0).min() for j in range(n)])
    assert 0.8 * best[-1] <= law.error <= 1.7 * best[-1]
    assert len(law.knots) == pieces + 1
    assert (law.knots[0], law.knots[-1]) == (0.0, most)
    np.testing.assert_allclose(law.values, gained(PROBLEM, law.knots), atol=1e-12)


@pytest.mark.parametrize("steps", [1, 2, 7, 30])
def test_on_a_parabola_pieces_are_as_long_as_the_tolerance_lets_them_be(steps):
    """The chord of x^2 over a length l misses it by l^2/4 at most: pieces of one length, of so many steps."""
    grid = np.linspace(0.0, 10.0, 1001)
    begun = 0.25 * (steps * 0.01) ** 2  # what the longest misses, seen where the middle is on the grid
    tolerance = begun * 1.01 if steps > 1 else 1e-9
    found = _greedy(grid, grid**2, tolerance, 1000)
    lengths = np.diff(found)
    assert (found[0], found[-1]) == (0, 1000)
    # An odd number of steps has no middle on the grid, so that one step more may do there.
    assert set(lengths[:-1].tolist()) <= ({steps} if steps % 2 == 0 or steps == 1 else {steps, steps + 1})
    assert _greedy(grid, grid**2, tolerance, len(lengths)) == found
    assert _greedy(grid, grid**2, tolerance, len(lengths) - 1) is None


def test_no_piece_is_no_law():
    assert len(piecewise(PROBLEM, 100.0, 1).knots) == 2
    with pytest.raises(InputError, match="1 or more"):
        piecewise(PROBLEM, 100.0, 0)


def test_the_lag_over_a_period_is_that_of_the_plant_far_from_the_command():
    """An error as large as the one it is sampled at, on a line: the same angle as sample by sample."""
    wrist, most = PROBLEM.wrist, 60.0
    lag, c = sampled_lag(PROBLEM, most), wrist.sampled()
    assert lag.keep + lag.before + lag.after == pytest.approx(1.0)
    assert lag.keep == pytest.approx(np.exp(-PROBLEM.period / wrist.Tw))
    state = wrist.rest("line1")
    before, command = state, (float(state.pressure) + most) / wrist.regulator.gain
    for _ in range(PROBLEM.substeps):
        state = step(state, command, c)
    angle = lag.keep * before.angle + lag.before * before.memory.h + lag.after * state.memory.h
    assert float(angle) == pytest.approx(float(state.angle), abs=1e-9)


@pytest.mark.parametrize(
    ("start", "command", "lack"), [("line1", 2.6, 0.0), ("line2", 1.4, 3.0), ("inside", 2.2, -4.0)]
)
def test_a_period_of_the_model_is_one_of_the_wrist(start, command, lack):
    """Pressure to the error of the law; angle to tenths of a degree, exact where the loop is left alone."""
    wrist, c = PROBLEM.wrist, PROBLEM.wrist.sampled()
    law = piecewise(PROBLEM, 197.6, 8)
    state = wrist.rest(start)
    moved, exact = move(PROBLEM, law, state, command, lack), state
    for _ in range(PROBLEM.substeps):
        exact = step(exact, command + lack / wrist.regulator.gain, c)
    assert abs(moved.pressure - float(exact.pressure)) <= law.error + 1e-9
    assert abs(moved.memory.h - float(exact.memory.h)) <= law.error * 0.4
    assert abs(moved.angle - float(exact.angle)) < 0.05
