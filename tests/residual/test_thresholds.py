"""What counts as found, and what is too small, too rare or too fast to be looked at."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.stats import chi2, gamma

from plants.measured.residual.battery import make_tests
from plants.measured.residual.checks.events import events_in
from plants.measured.residual.checks.evidence import Evidence
from plants.measured.residual.checks.periodic import Line, Spectrum, harmonic, line_in, spectrum_of
from plants.measured.residual.series.bins import bins_of, stretches
from plants.measured.residual.series.joined import SILENCE, join
from plants.measured.residual.series.remainder import Remainder
from tests.residual.made import DT


def joined(*values, dt=DT, **variables):
    made = [
        Remainder(str(i), "wrist", np.arange(len(v)) * dt, v, 1.0, variables) for i, v in enumerate(values)
    ]
    return join(made)


def white(rows, seed=0):
    return np.random.default_rng(seed).standard_normal(rows)


@pytest.fixture(scope="module")
def battery():
    return make_tests(joined(white(9000), x=np.sin(np.arange(9000) / 300.0)), 1.0, 0)


def sure(power):
    return Evidence(100.0, "norm", (), 1.0, power)


@pytest.mark.parametrize(
    ("kind", "least"),
    [
        ("conditional mean", 0.02),
        ("cross-correlation", 0.02),
        ("periodic", 0.02),
        ("offset", 0.02),
        ("events", 0.01),
    ],
)
def test_a_part_counts_from_its_share_of_the_noise_or_of_the_whole(battery, kind, least):
    for noise, whole in ((2.0, 4.0), (0.1, battery.total)):
        b = replace(battery, noise=noise)
        assert b.counts(kind, sure(1.001 * least * whole))
        assert not b.counts(kind, sure(0.999 * least * whole))
    assert not battery.counts(kind, Evidence(0.5, "norm", (), 1.0, 10.0))  # large, and not certain
    coarse = replace(battery, noise=1.0, rounding=3.0)  # rounding leaves up to a twelfth of its square
    assert not coarse.counts(kind, sure(0.74 + least * battery.total))
    assert coarse.counts(kind, sure(0.76 + least * max(1.0, battery.total)))


def test_a_changing_size_counts_by_itself_and_whiteness_never(battery):
    b = replace(battery, noise=5.0)
    assert b.counts("changing size", sure(0.0101))
    assert not b.counts("changing size", sure(0.0099))
    assert not b.counts("whiteness", sure(100.0))


def test_what_a_battery_says_of_itself(battery):
    value = battery.joined.value[battery.joined.inside]
    assert battery.total == pytest.approx(np.var(value))
    assert battery.freedom == pytest.approx(0.36 * 90.0)
    assert replace(battery, joined=joined(white(1000))).freedom == 10.0
    assert battery.each == pytest.approx(2e-5 / len(battery.evidence))
    for noise, power in ((1.0, 0.75), (1.06, 0.0)):
        assert replace(battery, noise=noise, rounding=3.0).rounding_power == power
    assert battery.found() == []
    assert {kind for kind, _ in battery.evidence} == {
        "conditional mean", "cross-correlation", "periodic", "offset", "events", "changing size", "whiteness",
    }  # fmt: skip


def test_an_offset_is_held_against_its_deviation():
    found = make_tests(joined(white(9000) + 0.5), 1.0, 0)
    offset = found.evidence["offset", "offset"]
    variance = found.noise_spectrum[0] / 9000
    assert offset.statistic == pytest.approx(found.joined.mean**2 / variance)
    assert offset.power == pytest.approx(found.joined.mean**2 - variance)
    assert found.joined.mean == pytest.approx(0.5, abs=0.05)


def test_an_offset_of_noise_alone_is_as_likely_as_student_says():
    """Its deviation is known as well as the noise's spectrum is."""
    battery = make_tests(joined(white(9000)), 1.0, 0)
    offset = battery.evidence["offset", "offset"]
    student = stats.t.sf(np.sqrt(offset.statistic), battery.freedom)
    assert offset.p_value == pytest.approx(2.0 * student, rel=1e-6)
    assert 0.01 < offset.p_value < 0.99


