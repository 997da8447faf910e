"""How large what is left is: shares of the range and of the error, rather than multiples of a quiet sensor's
noise, which no model of a real rig reaches."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plants.measured.begin import measured
from plants.measured.free_run import FreeRun, squares

Array = NDArray[np.float64]
MATTERS = 0.005
"""Share of the range above which a structured remainder matters.  Below it a model is as good as a sensor of
half a per cent, though a quieter sensor still shows structure."""

NAMED = 0.95
"""Share of what the declared model leaves beyond noise that must be explained for the rest not to matter: a
rig whose errors are small and have no named cause is not explained."""

BANDS = (0.0, 0.1, 1.0, 10.0)
"""Edges [Hz] of the bands that a remainder's spectrum is told in; the last is open."""


@dataclass(frozen=True)
class RemainderSize:
    """What is left of a channel on held-out recordings, without the noise: rms in the channel's unit, share
    of the range of what was measured; spectrum: share of its power in bands, by lower edge [Hz]."""

    rms: float
    share_of_range: float
    spectrum: dict[float, float]


def remainder(runs: Sequence[FreeRun], channel: str, noise: float) -> RemainderSize | None:
    """What free runs leave of a channel; None where it was not logged."""
    errors = squares(runs, channel)
    if not errors:
        return None
    rms = float(np.sqrt(max(float(np.mean(np.concatenate(errors))) - noise**2, 0.0)))
    return RemainderSize(rms, rms / max(span(runs, channel), 1e-12), _spectrum(runs, channel))


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


def _spectrum(runs: Sequence[FreeRun], channel: str) -> dict[float, float]:
    powers = np.zeros(len(BANDS))
    for run in runs:
        truth = measured(run.recording, channel)
        simulated = run.pressure if channel == "pressure_kPa" else run.angle
        if run.role != "validate" or truth is None or simulated is None:
            continue
        left = truth - simulated
        dt = float(np.median(np.diff(run.recording.time)))
        power = np.abs(np.fft.rfft(left)) ** 2
        band = np.searchsorted(BANDS, np.fft.rfftfreq(len(left), dt), side="right") - 1
        powers += np.bincount(band, power, len(BANDS))
    total = powers.sum()
    return {edge: float(p / total) if total > 0.0 else 0.0 for edge, p in zip(BANDS, powers, strict=True)}
