"""A learnt block is the splines that it says, beside a wrist that is otherwise what it was."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import BSpline

from plants import load
from plants.effects import EFFECTS, known_effects
from plants.effects.wrist.learnt_block import LearntBlock, curve, spline
from plants.equilibrium import at_pressure
from plants.kernel.graphs import graph
from plants.parameters.files import built_in, dump
from plants.parameters.quantities import Learnt
from tests.laws.effect_steps import WRIST, moved, played, ramp

PATH = ramp(100.0, 160.0, 60.0, 150.0, 100.0, rate=60.0)
BLOCK = LearntBlock(
    20.0,
    180.0,
    15.0,
    0.7,
    static2=0.8,
    static5=1.1,
    static8=-0.6,
    turning2=0.4,
    turning4=-0.3,
    slow3=1.2,
    slow4=0.5,
)  # fmt: skip
INSTANT = WRIST.with_values(Tw=1e-9)


def splines(coefficients, p, low=20.0, high=180.0):
    """The same by scipy's B-splines."""
    width = (high - low) / (len(coefficients) - 1)
    one = BSpline.basis_element(np.arange(-2.0, 3.0), extrapolate=False)
    terms = [c * np.nan_to_num(one((p - low) / width - k)) for k, c in enumerate(coefficients)]
    return np.sum(terms, axis=0)


def test_a_spline_is_scipys():
    u = np.linspace(-3.0, 3.0, 601)
    np.testing.assert_allclose(spline(u), splines((1.0, 0.0), u, 0.0, 1.0), atol=1e-14)
    coefficients = (0.3, -1.0, 2.0, 0.5)
    np.testing.assert_allclose(curve(coefficients, u), splines(coefficients, u, 0.0, 2.0), atol=1e-13)


def test_as_a_symbol_it_is_the_same_sum():
    coefficients, u = (0.3, -1.0, 2.0, 0.5), np.linspace(-0.5, 2.5, 61)
    of_symbol = graph(lambda x: curve(coefficients, x), 0.0)
    np.testing.assert_allclose(np.asarray(of_symbol(u[None])).ravel(), curve(coefficients, u), atol=1e-14)


def added_by_definition(dt=1e-3):
    """What the block adds along the path [deg], from its definition."""
    static, turning, slow = BLOCK.parts
    direction, behind, found = 0.0, PATH[0], []
    bump = splines((0.0, 0.0, 1.0, 0.0, 0.0), PATH, 20.0, 180.0)
    # The bump at the rest pressure, of two knots of the static part, which is the middle of the range here.
    for before, after in pairwise(PATH):
        direction = float(np.clip(direction + (after - before) / 15.0, -1.0, 1.0))
        behind += (1.0 - np.exp(-dt / 0.7)) * (after - behind)
        found.append(
            splines(static, after)
            + direction * splines(turning, after)
            + (after - behind) / 100.0 * splines(slow, after)
        )
    at_rest = splines(static, 100.0)
    return np.array(found) - at_rest * bump[1:] * 1.5


@pytest.mark.slow
def test_it_is_added_to_the_angle_of_the_loop():
    _, plain = moved(INSTANT, PATH)
    _, ours = moved(INSTANT + BLOCK, PATH)
    np.testing.assert_allclose(ours[1:] - plain[1:], added_by_definition(), atol=1e-7)


def test_a_wrist_at_rest_stays_there():
    wrist = WRIST + BLOCK
    _, still, _ = played(wrist, np.full(3000, 100.0 / WRIST.regulator.gain))
    assert np.abs(still).max() < 1e-9
    for pressure in (60.0, 130.0):
        began = at_pressure(wrist, "line1", pressure)
        _, held, _ = played(wrist, np.full(3000, pressure / WRIST.regulator.gain), began)
        assert np.ptp(held) < 1e-9


def test_beyond_what_it_was_learnt_on_it_fades_to_nothing():
    narrow = LearntBlock(90.0, 110.0, 5.0, 1.0, *(1.0,) * 19)
    for pressure in (60.0, 69.9, 130.1, 180.0):
        assert narrow.beside(WRIST, pressure) == 0.0
        part = narrow.sampled(WRIST, 1e-3)
        assert part.added(pressure, 1.0, 1.0) == 0.0
    assert narrow.beside(WRIST, 105.0) != 0.0


def test_slopes_lie_within_what_it_says():
    reach = (20.0, 180.0)
    (low, high), *_ = BLOCK.linear(WRIST, np.array([1.0 + 0.0j]), 1e-3, reach).added.values()
    part = BLOCK.sampled(WRIST, 1e-3)
    p, d = np.linspace(*reach, 1999), 1e-4
    added = []
    for direction in (-1.0, -0.5, 0.5, 1.0):
        for ahead in (-1.6, 0.0, 1.6):
            for turning in (0.0, d / 15.0):
                here, there = (
                    part.added(p, direction, ahead),
                    part.added(p + d, direction + turning, ahead + d / 100.0),
                )
                added.append((there - here) / d)
    assert np.min(added) >= low - 1e-6
    assert np.max(added) <= high + 1e-6
    assert np.max(added) > 0.5 * high


@pytest.mark.parametrize("only", ["static", "turning", "slow"])
def test_each_part_by_itself_reaches_the_slopes_that_it_says(only):
    coefficients = {n: v for n, v in vars(BLOCK).items() if n.startswith(only)}
    block = LearntBlock(20.0, 180.0, 15.0, 0.7, **coefficients)
    said = block.linear(WRIST, np.array([1.0 + 0.0j]), 1e-3, (20.0, 180.0)).added
    part, p, d = block.sampled(WRIST, 1e-3), np.linspace(20.0, 180.0, 4001), 1e-5
    farthest = np.ptp(WRIST.reach) / WRIST.rig.half_range
    seen = [
        (part.added(p + d, direction + turned, ahead + left) - part.added(p, direction, ahead)) / d
        for direction in (-1.0, 1.0)
        for ahead in (-farthest, farthest)
        for turned in (0.0, d / 15.0)
        for left in (0.0, d / WRIST.rig.half_range)
    ]
    for low, high in said.values():
        assert (np.min(seen), np.max(seen)) == pytest.approx((low, high), rel=2e-3, abs=1e-9)


def test_it_has_no_cause_so_that_no_search_tries_it_unasked():
    assert "learnt" not in EFFECTS
    assert known_effects()["learnt"] == (LearntBlock,)
    assert list(known_effects())[:-1] == list(EFFECTS)


@pytest.mark.parametrize("value", [0.0, 1.25])
def test_its_values_are_marked_as_learnt_in_a_file(tmp_path, value):
    plant = built_in("flexion")
    values = {f"learnt.{n}": v for n, v in vars(LearntBlock(static3=value)).items()}
    revised = plant.revised([LearntBlock], {**values, "a1": 0.35}, {"a1": 0.01}, "a rig")
    assert revised.parameters["learnt.static3"].provenance == Learnt("a rig")
    assert str(revised.parameters["learnt.static3"].provenance) == "learnt from a rig"
    dump(revised, tmp_path / "revised.toml")
    assert load(tmp_path / "revised.toml") == revised
    again = revised.fitted({"learnt.static3": 2.0}, {"learnt.static3": None}, "another rig")
    assert again.parameters["learnt.static3"].provenance == Learnt("another rig")


def test_both_ends_of_the_pressures_that_it_was_learnt_on_may_be_any_of_the_same():
    """Wherever the pressures of a rig are counted from."""
    low, high = (LearntBlock.kinds()[end] for end in ("low", "high"))
    assert (low.low, low.high) == (high.low, high.high) == (-high.high, high.high)
