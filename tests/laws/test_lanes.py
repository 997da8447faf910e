"""A lane is computed by itself: neither threads, nor padding, nor its neighbours change a bit of it."""

import numpy as np
import pytest

from plants import InputError, State, Wrist
from plants.kernel import pytrees as tree
from plants.kernel.templates import LANES
from plants.simulation.open_loop import open_loop

VOLTS = np.repeat(np.random.default_rng(3).uniform(0.0, 4.0, 20), 50)
WRIST = Wrist.deviation()


def batch(lanes: int, seed: int = 5) -> Wrist:
    """Wrists whose every parameter differs by up to 10 % from lane to lane."""
    draw = np.random.default_rng(seed).uniform(0.9, 1.1, (len(WRIST.values), lanes))
    return Wrist.from_values({n: v * row for (n, v), row in zip(WRIST.values.items(), draw, strict=True)})


def pick(w: Wrist, lanes: object) -> Wrist:
    return Wrist.from_values({n: v[lanes] for n, v in w.values.items()})


@pytest.mark.parametrize("lanes", [LANES * 4, LANES * 3 + 5, 17])
@pytest.mark.parametrize("jobs", [2, 3, 7])
def test_threads_change_nothing(lanes, jobs):
    one, many = (open_loop(batch(lanes), VOLTS, jobs=n) for n in (1, jobs))
    np.testing.assert_array_equal(one.angle, many.angle)
    np.testing.assert_array_equal(tree.leaves(one.state), tree.leaves(many.state))


@pytest.mark.parametrize("lanes", [1, 2, LANES - 1, LANES + 1, 3 * LANES - 1])
def test_lanes_that_fill_up_a_block_change_nothing(lanes):
    full = batch(LANES * 3)
    part = open_loop(pick(full, slice(lanes)), VOLTS)
    assert part.angle.shape == (len(VOLTS) + 1, lanes)
    np.testing.assert_array_equal(part.angle, open_loop(full, VOLTS).angle[:, :lanes])


def test_the_place_in_a_batch_changes_nothing():
    full, order = batch(41), np.random.default_rng(11).permutation(41)
    np.testing.assert_array_equal(
        open_loop(pick(full, order), VOLTS).angle, open_loop(full, VOLTS).angle[:, order]
    )


def test_a_batch_of_one_is_the_wrist_alone():
    values = WRIST.values
    alone = open_loop(WRIST, VOLTS)
    one = open_loop(Wrist.from_values({n: np.array([v]) for n, v in values.items()}), VOLTS)
    assert alone.angle.shape == (len(VOLTS) + 1,)
    np.testing.assert_array_equal(one.angle[:, 0], alone.angle)
    assert all(isinstance(x, float) for x in tree.leaves(alone.state))


def test_neighbours_that_are_not_numbers_change_nothing():
    full = batch(20)
    spoiled = Wrist.from_values({n: np.where(np.arange(20) == 7, np.nan, v) for n, v in full.values.items()})
    kept = np.arange(20) != 7
    clean, dirty = open_loop(full, VOLTS).angle, open_loop(spoiled, VOLTS).angle
    np.testing.assert_array_equal(clean[:, kept], dirty[:, kept])
    assert np.isnan(dirty[1:, 7]).all()


def test_a_state_in_lanes_makes_a_batch_of_one_wrist():
    angles = np.array([-10.0, 0.0, 10.0])
    state = WRIST.rest("line1", angles)
    lanes = open_loop(WRIST, VOLTS, tree.like(state, [np.broadcast_to(x, 3) for x in tree.leaves(state)]))
    for i, angle in enumerate(angles):
        alone = open_loop(WRIST, VOLTS, WRIST.rest("line1", float(angle)))
        np.testing.assert_array_equal(lanes.angle[:, i], alone.angle)
    assert isinstance(lanes.state, State)


def test_lanes_of_different_number_are_refused():
    values = WRIST.values
    unequal = Wrist.from_values({**values, "a1": np.full(3, 0.3), "Tw": np.full(4, 0.1)})
    with pytest.raises(ValueError, match=r"lanes differ in number: \[3, 4\]"):
        open_loop(unequal, VOLTS)


@pytest.mark.parametrize("volts", [[1.0, np.nan], [np.inf], [[1.0, 2.0]], 3.0])
def test_commands_that_are_no_finite_row_are_refused(volts):
    with pytest.raises(InputError, match="one finite number of volts per sample"):
        open_loop(WRIST, volts)
