"""The pieces against independent truth: formulas written out, and simulated noise of known spectrum."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.stats import chi2, norm

from plants.measured.residual.battery import make_tests
from plants.measured.residual.checks.conditional import sums_of, white_sums
from plants.measured.residual.checks.evidence import Evidence
from plants.measured.residual.checks.periodic import line_in, spectrum_of
from plants.measured.residual.checks.whiteness import autocorrelation, ljung_box
from plants.measured.residual.curves import curves_of
from plants.measured.residual.examine import examine
from plants.measured.residual.series.background import (
    background,
    first_order,
)
from plants.measured.residual.series.bins import bins_of, stretches
from plants.measured.residual.series.design import design_of
from plants.measured.residual.series.joined import SILENCE, join
from plants.measured.residual.series.remainder import Remainder
from tests.residual.made import DT, coloured, noise, short, with_structure


def test_ljung_box_is_the_formula_and_is_chi_square_on_white_noise():
    r = np.array([0.05, -0.02, 0.01])
    by_hand = 500 * 502 * (0.05**2 / 499 + 0.02**2 / 498 + 0.01**2 / 497)
    assert ljung_box(r, 500).statistic == pytest.approx(by_hand)
    assert ljung_box(r, 500).p_value == pytest.approx(chi2.sf(by_hand, 3))
    rng = np.random.default_rng(2)
    p = []
    for _ in range(200):
        values = rng.standard_normal(600)
        series = join([Remainder("r", "wrist", np.arange(600) * DT, values, 1.0, {})])
        p.append(ljung_box(autocorrelation(series, 20), 600).p_value)
    assert 0.02 < np.mean(np.array(p) < 0.05) < 0.09
    assert 0.4 < np.mean(p) < 0.6


def test_autocorrelation_is_that_of_first_order_noise():
    rng = np.random.default_rng(3)
    series = join([Remainder("r", "wrist", np.arange(60_000) * DT, coloured(60_000, 0.05, rng), 1.0, {})])
    assert autocorrelation(series, 10) == pytest.approx(np.exp(-np.arange(1, 11) / 5.0), abs=0.05)


def test_covariance_of_sums_is_the_one_written_out_with_all_lags():
    series = join(short())
    bins = bins_of(series, "x")
    design = design_of(series, [bins])
    columns = design.columns
    found = sums_of(series, series.value, design, first_order(series.frequencies, 0.1, DT))
    lags = np.arange(len(series.value)) * DT
    covariance = toeplitz(np.exp(-lags / 0.1))
    assert found.covariance == pytest.approx(columns @ covariance @ columns.T, rel=1e-3, abs=1e-2)
    assert found.sums == pytest.approx(columns @ series.value, rel=1e-4, abs=1e-3)
    assert found.overlap == pytest.approx(columns @ columns.T, rel=1e-4, abs=1e-2)
    assert design.where == {"x": list(range(len(bins.centre)))}


def test_regressing_out_is_what_least_squares_leave():
    series = join(short())
    a, b = bins_of(series, "x"), stretches(series, 2.0)
    design = design_of(series, [a, b])
    time = design.columns[design.where["time"]]
    fitted = time.T @ np.linalg.lstsq(time.T, series.value, rcond=None)[0]
    left = white_sums(series, series.value, design, 1.0).without(design.where["time"])
    x = design.where["x"]
    assert left.sums[x] == pytest.approx(design.columns[x] @ (series.value - fitted), abs=1e-2)
    # For white noise of variance 1 the covariance of what is left is its overlap.
    assert left.covariance == pytest.approx(left.overlap, abs=1e-3)


def test_conditional_test_has_the_level_it_states_where_the_spectrum_is_known():
    series = join(short(0.1, (3000, 2500)))
    design = design_of(series, [bins_of(series, "x")])
    rng = np.random.default_rng(4)
    made = sums_of(series, series.value, design, first_order(series.frequencies, 0.1, DT))
    p = []
    for _ in range(300):
        value = np.where(series.inside, coloured(len(series.value), 0.1, rng), 0.0)
        p.append(replace(made, sums=design.sums(value)).test(design.where["x"], 1e6).p_value)
    assert 0.02 < np.mean(np.array(p) < 0.05) < 0.09
    assert 0.43 < np.mean(p) < 0.57


def test_frequency_of_a_line_is_found_between_the_grid():
    hummed = with_structure(noise(1), lambda r, rng: r.value + 0.5 * np.sin(2 * np.pi * 3.3337 * r.time))
    series = join(hummed)
    line = line_in(series, spectrum_of(series, background(series)))
    assert line.frequency == pytest.approx(3.3337, abs=0.001)
    assert line.steady


def test_a_hum_that_comes_and_goes_is_not_steady():
    def half(r, rng):
        return r.value + np.where(r.time > 40.0, 0.0, np.sin(2 * np.pi * 3.0 * r.time))

    series = join(with_structure(noise(1), half))
    assert not line_in(series, spectrum_of(series, background(series))).steady


def test_bound_and_p_value_are_the_same_law():
    for law, arguments in (
        ("f", (11.0, 100.0)),
        ("norm", ()),
        ("gamma", (2.3, 0.0, 1 / 2.3)),
        ("chi2", (20.0,)),
    ):
        evidence = Evidence(3.0, law, arguments, 50.0, 0.0)
        at_bound = replace(evidence, statistic=evidence.bound(1e-4))
        assert at_bound.p_value == pytest.approx(1e-4, rel=1e-6)
    assert Evidence(3.0, "norm", (), 1.0, 0.0).p_value == pytest.approx(2.0 * norm.sf(3.0))


def test_stretches_are_consecutive_and_of_one_length_within_a_recording():
    series = join(noise(1))
    found, first = stretches(series, 4.0), 0
    for span in series.spans:
        label = found.label[span]
        assert label[0] == first
        assert set(np.diff(label).tolist()) <= {0, 1}
        counts = np.bincount(label - first)
        assert counts.min() >= counts.max() - 1
        assert counts.mean() * series.dt == pytest.approx(4.0, rel=0.5)
        first = label[-1] + 1
    assert len(found.centre) == first > len(series.spans)


def test_bins_hold_enough_rows_and_every_row_once():
    series = join(noise(1))
    for name in ("pressure_kPa", "pressure_rate_kPa_s", "direction", "work_kPa"):
        bins = bins_of(series, name)
        counts = np.bincount(bins.label[series.inside])
        assert counts.sum() == series.rows
        assert counts.min() >= 0.004 * series.rows
        assert np.all(np.diff(bins.centre) > 0.0)
    assert set(bins_of(series, "direction").centre) <= {-1.0, 0.0, 1.0}
    constant = join([replace(r, variables={"x": np.ones(len(r.value))}) for r in noise(1)])
    assert bins_of(constant, "x") is None


def test_a_constant_is_no_dependence():
    series = join(noise(1))
    design = design_of(series, [bins_of(series, "pressure_kPa")])
    assert np.abs(design.sums(series.inside.astype(float))).max() < 0.5


def test_recordings_do_not_touch():
    series = join(noise(1))
    gaps = [b.start - a.stop for a, b in zip(series.spans[:-1], series.spans[1:], strict=True)]
    assert min(gaps) * DT >= SILENCE
    assert np.all(series.value[~series.inside] == 0.0)
    assert np.isnan(series.variables["pressure_kPa"][~series.inside]).all()


def test_curves_have_bounds_that_noise_respects():
    outside = 0
    for seed in range(3):
        for curve in examine(noise(seed, 0.1)).curves.values():
            if len(curve.centre) < 100:  # not the autocorrelation's, which noise of a colour leaves
                outside += bool(np.any((curve.mean < curve.low) | (curve.mean > curve.high)))
    assert outside <= 3 + 1
    found = examine(with_structure(noise(1), lambda r, rng: r.value + 0.4 * r.variables["direction"]))
    curve = found.curves["direction"]
    assert curve.mean[-1] > curve.high[-1]
    assert curve.mean[0] < curve.low[0]
    assert curve.mean[-1] - curve.mean[0] == pytest.approx(0.8, abs=0.1)
    lags = found.curves["autocorrelation"]
    assert lags.centre == pytest.approx(DT * np.arange(1, len(lags.mean) + 1))


def test_bounds_of_curves_are_those_of_white_noise_written_out():
    """A bound that noise leaves anywhere with 1 %, shared among the points of a curve, on either side."""
    rows, rng = 20_000, np.random.default_rng(9)
    x = np.repeat(rng.uniform(-1.0, 1.0, rows // 50), 50)
    jumps = np.where(rng.random(rows) < 0.05, rng.standard_normal(rows), 0.0)
    value = 2.0 * rng.standard_normal(rows) + 0.7
    made = {"x": x, "u_V": np.cumsum(jumps)}
    battery = make_tests(join([Remainder("r", "wrist", np.arange(rows) * DT, value, 2.0, made)]), 2.0, 0)
    curves = curves_of(battery)
    label = next(b for b in battery.bins if b.variable == "x").label[:rows]
    count = np.bincount(label)

    def beyond(many, p=0.01):
        return norm.isf(0.5 * p / many)

    found = curves["x"]
    np.testing.assert_allclose(found.mean, np.bincount(label, value) / count, atol=1e-3)
    np.testing.assert_allclose(found.centre, np.bincount(label, x) / count, atol=1e-9)
    allowed = beyond(len(count)) * 2.0 / np.sqrt(count)
    np.testing.assert_allclose(found.high - value.mean(), allowed, rtol=0.15)
    np.testing.assert_allclose(value.mean() - found.low, allowed, rtol=0.15)
    lags = curves["autocorrelation"]
    np.testing.assert_allclose(lags.high, beyond(len(lags.mean)) / np.sqrt(rows))
    np.testing.assert_array_equal(lags.low, -lags.high)
    crossed = curves["correlation with u_V"]
    np.testing.assert_allclose(crossed.high, beyond(len(crossed.mean)) / np.sqrt(rows), rtol=0.15)
    np.testing.assert_array_equal(crossed.low, -crossed.high)
    power = curves["spectrum"]  # of one recording: exponential about 2 dt sigma^2
    most = -np.log(0.01 / (2.0 * len(power.mean)))
    assert np.median(power.high) / (2.0 * DT * 4.0) == pytest.approx(most, rel=0.4)


@pytest.mark.parametrize("dt", [0.002, 0.02, 0.05])
def test_other_sample_times(dt):
    rows = round(200.0 / dt)
    time = np.arange(rows) * dt
    rng = np.random.default_rng(6)
    made = {"x_V": np.repeat(rng.uniform(0.0, 4.0, 100), rows // 100)}
    value = coloured(rows, 0.1, rng, dt)
    assert not examine([Remainder("r", "wrist", time, value, 1.0, made)]).structured
    hummed = value + 0.5 * np.sin(2.0 * np.pi * 3.0 * time)
    assert examine([Remainder("r", "wrist", time, hummed, 1.0, made)]).depends_on == ("periodic at 3 Hz",)


def test_refusals():
    good = noise(1)
    with pytest.raises(ValueError, match="same stage"):
        examine([good[0], replace(good[1], stage="regulator")])
    with pytest.raises(ValueError, match="same stage"):
        examine([])
    few = {n: v[:80] for n, v in good[0].variables.items()}
    with pytest.raises(ValueError, match="90 rows"):
        examine([replace(good[0], time=good[0].time[:80], value=good[0].value[:80], variables=few)])


def test_a_remainder_of_nothing_is_not_structured():
    silent = with_structure(noise(1), lambda r, rng: np.zeros(len(r.value)))
    assert not examine(silent).structured


def test_the_same_seed_gives_the_same_answer():
    a, b = examine(noise(1), seed=3), examine(noise(1), seed=3)
    assert a.findings == b.findings


@pytest.mark.parametrize("rows", [(200,), (200, 2), (1000, 3, 17), (250, 250)])
def test_short_recordings_are_examined_and_raise_no_alarm(rows):
    for seed in range(3):
        rng = np.random.default_rng(seed)
        made = [
            Remainder(
                str(n), "wrist", np.arange(n) * DT, coloured(n, 0.1, rng), 1.0, {"x": np.arange(n) * 1.0}
            )
            for n in rows
        ]
        assert not examine(made).structured
