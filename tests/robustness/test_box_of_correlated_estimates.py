"""Estimates whose errors are correlated vary together in the box of a plant."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from design.robustness.box import box_of
from design.robustness.confidence_region import AT_ENDS, ConfidenceRegion
from design.robustness.intervals import Interval, StandardErrors
from plants.effects import Creep
from plants.errors import InputError
from plants.parameters.correlation import ParameterCorrelation, matrix_of, parse_correlation
from plants.parameters.files import built_in, dump, load

ERRORS = {"a1": 0.01, "a2": 0.012, "w1": 0.3, "Tw": 0.004}
NAMES = tuple(ERRORS)


def fitted(correlation):
    """Flexion with estimates of four parameters."""
    plant = built_in("flexion")
    found = plant.fitted({n: plant.values[n] for n in ERRORS}, ERRORS, "some data")
    return replace(found, correlation=correlation)


def places(box, count=4000):
    return np.random.default_rng(0).random((len(box.intervals), count))


def test_without_correlation_it_is_what_it_was():
    apart, none = box_of(fitted({})), box_of(fitted({"w1": {"a1": 0.0}}))
    x = places(apart, 50)
    for name, values in apart.values(x).items():
        np.testing.assert_array_equal(values, none.values(x)[name])
        i = next((i for i in apart.intervals if i.name == name), None)
        if i is not None:
            np.testing.assert_allclose(values, i.low + (i.high - i.low) * x[apart.names.index(name)])


def test_they_vary_as_their_errors_do():
    """The correlation of what is drawn is the one that was given, and none is beyond two standard errors."""
    box = box_of(fitted({"w1": {"a1": 0.9}, "a2": {"a1": -0.3}}))
    x = places(box)
    drawn = np.array([box.values(x)[n] for n in NAMES])
    seen = np.corrcoef(drawn)
    assert seen[0, 2] == pytest.approx(0.9, abs=0.05)
    assert seen[0, 1] == pytest.approx(-0.3, abs=0.05)
    assert abs(seen[0, 3]) < 0.05
    nominal = box.plant.values
    for name, values in zip(NAMES, drawn, strict=True):
        assert np.abs(values - nominal[name]).max() <= 2.0 * ERRORS[name] * (1.0 + 1e-12)
    for name in NAMES:
        assert box.at(np.full(len(box.names), 0.5)).values[name] == pytest.approx(nominal[name], rel=1e-12)


def test_what_the_data_knows_of_a_sum_is_kept():
    """Two slopes of which only the sum is known well: no corner is off by the sum of both errors."""
    plant = replace(fitted({"a2": {"a1": -0.99}}))
    for box, most in ((box_of(plant), 0.4), (box_of(replace(plant, correlation={})), 4.0)):
        corners = np.round(places(box))
        values = box.values(corners)
        off = (values["a1"] - plant.values["a1"]) / ERRORS["a1"]
        off = off + (values["a2"] - plant.values["a2"]) / ERRORS["a2"]
        assert np.abs(off).max() == pytest.approx(most, rel=1e-6)


def test_many_estimates_lie_in_their_joint_confidence_region():
    """Of 26, none is further off than ten at their ends at once, and each by itself reaches both of its ends.
    The joint region at the confidence of an interval, by the chi-square distribution, lies within."""
    correlation = {f"p{k}": {"p0": 0.1} for k in range(1, 26)}
    some = [Interval(f"p{k}", -2.0, 0.0, 2.0, "1", StandardErrors(2.0, "log")) for k in range(26)]
    region = ConfidenceRegion.of(some, correlation)
    x = np.random.default_rng(0).random((26, 4000))
    x[:, :2000] = np.round(x[:, :2000])
    squared = np.sum((4.0 * region.within(x) - 2.0) ** 2, axis=0)
    assert squared.max() == pytest.approx(40.0)
    assert chi2.cdf(squared.max(), 26) >= chi2.cdf(4.0, 1)
    inside = squared < 40.0 - 1e-9
    np.testing.assert_array_equal(region.within(x)[:, inside], x[:, inside])
    assert np.abs(region.within(np.eye(26)[:, :1] * 0.5 + 0.5)[0] - 1.0).max() < 1e-12
    # Along the principal axes: the correlation of what is drawn is the one that was given.
    drawn = region.along_axes(region.within(np.random.default_rng(1).random((26, 20_000))))
    assert np.corrcoef(drawn)[0, 1:].mean() == pytest.approx(0.1, abs=0.01)


def test_what_is_no_estimate_is_drawn_to_the_ends_of_its_interval_all_the_same():
    plant = built_in("flexion").revised((Creep,), {"creep.gain": 0.1, "creep.time_constant": 3.0}, {}, "x")
    errors = {n: 0.01 * abs(v) for n, v in plant.values.items() if n != "Tw"}
    box = box_of(plant.fitted({n: plant.values[n] for n in errors}, errors, "some data"))
    assert box.region.at.size > AT_ENDS
    corner = box.coordinates(np.ones(len(box.names)))
    for i in box.intervals:
        assert (corner[i.name] < i.high) == isinstance(i.origin, StandardErrors)


def test_the_slopes_of_a_certificate_hold_all_that_the_box_holds():
    box = box_of(fitted({"w1": {"a1": 0.9}, "a2": {"a1": -0.8}}))
    low, high = box.slopes("line1")
    found = box.values(places(box))["a1"]
    assert low <= found.min() < found.max() <= high


def test_a_given_interval_is_taken_as_it_is():
    box = box_of(fitted({"w1": {"a1": 0.9}}), given={"a1": (0.3, 0.4)})
    x = places(box, 200)
    assert not isinstance(box.intervals[box.names.index("a1")].origin, StandardErrors)
    np.testing.assert_allclose(box.values(x)["a1"], 0.3 + 0.1 * x[box.names.index("a1")])


def test_a_file_keeps_it(tmp_path):
    plant = fitted({"w1": {"a1": 0.9123, "a2": -0.1}})
    dump(plant, tmp_path / "plant.toml")
    assert load(tmp_path / "plant.toml") == plant
    assert fitted({}).fitted({"a1": 0.36}, {"a1": 0.01}, "other data").correlation == {}


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"w9": {"a1": 0.5}}, "'w9'"), ({"w1": {"b": 0.5}}, "'b'"), ({"w1": 0.5}, "tables of numbers"),
        ({"w1": {"a1": 1.5}}, "a1 = 1.5 is no correlation"), ({"w1": {"a1": "x"}}, "'x' is no correlation"),
        ({"w1": {"w1": 1.0}}, "w1 = 1.0 is no correlation"),
        ({"a2": {"a1": 0.9}, "w1": {"a1": 0.9, "a2": -0.9}}, "no errors of parameters are correlated so"),
    ],
)  # fmt: skip
def test_what_is_no_correlation_is_refused_in_a_line(table, words):
    with pytest.raises(InputError) as refused:
        parse_correlation(table, NAMES, "plant.toml")
    assert words in str(refused.value)
    assert str(refused.value).count("\n") == 0


def test_each_pair_is_written_once():
    matrix = np.array([[1.0, 0.5, 0.0], [0.5, 1.0, -0.25], [0.0, -0.25, 1.0]])
    found = ParameterCorrelation(("a", "b", "c"), matrix)
    assert found.pairs == {"b": {"a": 0.5}, "c": {"a": 0.0, "b": -0.25}}
    np.testing.assert_array_equal(matrix_of(found.pairs, found.names), matrix)
    assert found.of(["a", "c"]).names == ("a", "c")
