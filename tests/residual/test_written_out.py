"""Pieces of the residual's examination on series so short that their formulas can be written out."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import gamma

from plants.measured.residual.checks.correlation import AFTER, BEFORE, correlation
from plants.measured.residual.checks.events import _baseline
from plants.measured.residual.checks.evidence import NOTHING
from plants.measured.residual.checks.periodic import Spectrum, _refined, line_in, spectrum_of
from plants.measured.residual.checks.size import BURST, EDGE, Sizes, burst_test, evened, is_rough, sizes_of
from plants.measured.residual.series.background import first_order
from plants.measured.residual.series.joined import Joined, join
from plants.measured.residual.series.remainder import Remainder
from plants.measured.residual.stillness import DISTURBED, MOVED, SETTLED, SHORTEST, still_noise, still_rows
from tests.residual.made import DT, RUNS, coloured


def joined(*values, **variables):
    """Series of white noise as it is, with variables of the first."""
    return join(
        [Remainder(str(i), "wrist", np.arange(len(v)) * DT, v, 1.0, variables) for i, v in enumerate(values)]
    )


def white(rows, seed=0):
    return np.random.default_rng(seed).standard_normal(rows)


def test_correlation_is_the_sum_of_products_written_out():
    rng = np.random.default_rng(1)
    moved = np.where(rng.random(2000) < 0.05, rng.standard_normal(2000), 0.0)
    variable, late = np.cumsum(moved), 30
    values = white(2000, 2) + 3.0 * np.concatenate([np.zeros(late), moved[:-late]])
    series = joined(values, x=variable)
    value = series.value[series.inside]
    found = correlation(series, series.value, "x", np.ones(len(series.frequencies)))
    changes = np.concatenate([[0.0], np.diff(variable)])
    scale = np.sqrt(np.sum(changes**2) * np.sum(value**2))
    lags = np.arange(-50, 301)
    assert (BEFORE, AFTER) == (0.5, 3.0)
    assert found.lag == pytest.approx(lags * DT)

    def products(one, other):
        return np.array(
            [np.sum(one[max(k, 0) : 2000 + min(k, 0)] * other[max(-k, 0) : 2000 - max(k, 0)]) for k in lags]
        )

    by_hand = products(value, changes)
    np.testing.assert_allclose(found.value, by_hand / scale, atol=1e-12)
    np.testing.assert_allclose(
        found.agreement, by_hand / np.sqrt(products(value**2, changes**2)), rtol=1e-6, atol=1e-9
    )
    assert found.lag[np.argmax(found.value)] == pytest.approx(late * DT)
    assert found.deviation == pytest.approx(
        np.sqrt(np.sum(changes**2)) / scale, rel=1e-9
    )  # of white noise of 1
    lasting = products(changes, changes) / np.sum(changes**2)
    assert found.sharpness == pytest.approx(1.0 / np.sum(lasting**2), rel=1e-9)
    high = (np.abs(found.value) > 5.0 * found.deviation) & (np.abs(found.agreement) > 3.0)
    assert 1 <= np.count_nonzero(high) < 20
    told = found.evidence(2.0)
    explained = np.sum(found.value[high] ** 2 - found.deviation**2) * found.sharpness
    assert told.power == pytest.approx(2.0 * min(1.0, explained))
    assert told.trials == len(lags)
    assert told.statistic == pytest.approx(np.abs(found.value).max() / found.deviation)


@pytest.mark.parametrize(("jumps", "there"), [(12, False), (13, True)])
def test_a_correlation_needs_more_than_a_dozen_equal_changes(jumps, there):
    moved = np.zeros(2000)
    moved[50 : 50 + 100 * jumps : 100] = 1.0
    series = joined(white(2000), x=np.cumsum(moved))
    assert (correlation(series, series.value, "x", np.ones(len(series.frequencies))) is not None) == there


def test_bursts_are_counted_in_means_of_half_a_second():
    """Sizes of independent normal values: the statistic, and the gamma distribution that it has."""
    series = joined(white(5030))
    sizes = np.where(series.inside, np.abs(white(len(series.value), 3)) - np.sqrt(2.0 / np.pi), 0.0)
    found = burst_test(series, Sizes(sizes, 1.0))
    inside = sizes[series.inside]
    means = [inside[k : k + 50].mean() for k in range(0, 5000, 50)]
    variance = np.mean(inside**2)
    assert BURST == 50 * DT
    assert found.statistic == pytest.approx(50.0 * np.mean(np.square(means)) / variance)
    assert found.power == pytest.approx(np.mean(np.square(means)) - variance / 50.0)
    excess = np.mean(inside**4) / variance**2 - 3.0
    law = gamma(*found.arguments)
    assert law.mean() == pytest.approx(1.0)
    assert law.var() == pytest.approx((2.0 + excess / 50.0) / 100)
    assert burst_test(series, Sizes(np.zeros_like(sizes), 1.0)) == NOTHING


def test_sizes_are_shares_of_their_mean_away_from_the_ends():
    series = joined(5.0 * white(3000))
    flat = np.full(len(series.frequencies), 25.0)
    found = sizes_of(series, series.value, flat)
    there = np.zeros(len(series.value), bool)
    there[EDGE : 3000 - EDGE] = True
    assert (found.value[~there] == 0.0).all()
    assert np.mean(found.value[there]) == pytest.approx(0.0, abs=1e-12)
    assert found.variance == pytest.approx(np.mean(found.value[there] ** 2))
    assert found.variance == pytest.approx(np.pi / 2.0 - 1.0, abs=0.05)  # of half-normal sizes
    assert (sizes_of(series, np.zeros_like(series.value), flat).value == 0.0).all()  # of nothing, everywhere
    lone = series.value - 20.0 * series.inside  # a mean that moves is no size
    assert sizes_of(series, lone, flat).value[500:2500] == pytest.approx(found.value[500:2500], abs=0.15)


def test_a_loud_second_is_evened_and_the_rest_is_left():
    values = white(4000, 5)
    values[1000:1100] *= 6.0
    series = joined(values)
    found = evened(series, series.value, np.ones(len(series.frequencies)))
    assert np.std(found[1010:1090]) < 2.0
    assert np.std(found[2000:]) == pytest.approx(np.std(values[2000:]), rel=0.35)
    assert (np.abs(found) <= np.abs(series.value) + 1e-12).all()


def test_loud_noise_is_rough_and_a_transient_is_not():
    values = white(4000, 6)
    loud, swing = values.copy(), values.copy()
    loud[1000:1400] *= 6.0
    swing[1000:1400] += 12.0 * np.sin(np.arange(400) * 2.0 * np.pi / 40.0)
    for made, rough in ((loud, True), (swing, False)):
        series = joined(made)
        assert is_rough(series, series.value, np.ones(len(series.frequencies))) == rough


def test_what_is_loud_is_judged_by_what_is_new_in_coloured_noise():
    """Innovations of first-order noise, five times as large for two seconds: as of the white ones of it."""
    keep, new = np.exp(-DT / 0.1), white(4000, 9)
    new[1000:1200] *= 5.0
    spectrum = first_order(np.fft.rfftfreq(joined(new).length, DT), 0.1, DT)
    series = joined(lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], new))
    plain, flat = joined(new), np.ones_like(spectrum)
    assert is_rough(series, series.value, spectrum)
    assert not is_rough(series, series.value, flat)
    told = evened(series, series.value, spectrum)[:4000] / series.value[:4000]
    by_new = evened(plain, plain.value, flat)[:4000] / plain.value[:4000]
    assert np.mean(np.abs(told / by_new - 1.0) < 0.1) > 0.97
    assert told[1000:1200].max() < 0.6
    sizes, of_new = sizes_of(series, series.value, spectrum), sizes_of(plain, plain.value, flat)
    assert sizes.variance == pytest.approx(of_new.variance, rel=0.15)
    calm = sizes.value[1300:3900]
    assert abs(np.corrcoef(calm[1:], calm[:-1])[0, 1]) < 0.1  # where noise is stationary they are unrelated


def test_a_line_is_held_against_the_law_of_the_spectrum_around_it():
    """Of mean 1, its bound that of the spectrum's curve; and white noise keeps to it."""
    values = []
    for seed in range(30):
        series = joined(white(3000, seed), white(2000, seed + 100))
        spectrum = spectrum_of(series, np.ones(len(series.frequencies)))
        evidence = line_in(series, spectrum).evidence
        law = gamma(*evidence.arguments)
        assert (law.mean(), law.var()) == pytest.approx((1.0, 1.0 / spectrum.shape))
        np.testing.assert_allclose(spectrum.bound(1e-4), spectrum.level * evidence.bound(1e-4))
        values.append(evidence.p_value)
    assert np.mean(np.array(values) < 0.2) < 0.4
    assert np.median(values) > 0.2


