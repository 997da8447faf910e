"""The page-long wrist, the wrist composed of its parts, and the compiled one are the same wrist."""

import numpy as np
import pytest
from hypothesis import given, settings

from plants import State, Wrist, dynamics, one_page
from plants.kernel import pytrees as tree
from tests.laws.law_strategies import commands, wrists


def plain(w: Wrist, volts: list[float]) -> np.ndarray:
    """(P, h, y) by the composed law in plain Python numbers, one sample after the other."""
    state, c = w.rest(), w.sampled()
    rows = [(state.pressure, state.memory.h, state.angle)]
    for v in volts:
        state = dynamics.step(state, v, c)
        state = tree.like(state, [float(x) for x in tree.leaves(state)])
        rows.append((state.pressure, state.memory.h, state.angle))
    return np.array(rows)


def compiled(w: Wrist, volts: list[float]) -> np.ndarray:
    r = w.simulate(volts)
    return np.array([r.pressure, r.static_angle, r.angle]).T


@given(wrists(), commands())
@settings(max_examples=200)
def test_the_compiled_wrist_is_the_one_on_the_page(w, volts):
    page = np.array(one_page.wrist(w.values, volts))
    np.testing.assert_allclose(compiled(w, volts), page, rtol=0, atol=1e-9)


@given(wrists(), commands())
def test_the_composed_law_in_plain_python_is_the_one_on_the_page(w, volts):
    page = np.array(one_page.wrist(w.values, volts))
    np.testing.assert_allclose(plain(w, volts), page, rtol=0, atol=1e-9)


@pytest.mark.parametrize("axis", ["flexion", "deviation"])
def test_ten_seconds_over_the_whole_range_drift_by_no_more_than_rounding(axis):
    w = getattr(Wrist, axis)()
    levels = np.random.default_rng(7).uniform(0.0, 4.0, 25)
    volts = list(np.repeat(levels, 400))
    np.testing.assert_allclose(
        compiled(w, volts), np.array(one_page.wrist(w.values, volts)), rtol=0, atol=1e-10
    )


@given(wrists(), commands())
@settings(max_examples=20)
def test_two_halves_make_a_whole(w, volts):
    half = len(volts) // 2
    whole, first = w.simulate(volts), w.simulate(volts[:half])
    second = w.simulate(volts[half:], first.state)
    assert isinstance(second.state, State)
    assert tree.leaves(second.state) == tree.leaves(whole.state)
    np.testing.assert_array_equal(np.concatenate([first.angle, second.angle[1:]]), whole.angle)
