"""What is put back of a pressure's residual: what was there, and not the noise of its sensor."""

import numpy as np
import pytest
from scipy.signal import savgol_filter

from plants.measured.residual.series.denoised import denoised

NOISE = 0.3
T = np.arange(12_000) / 100.0
THERE = {
    "nothing": np.zeros(T.size),
    "a drift": 0.9 * (T / 60.0 - 1.0),
    "a slow swing": 0.8 * np.sin(2.0 * np.pi * T / 7.0),
    "events": sum(2.5 * np.exp(-np.maximum(T - t, 0.0) / 0.4) * (t <= T) for t in (11.0, 47.0, 90.0)),
}


@pytest.mark.parametrize("which", THERE)
def test_it_errs_less_than_a_local_parabola(which):
    there = THERE[which]
    measured = there + np.random.default_rng(3).normal(0.0, NOISE, T.size)
    error = float(np.std(denoised(measured, NOISE) - there))
    assert error < 0.75 * float(np.std(savgol_filter(measured, 15, 2) - there))


def test_what_stays_of_noise_alone_turns_no_loop():
    """Between neighbouring rows next to nothing moves: the hysteresis would follow every reversal."""
    noise = np.random.default_rng(4).normal(0.0, NOISE, T.size)
    moved = np.sum(np.abs(np.diff(denoised(noise, NOISE))))
    assert moved < 0.02 * np.sum(np.abs(np.diff(savgol_filter(noise, 15, 2))))


def test_a_residual_without_noise_comes_back_whole():
    events = THERE["events"]
    assert np.allclose(denoised(events, 0.0), events)


@pytest.mark.parametrize("rows", [100, 3000])
def test_what_is_as_slow_as_the_series_is_kept_however_small(rows):
    """The widest scale is a few times shorter than the series; what is slower is not asked about."""
    slow = 0.01 * NOISE * np.cos(np.pi * np.arange(rows) / rows)
    inside = slice(rows // 10, -rows // 10)
    found = denoised(slow, NOISE)
    np.testing.assert_allclose(found[inside], slow[inside], atol=0.1 * np.ptp(slow))


def test_a_sensor_that_is_quieter_at_rest_than_in_use():
    noise = np.random.default_rng(5).normal(0.0, NOISE, T.size)
    assert np.allclose(denoised(noise, 0.1 * NOISE), denoised(noise, NOISE), atol=0.3 * NOISE)
    assert np.std(denoised(noise, 0.0)) < 0.1 * NOISE


@pytest.mark.parametrize("rows", [1, 2, 9, 10, 11, 37])
def test_short_recordings_keep_their_rows(rows):
    series = np.linspace(-1.0, 1.0, rows)
    found = denoised(series, 0.1)
    assert found.shape == (rows,)
    assert np.isfinite(found).all()
