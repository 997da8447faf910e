"""Machine code made of a law does what the law says: in its order, with its operations, row by row."""

import re
from typing import Any, NamedTuple

import numpy as np
import pytest

from plants.kernel.batches import run_lanes
from plants.kernel.templates import LANES, emit


class Pair(NamedTuple):
    a: Any
    b: Any


class Nested(NamedTuple):
    pair: Pair
    c: Any


class Gain(NamedTuple):
    k: Any


def swap(s: Pair, _inputs: tuple[()], _c: Gain) -> Pair:
    return Pair(s.b, s.a)


def turn(s: Nested, _inputs: tuple[()], c: Gain) -> Nested:
    """Every leaf becomes another one, the last a mixture of what the others were."""
    return Nested(Pair(s.c, s.pair.a), s.pair.b + c.k * s.pair.a)


def gather(s: Pair, inputs: tuple[Any, Any], c: Gain) -> Pair:
    """a sums the first signal, weighted; b is the index of the sample that came last."""
    return Pair(s.a + c.k * inputs[0], inputs[1])


def operations(s: Pair, _inputs: tuple[()], c: Gain) -> tuple[Any, ...]:
    a, b, k = s.a, s.b, c.k
    return (
        np.minimum(a, b), np.maximum(a, b), np.where(a < b, a, k), np.where(a <= 1.0, b, -b),
        np.where(a == a, k, b), np.where(a != b, a - b, 0.0), np.where(np.logical_not(a < b), a, b),
        np.fabs(a) + np.sqrt(k), np.exp(-k), np.tanh(a), np.sin(a) * np.cos(b), np.log(k),
        a * a + a + a, 1.0 / k, k**2.5, k**a, 2.0**b, -a / k,
        np.where(a - b, a, k), (a < b) * k, np.floor(a),
    )  # fmt: skip


def test_a_swap_reads_both_values_before_it_writes_one():
    start = Pair(np.array([1.0, 3.0]), np.array([2.0, 4.0]))
    for steps in range(4):
        last, _ = run_lanes(swap, start, Gain(0.0), steps)
        expected = start if steps % 2 == 0 else Pair(start.b, start.a)
        np.testing.assert_array_equal(last, expected)


def test_leaves_that_trade_places_do_so_as_in_plain_python():
    state, c = Nested(Pair(1.0, 2.0), 3.0), Gain(0.5)
    for steps in range(7):
        last, _ = run_lanes(turn, Nested(Pair(1.0, 2.0), 3.0), c, steps)
        assert [float(x[0]) for x in (*last.pair, last.c)] == [*state.pair, state.c]
        state = turn(state, (), c)


