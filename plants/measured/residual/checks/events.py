"""Events in a remainder: moments at which it leaves the noise for a while."""

from dataclasses import dataclass

import numpy as np

from plants.measured.residual.checks.evidence import Evidence
from plants.measured.residual.series.joined import Joined
from plants.measured.residual.series.remainder import Array

WINDOWS = (0.1, 0.25, 0.5, 1.0)
"""Durations of events that are looked for [s]."""

BASELINE = 4.0
"""What is slower than this [s] is wander and no event."""

SURE = 6.0
"""A moment is part of an event from this many standard deviations on."""

EDGE = 5
"""Rows at the ends of a recording that no window touches."""

LONGEST_SHARE = 0.2
"""Where more than this share of the time is eventful, it is something other than events."""


@dataclass(frozen=True)
class Events:
    """What was found: the test of the largest excursion, moments (rows) of the events, and the share
    of the time that they take."""

    evidence: Evidence
    moments: tuple[int, ...]
    duty: float


def events_in(joined: Joined, series: Array, spectrum: Array) -> Events:
    """Events in a residual (n,) behind noise of a spectrum.

    Sums over windows of the residual weighted with the inverse of the noise, which is
    optimal for stationary noise, in standard deviations.  Where the residual is
    louder than noise about its mean in the window, these grow with it: a burst of
    noise is no event, it changes the size.
    """
    from scipy.ndimage import uniform_filter1d

    level = series - _baseline(joined, series)
    weighted = joined.filtered(level, 1.0 / spectrum)
    white = joined.filtered(level, 1.0 / np.sqrt(spectrum))
    largest, sure, trials = 0.0, np.zeros(len(series), dtype=bool), 0.0
    for window in WINDOWS:
        rows = max(3, round(window / joined.dt))
        z = uniform_filter1d(weighted, rows) * rows / _deviation(joined, rows, spectrum)
        loud = uniform_filter1d(white**2, rows) - uniform_filter1d(white, rows) ** 2
        z = np.where(joined.inner(rows // 2 + EDGE), np.abs(z) / np.sqrt(np.maximum(1.0, loud)), 0.0)
        largest = max(largest, float(np.max(z)))
        sure |= uniform_filter1d((z > SURE).astype(float), rows) > 0.0
        trials += joined.rows
    sure &= joined.inside
    excess = float(np.sum(level[sure] ** 2)) - np.count_nonzero(sure) * float(np.mean(spectrum))
    starts = np.flatnonzero(np.diff(sure.astype(int), prepend=0) == 1)
    return Events(
        Evidence(largest, "norm", (), trials, max(0.0, float(excess)) / joined.rows),
        tuple(starts.tolist()),
        float(np.mean(sure[joined.inside])),
    )


def _deviation(joined: Joined, rows: int, spectrum: Array) -> float:
    """Standard deviation of a weighted sum over a window, for noise of the spectrum."""
    window = np.zeros(len(joined.value))
    window[:rows] = 1.0
    gain = np.abs(joined.transform(window)) ** 2 / spectrum
    return float(np.sqrt(2.0 * np.sum(gain) / joined.length))


def _baseline(joined: Joined, series: Array) -> Array:
    """Running median of a series (n,), over tenths of a second."""
    from scipy.ndimage import median_filter

    rows = max(1, round(0.1 / joined.dt))
    found = np.zeros(len(series))
    for span in joined.spans:
        count = span.stop - span.start
        parts = max(1, count // rows)
        means = np.add.reduceat(series[span], np.arange(parts) * rows)
        sizes = np.diff(np.append(np.arange(parts) * rows, count))
        smooth = median_filter(means / sizes, max(3, round(BASELINE / 0.1) | 1), mode="nearest")
        found[span] = np.interp(np.arange(count), np.arange(parts) * rows + sizes / 2.0, smooth)
    return found
