"""The pieces against independent truth: formulas written out, and simulated noise of known spectrum."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter
from scipy.stats import chi2, gamma, norm

from plants.measured.residual.battery import make_tests
from plants.measured.residual.checks.conditional import sums_of, white_sums
from plants.measured.residual.checks.correlation import correlation
from plants.measured.residual.checks.evidence import Evidence
from plants.measured.residual.checks.periodic import line_in, spectrum_of
from plants.measured.residual.checks.whiteness import autocorrelation, ljung_box
from plants.measured.residual.curves import curves_of
from plants.measured.residual.examine import examine
from plants.measured.residual.series import background as series_background
from plants.measured.residual.series.background import (
    LONGEST_MEMORY,
    LOWEST,
    _bands,
    background,
    first_order,
    positive_parts,
)
from plants.measured.residual.series.bins import bins_of, stretches
from plants.measured.residual.series.design import design_of
from plants.measured.residual.series.joined import SILENCE, join
from plants.measured.residual.series.remainder import Remainder
from plants.measured.residual.stillness import SLOWEST, _edges, _whitened_periodogram
from tests.residual.made import DT, coloured, noise, with_structure


def short(memory=0.1, rows=(900, 700)):
    """Two short recordings with one variable."""
    rng = np.random.default_rng(1)
    return [
        Remainder(
            str(n), "wrist", np.arange(n) * DT, coloured(n, memory, rng), 1.0,
            {"x": np.sin(np.arange(n) / 150.0)},
        )
        for n in rows
    ]  # fmt: skip


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


def test_background_is_the_spectrum_of_the_noise_and_passes_over_structure():
    at = [0.02, 0.3, 1.0, 5.0, 20.0]
    for memory in (0.0, 0.1, 0.5):
        ratios = []
        for seed in range(4):
            hummed = with_structure(
                noise(seed, memory), lambda r, rng: r.value + 3.0 * np.sin(2 * np.pi * 3.0 * r.time)
            )
            series = join(hummed)
            ratio = background(series) / first_order(series.frequencies, memory, DT)
            ratios.append(np.interp(at, series.frequencies, ratio))
        assert np.mean(ratios, axis=0) == pytest.approx(np.ones(5), abs=0.3), memory


@pytest.mark.parametrize(("shortest", "longest", "off"), [(0.01, 0.04, 0.04), (0.04, LONGEST_MEMORY, 0.1)])
def test_background_has_noise_of_any_correlation_time_up_to_the_longest(monkeypatch, shortest, longest, off):
    """Where bands tell its level without a doubt, only what the background is made up of is left."""
    series = join(short(rows=(9000,)))
    at = np.geomspace(LOWEST, 0.5 / DT, 60)
    for memory in np.geomspace(shortest, longest, 12):
        bands = at, first_order(at, memory, DT), np.full(60, 100.0)
        monkeypatch.setattr(series_background, "_bands", lambda *_, bands=bands: bands)
        ratio = background(series) / first_order(series.frequencies, memory, DT)
        assert ratio == pytest.approx(np.ones(len(ratio)), abs=off), memory


def test_background_does_without_an_active_set_that_goes_round_in_circles(monkeypatch):
    import scipy.optimize

    def circles(*_):
        raise RuntimeError("Maximum number of iterations reached.")

    series = join(noise(1, 0.1))
    usual = background(series)
    monkeypatch.setattr(scipy.optimize, "nnls", circles)
    assert background(series) == pytest.approx(usual, rel=0.02)


def test_background_does_not_rise_with_a_drift():
    plain = background(join(noise(1)))[0]
    drifting = with_structure(noise(1), lambda r, rng: r.value + 10.0 * r.time / 136.0)
    assert background(join(drifting))[0] < 3.0 * plain


def test_deviation_of_a_cross_correlation_is_what_noise_scatters():
    rng = np.random.default_rng(5)
    rows = 4000
    steps = np.cumsum(rng.standard_normal(rows) * (rng.random(rows) < 0.05))
    series = join([Remainder("r", "wrist", np.arange(rows) * DT, np.zeros(rows), 1.0, {"u": steps})])
    spectrum = first_order(series.frequencies, 0.1, DT)
    z, agreed = [], []
    for _ in range(50):
        value = np.where(series.inside, coloured(len(series.value), 0.1, rng), 0.0)
        found = correlation(series, value, "u", spectrum)
        z.append((found.value / found.deviation)[::30])
        agreed.append(found.agreement[::30])
    assert np.std(z) == pytest.approx(1.0, abs=0.1)
    assert np.std(agreed) == pytest.approx(1.0, abs=0.1)  # changes that are alike scatter as the noise does


@pytest.mark.parametrize("size", [0.5, 3.0])
def test_a_correlation_needs_more_than_a_dozen_changes_as_large_as_each_other(size):
    def of(changes):
        at = (np.arange(4000) % 200 == 100) & (np.arange(4000) < 200 * changes)
        up_and_down = np.where(np.cumsum(at) % 2 == 1, size, 0.0)
        series = join([Remainder("r", "wrist", np.arange(4000) * DT, np.ones(4000), 1.0, {"u": up_and_down})])
        return correlation(series, series.value, "u", np.ones(len(series.frequencies)))

    assert of(1) is of(11) is None
    assert of(13) is not None


@pytest.mark.parametrize("late", [0, 40])
@pytest.mark.parametrize("kept", [0.0, 0.8])
def test_a_correlation_explains_what_follows_the_changes_and_at_which_lag(late, kept):
    """Half of the power, some rows after changes of which each keeps so much of the one before it."""
    rng, rows = np.random.default_rng(6), 20_000
    changes = lfilter([1.0], [1.0, -kept], rng.standard_normal(rows))
    follows = np.roll(changes, late)
    noise = np.std(follows) * rng.standard_normal(rows)
    known = {"u": np.cumsum(changes)}
    series = join([Remainder("r", "wrist", np.arange(rows) * DT, follows + noise, 1.0, known)])
    whole = np.where(series.inside, series.value, 0.0)
    found = correlation(series, whole, "u", np.full(len(series.frequencies), np.var(noise)))
    np.testing.assert_allclose(found.lag, np.arange(-0.5, 3.0 + DT / 2.0, DT), atol=1e-9)
    assert found.lag[np.argmax(np.abs(found.value))] == pytest.approx(late * DT)
    # Products of such changes decay as kept^|lag|.
    assert found.sharpness == pytest.approx((1.0 - kept**2) / (1.0 + kept**2), rel=0.05)
    evidence = found.evidence(2.0)
    assert evidence.statistic == pytest.approx(np.abs(found.value).max() / found.deviation)
    assert evidence.power == pytest.approx(0.5 * 2.0, rel=0.1)


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


@pytest.mark.parametrize("rounds", [False, True])
def test_positive_parts_are_those_that_were_mixed_whatever_solver_finds_them(monkeypatch, rounds):
    """The second solver takes over where the first goes round in circles."""

    def in_circles(*_):
        raise RuntimeError

    if rounds:
        monkeypatch.setattr("scipy.optimize.nnls", in_circles)
    model = np.random.default_rng(12).uniform(0.1, 1.0, (30, 3)) * (1.0, 100.0, 0.01)
    mixed = np.array([2.0, 0.0, 500.0])
    assert positive_parts(model, model @ mixed) == pytest.approx(mixed, rel=1e-4, abs=1e-4)
    against = positive_parts(model, -model @ mixed)
    assert against == pytest.approx(0.0, abs=1e-3)


def test_edges_of_bands_widen_by_a_quarter_and_by_a_twentieth_of_a_hertz_at_least():
    value = np.random.default_rng(13).standard_normal(6000)
    series = join([Remainder("r", "wrist", np.arange(6000) * DT, value, 1.0, {})])
    at = np.linspace(0.0, 50.0, 50_001)
    edges = at[_edges(series, at)]
    assert edges[0] == pytest.approx(SLOWEST / 60.0, abs=1e-3)
    steps = np.diff(edges)
    assert steps == pytest.approx(np.maximum(0.25 * edges[:-1], 0.05), abs=2.5e-3)
    assert 50.0 / 1.25 - 0.01 <= edges[-1] < 50.0


def test_the_spectrum_of_differences_is_divided_by_what_they_do_to_it():
    """Of first-order noise: its closed form, and that of white noise, where differences alone would rise."""
    for memory in (0.0, 0.05):
        values = [coloured(20_000, memory, np.random.default_rng(s)) for s in (14, 15)]
        series = join(
            [Remainder(str(i), "wrist", np.arange(20_000) * DT, v, 1.0, {}) for i, v in enumerate(values)]
        )
        power, at = _whitened_periodogram(series)
        for low, high in ((1.0, 3.0), (10.0, 14.0), (40.0, 49.0)):
            band = (at > low) & (at < high)
            assert np.mean(power[band]) == pytest.approx(np.mean(first_order(at[band], memory, DT)), rel=0.1)


def test_bands_of_a_background_begin_at_three_periods_of_the_longest_recording():
    series = join(short(0.1, (900, 2000)))
    at, level, count = _bands(series, np.full(len(series.frequencies), 3.0), 2.0)
    first = max(LOWEST, 3.0 / 20.0)
    second = max(1.25 * first, first + max(0.08, 6.0 / 29.0))
    inside = series.frequencies[(series.frequencies >= first) & (series.frequencies < second)]
    assert at[0] == pytest.approx(np.mean(inside))
    assert count[0] == len(inside)
    assert count.sum() == np.count_nonzero(series.frequencies >= first)
    assert level == pytest.approx(3.0 * 2.0 / gamma.ppf(0.5, 2.0))  # whose median is that power