@pytest.mark.parametrize(
    ("size", "noise", "least"), [(1.0, 0.0, 5e-10), (2e3, 0.0, 2e-3), (1.0, 0.5, 2.5e-7)]
)
def test_noise_is_a_billionth_of_the_power_at_least_and_a_millionth_of_the_floors(size, noise, least):
    """A series without noise, of a simulation, has a spectrum to be divided by all the same."""
    found = make_tests(joined(size * np.sin(2.0 * np.pi * np.arange(9000) / 900.0)), noise, 0)
    assert found.noise_spectrum.min() == pytest.approx(least, rel=1e-6)


@pytest.mark.parametrize(("noise", "steps"), [(1.0, 0.0), (0.6, 1.0)])
def test_steps_that_noise_blurs_are_no_rounding(noise, steps):
    assert make_tests(joined(white(900)), noise, 0, resolution=1.0).rounding == steps


def test_a_hum_is_named_by_its_frequency_and_told_where_it_is_strong():
    time = np.arange(6000) * DT
    series = joined(white(6000) + 0.4 * np.sin(2.0 * np.pi * 3.217 * time + 1.0))
    found = line_in(series, spectrum_of(series, np.ones(len(series.frequencies))))
    assert found.frequency == pytest.approx(3.217, abs=2e-3)
    assert found.name == "periodic at 3.22 Hz"
    assert found.evidence.power == pytest.approx(0.08, rel=0.2)  # half of the square of its amplitude
    assert found.evidence.p_value < 1e-9
    assert found.steady
    half = joined(white(6000) + np.where(time < 24.0, 0.8, 0.0) * np.sin(2.0 * np.pi * 3.217 * time))
    assert not line_in(half, spectrum_of(half, np.ones(len(half.frequencies)))).steady


@pytest.mark.parametrize(
    ("rows", "hertz", "there"), [(1000, 0.27, False), (1600, 0.27, True), (6000, 0.2, False)]
)
def test_a_hum_has_four_periods_in_the_longest_recording_and_a_quarter_of_a_hertz(rows, hertz, there):
    series = joined(white(rows) + 5.0 * np.sin(2.0 * np.pi * hertz * np.arange(rows) * DT))
    found = line_in(series, spectrum_of(series, np.ones(len(series.frequencies))))
    assert found.frequency >= max(0.25, 4.0 / (rows * DT)) - 0.02
    assert (abs(found.frequency - hertz) < 0.02) == there


def test_a_bound_of_the_spectrum_is_the_gamma_law_over_all_frequencies():
    level = np.array([1.0, 2.0, 4.0])
    spectrum = Spectrum(np.arange(3.0), level, level, 1.0)
    assert spectrum.trials == 6.0
    np.testing.assert_allclose(spectrum.bound(0.01), level * chi2.isf(0.01 / 6.0, 2) / 2.0)
    np.testing.assert_allclose(
        replace(spectrum, shape=3.0).bound(0.01), level * gamma.isf(0.01 / 6.0, 3.0) / 3.0
    )


def test_the_level_of_a_spectrum_is_that_around_it_and_no_less_than_the_noises():
    series = joined(3.0 * white(12_000))
    flat = np.ones(len(series.frequencies))
    found = spectrum_of(series, flat)
    assert np.mean(found.level) == pytest.approx(9.0, rel=0.1)
    assert spectrum_of(series, 100.0 * flat).level.min() == 100.0


def test_waves_are_of_each_recording_from_its_own_start():
    series = joined(white(1000), white(500))
    waves = harmonic(series, 2.0)
    for i, span in enumerate(series.spans):
        time = np.arange(span.stop - span.start) * DT
        np.testing.assert_allclose(waves[2 * i, span], np.cos(4.0 * np.pi * time), atol=1e-9)
        np.testing.assert_allclose(waves[2 * i + 1, span], np.sin(4.0 * np.pi * time), atol=1e-9)
        assert not waves[2 * i : 2 * i + 2, : span.start].any()
    assert Line(2.0, sure(1.0), True).name == "periodic at 2 Hz"


