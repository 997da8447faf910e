"""Valleys of a map are its local minima, lowest first."""

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from design.synthesis.tuning import valleys

maps = arrays(float, array_shapes(min_dims=2, max_dims=2, min_side=2, max_side=9),
              elements=st.integers(0, 50).map(float))  # fmt: skip
fixed = settings(derandomize=True, deadline=None, database=None)


def around(values: np.ndarray, i: int, j: int) -> np.ndarray:
    return values[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2]


@given(maps)
@fixed
def test_no_neighbour_of_a_valley_is_lower(values):
    for i, j in valleys(values, values.size):
        assert values[i, j] == around(values, i, j).min()


@given(maps)
@fixed
def test_every_cell_lower_than_all_its_neighbours_is_a_valley(values):
    found = set(valleys(values, values.size))
    for i, j in np.ndindex(values.shape):
        if (around(values, i, j) > values[i, j]).sum() == around(values, i, j).size - 1:
            assert (i, j) in found


@given(maps)
@fixed
def test_the_lowest_cell_comes_first_and_the_others_rise(values):
    assume(values.min() < values.max())  # a plain has no valley
    heights = [values[cell] for cell in valleys(values, values.size)]
    assert heights == sorted(heights)
    assert heights[0] == values.min()


@given(maps, st.integers(1, 5))
@fixed
def test_no_more_are_returned_than_asked_for(values, count):
    assert valleys(values, count) == valleys(values, values.size)[:count]


def test_a_bowl_has_one_valley_and_an_egg_box_has_many():
    x = np.linspace(-3.0, 3.0, 25)
    bowl = (x[:, None] - 0.5) ** 2 + (x - 1.0) ** 2
    assert valleys(bowl, 9) == [np.unravel_index(bowl.argmin(), bowl.shape)]
    box = np.cos(2 * np.pi * np.arange(13) / 4)
    assert len(valleys(box[:, None] + box, 99)) == 9
