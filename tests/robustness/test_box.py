"""A box is as wide as what is known: standard errors, else assumed shares, else what is given."""

from itertools import product

import numpy as np
import pytest

from design.evaluation.scenarios import Spread
from design.robustness.box import SIGMAS, box_of
from design.robustness.intervals import StandardErrors
from design.status import Status
from plants import InputError
from plants.hysteresis import with_values
from plants.parameters.files import built_in


def fitted(**errors):
    plant = built_in("flexion")
    return plant.fitted({n: plant.values[n] for n in errors}, errors, "a rig")


def test_a_fitted_parameter_gets_two_standard_errors():
    box = box_of(fitted(a1=0.004, Tw=0.01))
    assert box.bounds("a1") == pytest.approx((0.36 - SIGMAS * 0.004, 0.36 + SIGMAS * 0.004))
    assert box.bounds("Tw") == pytest.approx((0.14, 0.18))


def test_what_is_stated_is_certain_and_what_is_assumed_is_not():
    box = box_of(built_in("deviation"))
    assert box.bounds("gain") == (49.4, 49.4)
    assert box.bounds("w1") == pytest.approx((0.8 * 3.4, 1.2 * 3.4))
    assert all(i.status is Status.ASSUMED for i in box.intervals)


@pytest.mark.parametrize("axis", ["flexion", "deviation"])
def test_no_loop_of_a_box_runs_backwards(axis):
    box = box_of(built_in(axis))
    rng = np.random.default_rng(0)
    for shares in rng.random((500, len(box.names))):
        values = {n: float(v) for n, v in box.values(shares).items()}
        assert with_values({**box.plant.values, **values}).problem(0.0, 200.0) is None


def test_the_ends_of_the_shares_are_the_ends_of_the_intervals():
    box = box_of(built_in("flexion"), given={"a1": (0.34, 0.38)})
    n = len(box.names)
    lanes = box.at(np.array([[0.0, 1.0]] * n))
    for name in ("a1", "a2", "w1", "Tw", "k_slow"):
        assert np.asarray(lanes.values[name]) == pytest.approx(box.bounds(name))


def test_an_interval_that_is_given_takes_a_parameter_out_of_its_group():
    box = box_of(built_in("flexion"), given={"a1": (0.34, 0.38)})
    (slopes,) = [i for i in box.intervals if i.name == "slopes"]
    assert slopes.scaled == ("a2", "s")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"a1": (0.38, 0.34)}, "a1 = 0.38:0.34 deg/kPa is inverted"),
        ({"a1": (0.36, 0.36)}, "is empty"),
        ({"a9": (0.1, 0.2)}, "no parameter 'a9'; one of gain, k_fast"),
        ({"a1": (0.4, 0.5)}, "does not hold the plant's own value 0.36"),
        ({"a1": (-1.0, 0.5)}, "is outside 0.01 to 5"),
        ({"s": (0.05, 0.5)}, "the loop runs backwards at a corner of the box"),
        ({"a1": (float("nan"), 0.5)}, "is empty"),
    ],
)
def test_a_box_that_makes_no_sense_is_refused_in_one_line(given, words):
    with pytest.raises(InputError) as refused:
        box_of(built_in("flexion"), given=given)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_spread_that_makes_lines_cross_is_refused():
    with pytest.raises(InputError, match="runs backwards"):
        box_of(built_in("deviation"), Spread(width=0.9, slope=0.1, lag=0.1))


def test_standard_errors_of_a_loop_reach_only_as_far_as_no_loop_runs_backwards():
    """Errors in which the lines would cross are narrowed, all of the loop together, and no further."""
    wide = fitted(w1=1.2, w2=1.2, a1=0.02, Tw=0.01)
    box = box_of(wide)
    counts = {i.name: i.origin.count for i in box.intervals if isinstance(i.origin, StandardErrors)}
    assert counts["Tw"] == SIGMAS
    assert 0.0 < counts["w1"] < SIGMAS
    assert counts["w1"] == counts["w2"] == counts["a1"]
    more = {n: (1.0 + 0.1 * SIGMAS / counts[n]) for n in ("w1", "w2", "a1")}

    def problems(stretched):
        corners = product(*([box.bounds(n) for n in ("w1", "w2", "a1", "a2", "s")]))
        found = []
        for corner in corners:
            values = dict(zip(("w1", "w2", "a1", "a2", "s"), corner, strict=True))
            for n in stretched:
                middle = box.plant.values[n]
                values[n] = middle + more[n] * (values[n] - middle)
            found.append(with_values({**box.plant.values, **values}).problem(0.0, 200.0))
        return [f for f in found if f]

    assert problems(()) == []
    assert problems(tuple(more)) != []