def test_edges_of_bins_are_half_of_equal_counts_and_half_of_equal_distances():
    draw = np.random.default_rng(3).exponential(1.0, 40_000)
    found = bins_of(joined(white(40_000), x=draw), "x")
    counted = np.quantile(draw, np.arange(1, 6) / 6.0)
    low, high = np.quantile(draw, [0.002, 0.998])
    expected = np.sort(np.concatenate([counted, low + (high - low) * np.arange(1, 7) / 7.0]))
    known = found.label[found.label >= 0]
    between = [draw[known == k].max() for k in range(len(found.centre) - 1)]
    kept = expected[[np.argmin(np.abs(expected - b)) for b in between]]
    np.testing.assert_allclose(between, kept, atol=2e-2)
    counts = np.bincount(known)
    assert counts.min() >= 160  # 0.4 %
    assert len(counts) == 12  # none of the edges leaves less
    for k, centre in enumerate(found.centre):
        assert centre == pytest.approx(draw[known == k].mean())


@pytest.mark.parametrize(("levels", "bins"), [(2, 2), (6, 6)])
def test_few_levels_are_bins_of_their_own(levels, bins):
    values = np.repeat(np.arange(float(levels)), 300)
    found = bins_of(joined(white(300 * levels), x=values), "x")
    assert found.centre.tolist() == list(range(bins))


@pytest.mark.parametrize(("share", "there"), [(0.019, False), (0.021, True)])
def test_a_variable_that_is_logged_too_rarely_has_no_bins(share, there):
    values = np.where(np.arange(10_000) < 10_000 * share, np.arange(10_000.0), np.nan)
    assert (bins_of(joined(white(10_000), x=values), "x") is not None) == there


def test_stretches_of_time_are_of_eight_seconds_and_sixty_at_most():
    assert len(stretches(joined(white(8000))).centre) == 10
    label = stretches(joined(white(8000), white(2000))).label
    assert label[:8000].tolist() == np.repeat(np.arange(10), 800).tolist()
    assert (label[8000:8400] == -1).all()  # the silence
    assert label[8400:10_400].tolist() == [10] * 1000 + [11] * 1000  # 20 s make two and a half
    assert len(stretches(joined(white(70_000))).centre) == 60


def test_a_step_that_lasts_half_a_second_is_an_event_and_where_it_begins_is_told():
    values = white(6000)
    values[3000:3050] += 4.0
    series = joined(values)
    found = events_in(series, series.value, np.ones(len(series.frequencies)))
    (moment,) = found.moments
    assert 2900 <= moment <= 3000  # the longest window that is sure of it reaches a second around
    assert 50 <= 6000 * found.duty <= 250
    assert found.evidence.trials == 4 * 6000
    assert found.evidence.statistic == pytest.approx(4.0 * np.sqrt(50.0), rel=0.2)
    assert found.evidence.power == pytest.approx(16.0 * 50 / 6000, rel=0.4)
    calm = joined(white(6000))
    none = events_in(calm, calm.value, np.ones(len(calm.frequencies)))
    assert none.moments == ()
    assert none.duty == none.evidence.power == 0.0


def test_a_series_knows_its_time_and_its_frequencies():
    series = joined(white(1000) + 2.0, white(300) + 2.0)
    silence = round(SILENCE / DT)
    assert [(s.start, s.stop) for s in series.spans] == [(0, 1000), (1000 + silence, 1300 + silence)]
    assert (series.rows, series.duration, series.longest) == pytest.approx((1300, 13.0, 10.0))
    assert not series.value[~series.inside].any()
    assert np.sum(series.counts) == series.length  # positive and negative frequencies
    assert series.frequencies[1] == pytest.approx(1.0 / (series.length * DT))
    inner = series.inner(7)
    assert np.flatnonzero(inner)[[0, -1]].tolist() == [7, 1293 + silence - 1]
    assert np.count_nonzero(inner) == 1300 - 4 * 7
    energy = np.sum(np.abs(np.fft.fft(series.value, series.length)) ** 2)
    assert np.sum(series.counts * np.abs(series.transform(series.value)) ** 2) == pytest.approx(energy)
