"""Shared signals reach the law under their own names, whole or not at all; constants keep their sign."""

import numpy as np
import pytest

from plants.kernel.batches import run_lanes


def _weighed(state, inputs, c):
    tens, ones = inputs
    return (state[0] + 10.0 * tens + ones,)


def test_signals_go_by_name_not_by_order():
    last, _ = run_lanes(_weighed, (0.0,), (0.0,), 1, {"ones": [3.0], "tens": [2.0]}, ("tens", "ones"))
    assert last[0][0] == 23.0


def _added(state, inputs, c):
    return (state[0] + inputs[0],)


def test_a_signal_may_be_called_anything():
    for name in ("first", "m", "rows", "k", "state"):
        last, _ = run_lanes(_added, (1.0,), (0.0,), 2, {name: [1.0, 2.0]}, (name,))
        assert last[0][0] == 4.0


def test_a_signal_that_is_too_short_is_refused():
    with pytest.raises(ValueError, match="shorter than the 2000 steps"):
        run_lanes(_added, (0.0,), (0.0,), 2000, {"u": np.ones(5)}, ("u",))


def _constants(state, inputs, c):
    return (np.where(c[0] > 1.0, np.inf, -3.5 * state[0]), (-2.0) ** c[0])


def test_negative_and_infinite_constants():
    last, _ = run_lanes(_constants, (2.0, 0.0), (np.array([1.0, 2.0]),), 1)
    assert list(last[0]) == [-7.0, np.inf]
    assert list(last[1]) == [-2.0, 4.0]
