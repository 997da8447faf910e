"""How large what is left is: shares of the range and of the error, rather than multiples of a quiet sensor's
noise, which no model of a real rig reaches."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from plants.effects.wrist.remainder import SHOWS
from plants.measured.campaigns.begin import measured
from plants.measured.fitting.free_run import FreeRun, squares
from plants.measured.trace.revision.uncertainty_weight import uncertainty_weight
from plants.parameters.remainder import BANDS, CHANNELS, RemainderSize

Array = NDArray[np.float64]
MATTERS = 0.005
"""Share of the range above which a structured residual matters.  Below it a model is as good as a sensor of
half a per cent, though a quieter sensor still shows structure."""

NAMED = 0.95
"""Share of what the declared model leaves beyond noise that must be explained for the rest not to matter: a
rig whose errors are small and have no named cause is not explained."""


AVERAGED = 0.1
"""Time [s] over which a residual is averaged before its largest is taken, so that it is not the noise's."""


def remainder(runs: Sequence[FreeRun], channel: str, noise: float) -> RemainderSize | None:
    """What free runs leave of a channel on held-out recordings; None where it was not logged."""
    from scipy.ndimage import uniform_filter1d

    errors = squares(runs, channel)
    if not errors:
        return None
    rms = float(np.sqrt(max(float(np.mean(np.concatenate(errors))) - noise**2, 0.0)))
    largest = 0.0
    for left, _, dt in _left(runs, channel):
        rows = max(1, round(AVERAGED / dt))
        loudest = noise * float(np.sqrt(2.0 * np.log(len(left)) / rows))  # expected of white noise alone
        smooth = uniform_filter1d(left, rows, mode="nearest")
        largest = max(largest, float(np.abs(smooth).max()) - loudest)
    return RemainderSize(
        rms, max(largest, rms), *_correlation(runs, channel), noise,
        rms / max(span(runs, channel), 1e-12), _spectrum(runs, channel),
        uncertainty_weight(list(_left(runs, channel)), noise) if rms > SHOWS * noise else None,
    )  # fmt: skip


def remainders_of(runs: Sequence[FreeRun], noise: Mapping[str, float | None]) -> dict[str, RemainderSize]:
    """What free runs leave of every channel that was logged, by channel."""
    found = {c: remainder(runs, c, noise.get(c) or 0.0) for c in CHANNELS}
    return {c: left for c, left in found.items() if left is not None}


def span(runs: Sequence[FreeRun], channel: str) -> float:
    """Range of what was measured of a channel in all recordings."""
    found = [v for r in runs if (v := measured(r.recording, channel)) is not None]
    return max(float(v.max()) for v in found) - min(float(v.min()) for v in found)


def explained_share(before: float | None, after: float | None, noise: float | None) -> float | None:
    """Share of the variance above the noise that the declared model leaves and the revised one does not;
    None where a channel was not logged or the declared model leaves none.

    >>> explained_share(1.0, 0.5, 0.0), explained_share(0.1, 0.1, 0.1)
    (0.75, None)
    """
    if before is None or after is None or noise is None or before <= noise:
        return None
    return (before**2 - max(after, noise) ** 2) / (before**2 - noise**2)


def _left(runs: Sequence[FreeRun], channel: str) -> Iterator[tuple[Array, Array, float]]:
    """What each held-out recording leaves of a channel, (n,), what was simulated, and the sample time [s]."""
    for run in runs:
        truth = measured(run.recording, channel)
        simulated = run.pressure if channel == "pressure_kPa" else run.angle
        if run.role == "validate" and truth is not None and simulated is not None:
            yield truth - simulated, simulated, float(np.median(np.diff(run.recording.time)))


def _correlation(runs: Sequence[FreeRun], channel: str) -> tuple[float, float]:
    """Lag in time [s], and along the way that the simulated channel goes, in its unit, at which the
    autocovariance of what is left has fallen to 1/e of that between neighbours, which white noise does not
    share; means over recordings, weighted by that."""
    from scipy.ndimage import uniform_filter1d

    found, weights = [], []
    for left, simulated, dt in _left(runs, channel):
        smooth = uniform_filter1d(left, max(1, round(AVERAGED / dt)), mode="nearest")
        way = np.append(0.0, np.cumsum(np.abs(np.diff(simulated))))
        even = np.linspace(0.0, max(way[-1], 1e-9), len(way))
        along, _ = _forgets(np.interp(even, way, smooth))
        lag, weight = _forgets(left)
        found.append((dt * lag, float(even[1]) * along))
        weights.append(max(weight, 1e-12))
    time, way_ = np.average(found, axis=0, weights=weights)
    return float(time), float(way_)


def _forgets(values: Array) -> tuple[float, float]:
    """Rows after which the autocovariance of values has fallen to 1/e of that between neighbours, one at
    least, and that of neighbours."""
    spectrum = np.fft.rfft(values, 2 * len(values))
    covariance = np.fft.irfft(np.abs(spectrum) ** 2)[: len(values)]
    fallen = np.flatnonzero(covariance <= max(covariance[1], 0.0) / np.e)
    return max(float(fallen[0]) if fallen.size else len(values), 1.0), float(covariance[1])


def _spectrum(runs: Sequence[FreeRun], channel: str) -> dict[float, float]:
    powers = np.zeros(len(BANDS))
    for left, _, dt in _left(runs, channel):
        power = np.abs(np.fft.rfft(left)) ** 2
        band = np.searchsorted(BANDS, np.fft.rfftfreq(len(left), dt), side="right") - 1
        powers += np.bincount(band, power, len(BANDS))
    total = powers.sum()
    return {edge: float(p / total) if total > 0.0 else 0.0 for edge, p in zip(BANDS, powers, strict=True)}