def test_every_operation_means_what_numpy_means_by_it():
    rng = np.random.default_rng(2)
    a, b, k = rng.normal(0, 2, 64), rng.normal(0, 2, 64), rng.uniform(0.1, 5.0, 64)
    a[:4] = b[:4]
    n = len(operations(Pair(1.0, 2.0), (), Gain(3.0)))

    def law(s: Any, _inputs: Any, c: Gain) -> Any:
        return (*s[:2], *operations(Pair(*s[:2]), (), c))

    last, _ = run_lanes(law, (a, b, *[np.zeros(64)] * n), Gain(k), 1)
    for got, want in zip(last[2:], operations(Pair(a, b), (), Gain(k)), strict=True):
        np.testing.assert_allclose(got, want, rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize("every", [1, 3, 4, 10, 11])
def test_row_zero_is_the_start_and_the_others_stand_every_so_many_steps(every):
    signal = np.arange(1.0, 11.0) ** 2
    start = Pair(np.array([0.0, 5.0, -1.0]), -1.0)
    c = Gain(np.array([1.0, 2.0, 3.0]))
    last, rows = run_lanes(
        gather, start, c, 10, {"v": signal}, ("v", "sample"), every=every, record=("b", "a")
    )
    sums = np.concatenate([[0.0], np.cumsum(signal)])
    at = np.arange(0, 11, every)
    np.testing.assert_array_equal(rows[0], np.repeat(at[:, None] - 1.0, 3, axis=1))
    np.testing.assert_allclose(rows[1], start.a + sums[at][:, None] * c.k)
    np.testing.assert_allclose(last.a, start.a + sums[-1] * c.k)
    np.testing.assert_array_equal(last.b, np.full(3, 9.0))


def test_without_rows_only_the_last_state_comes_back():
    last, rows = run_lanes(gather, Pair(0.0, 0.0), Gain(1.0), 5, {"v": np.ones(5)}, ("v", "sample"))
    assert (float(last.a[0]), rows.size) == (5.0, 0)


def test_lanes_of_lengths_of_their_own_go_on_as_long_as_the_longest_beside_them():
    steps, signal = np.r_[np.full(LANES, 3), np.arange(LANES)], np.arange(1.0, LANES) ** 2
    given = gather, Pair(np.zeros(2 * LANES), -1.0), Gain(1.0), steps
    last, _ = run_lanes(*given, {"v": signal}, ("v", "sample"))
    longest = np.repeat([3, LANES - 1], LANES)
    np.testing.assert_array_equal(last.b, longest - 1.0)
    np.testing.assert_allclose(last.a, np.cumsum(signal)[longest - 1])
    with pytest.raises(ValueError, match=f"a signal is shorter than the {LANES - 1} steps"):
        run_lanes(*given, {"v": signal[:-1]}, ("v", "sample"))


def test_a_choice_is_one_selection_and_no_sum_of_two():
    def law(s: Pair, _inputs: tuple[()], c: Gain) -> Pair:
        return Pair(np.where(s.a < s.b, s.a, c.k), s.b)

    lines = program_of(emit("law", law, Pair("a", "b"), (), Gain("k")))
    into = next(line for line in lines if line[0] == "into" and line[2] == "1")  # k is row 0, a row 1
    kind, condition, *of = lines[int(into[1])]
    assert (kind, lines[int(condition)][0]) == ("select", "lt")
    assert [lines[int(i)] for i in (*lines[int(condition)][1:], *of)] == [
        ["row", "1"], ["row", "2"], ["row", "1"], ["row", "0"]
    ]  # fmt: skip


def test_what_is_computed_twice_stands_once():
    def law(s: Pair, _inputs: tuple[()], c: Gain) -> Pair:
        return Pair(np.exp(s.a * c.k), np.exp(s.a * c.k) + s.b)

    lines = program_of(emit("law", law, Pair("a", "b"), (), Gain("k")))
    assert [line[0] for line in lines].count("exp") == 1


def program_of(source: str) -> list[list[str]]:
    """The instructions in the source of a kernel."""
    (text,) = re.findall(r'"""\\\n([\s\S]*?)"""', source)
    return [line.split() for line in text.splitlines()]


def test_an_operation_without_code_is_refused_by_name():
    def law(s: Pair, _inputs: tuple[()], _c: Gain) -> Pair:
        return Pair(np.arctan2(s.a, s.b), s.b)

    with pytest.raises(ValueError, match="OP_ATAN2"):
        emit("law", law, Pair("a", "b"), (), Gain("k"))


def count(s: Pair, _inputs: tuple[()], c: Gain) -> Pair:
    return Pair(s.a + c.k, s.b + 1.0)


@pytest.mark.parametrize("jobs", [1, 3])
def test_lanes_go_on_for_as_long_as_the_longest_beside_them(jobs):
    steps = np.repeat([5, 40, 0, 17], LANES)[: 4 * LANES - 3]
    steps[3] = 2
    last, rows = run_lanes(count, Pair(np.zeros(steps.size), 0.0), Gain(2.0), steps, jobs=jobs)
    blocks = np.repeat([5.0, 40.0, 0.0, 17.0], LANES)[: steps.size]
    np.testing.assert_array_equal(last.b, blocks)
    np.testing.assert_array_equal(last.a, 2.0 * blocks)
    assert rows.size == 0


def test_lanes_of_lengths_of_their_own_are_not_recorded():
    with pytest.raises(ValueError, match="lengths of their own"):
        run_lanes(count, Pair(np.zeros(3), 0.0), Gain(2.0), np.array([1, 2, 3]), every=1, record=("a",))
