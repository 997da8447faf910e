"""The background of a residual, its noise's spectrum: what it passes over, its solver, its bands."""

import numpy as np
import pytest
from scipy.stats import gamma

from plants.measured.residual.series import background as series_background
from plants.measured.residual.series.background import (
    LONGEST_MEMORY,
    LOWEST,
    _bands,
    background,
    first_order,
    positive_parts,
)
from plants.measured.residual.series.joined import join
from plants.measured.residual.series.remainder import Remainder
from plants.measured.residual.stillness import SLOWEST, _edges, _whitened_periodogram
from tests.residual.made import DT, coloured, noise, short, with_structure


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