def test_the_baseline_follows_a_ramp_and_what_lasts_longer_than_half_of_its_four_seconds():
    ramp = np.linspace(0.0, 3.0, 3000)
    series = joined(ramp)
    for lasts, followed in ((0, 0.0), (120, 0.0), (180, 0.0), (240, 5.0)):
        made = ramp.copy()
        made[1500 - lasts // 2 : 1500 + lasts // 2] += 5.0
        found = _baseline(series, np.concatenate([made, np.zeros(len(series.value) - 3000)]))
        assert found[1500] == pytest.approx(ramp[1500] + followed, abs=0.25)
        np.testing.assert_allclose(found[:1000], ramp[:1000], atol=0.06)


def recording_with(command, dt=DT):
    time = np.arange(len(command)) * dt
    blank = np.zeros(len(command))
    return replace(
        RUNS[0], time=time, command=np.asarray(command), angle=blank, pressure=blank, other_pressure=None
    )


def test_rows_are_still_three_seconds_after_a_move_and_for_a_second_and_a_half():
    assert (SETTLED, SHORTEST, MOVED) == (3.0, 1.5, 0.002)
    long, short, drift = np.full(600, 1.0), np.full(448, 2.0), np.full(460, 2.0015)
    found = still_rows(recording_with(np.concatenate([long, short, long, drift])))
    assert [(s.start, s.stop) for s in found] == [(300, 600), (1348, 1648), (1948, 2108)]
    steps = still_rows(recording_with(np.repeat([1.0, 1.0015, 1.0], 300)))
    assert [(s.start, s.stop) for s in steps] == [(300, 900)]  # moves as small as that are none


def test_a_stretch_that_was_disturbed_is_left_out():
    rng = np.random.default_rng(7)
    command = np.repeat([1.0, 2.0, 1.0, 2.0, 1.0], 1000)
    values = coloured(5000, 0.1, rng)
    recording = recording_with(command)
    whole = still_noise([recording], [values])
    assert [s.stop - s.start for s in whole.spans] == [700] * 5
    for times, kept in ((0.8, 5), (1.4, 4)):
        loud = values.copy()
        loud[1300:2000] *= times * np.sqrt(
            DISTURBED
            * np.median([np.var(values[k + 300 : k + 1000]) for k in range(0, 5000, 1000)])
            / np.var(values[1300:2000])
        )
        assert len(still_noise([recording], [loud]).spans) == kept
    assert still_noise([recording_with(command[:2600])], [values[:2600]]) is None  # of 17 s nothing is said
    assert still_noise([recording], [np.zeros(5000)]) is None  # nor of a sensor that rests


def test_a_test_that_could_not_be_made_accounts_for_nothing():
    assert (NOTHING.p_value, NOTHING.power) == (1.0, 0.0)


@pytest.mark.parametrize("near", [1, 5, 8])
def test_a_peak_between_frequencies_is_where_its_parabola_is(near):
    """The logarithm of this power is a parabola, also beside the first and the last frequency."""
    frequency = 0.1 * np.arange(10.0)
    peak = frequency[near] + 0.03
    spectrum = Spectrum(frequency, np.exp(-((frequency - peak) ** 2)), np.ones(10), 1.0)
    assert _refined(spectrum, near) == pytest.approx(peak)
    assert [_refined(spectrum, end) for end in (0, 9)] == [0.0, frequency[9]]


@pytest.mark.parametrize("length", [2025, 2048, 2250])
def test_frequencies_and_their_counts_are_those_of_a_real_transform_of_any_length(length):
    value = white(length)
    series = Joined(DT, (slice(0, length),), np.ones(length, bool), value, 0.0, {})
    assert series.length == length
    assert series.frequencies == pytest.approx(np.fft.rfftfreq(length, DT))
    power = np.abs(series.transform(value)) ** 2
    assert np.sum(series.counts * power) / length == pytest.approx(np.sum(value**2))  # Parseval
    assert series.filtered(value, np.ones(len(series.frequencies))) == pytest.approx(value)
