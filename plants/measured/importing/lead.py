"""Which of two channels moves first, and by how much."""

import numpy as np

from plants.measured.formats.channel import Array, LoggedChannel

LONGEST = 3.0
"""Longest time [s] by which one channel is looked for in another."""


def lead(a: LoggedChannel, b: LoggedChannel) -> tuple[float, float]:
    """Time [s] by which `a` moves before `b`, and how like they then move, 0 to 1.

    >>> t = np.arange(4000) * 0.01
    >>> u, late = np.sign(np.sin(t)), np.sign(np.sin(t - 0.2))
    >>> lag, likeness = lead(LoggedChannel("u", "", t, u), LoggedChannel("p", "", t, late))
    >>> round(lag, 2), likeness > 0.9
    (0.2, True)
    """
    from scipy.signal import correlate, correlation_lags

    step = max(a.step, b.step)
    first, last = max(a.time[0], b.time[0]), min(a.time[-1], b.time[-1])
    grid = np.arange(first, min(last, first + 30_000 * step), step)
    if len(grid) < 16:
        return 0.0, 0.0
    # Rates of change, smoothed over some samples, so that noise does not count and levels do not either.
    moved = [np.gradient(_smooth(np.interp(grid, c.time, c.values))) for c in (a, b)]
    x, y = (m - m.mean() for m in moved)
    size = float(np.linalg.norm(x) * np.linalg.norm(y))
    if not size:
        return 0.0, 0.0
    like = np.abs(correlate(y, x, method="fft")) / size
    lags = correlation_lags(len(y), len(x))
    near = np.abs(lags) * step <= LONGEST
    at = int(np.argmax(like[near]))
    return float(lags[near][at] * step), float(like[near][at])


def _smooth(values: Array) -> Array:
    kernel = np.ones(5) / 5.0
    return np.convolve(np.pad(values, 2, mode="edge"), kernel, mode="valid")
