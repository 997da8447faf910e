"""Spectrum of stationary sensor noise, of short memory, behind whatever structure a residual has.

A spectrum fitted to everything would call any structure noise.  This one is
robust (medians over bands pass over lines) and bounded in memory: below
half a hertz it is a mixture of white and first-order noise with correlation
times up to LONGEST_MEMORY, so that it levels off where a drift goes on rising.
"""

from itertools import pairwise

import numpy as np

from plants.measured.residual.series.joined import Joined
from plants.measured.residual.series.remainder import Array

LONGEST_MEMORY = 0.6
"""Longest correlation time [s] of what counts as sensor noise; slower is wander, which is an effect."""

MEMORIES = (0.0, 0.01, 0.02, 0.04, 0.08, 0.15, 0.3, LONGEST_MEMORY)
LOWEST = 0.08
"""Lowest frequency [Hz] at which the noise is looked for; below, drift and wander rule."""

FREE = 2.0
"""Above this frequency [Hz] the spectrum may have any smooth shape."""


def background(joined: Joined) -> Array:
    """Power of the noise at each of the series' frequencies, (m,): unit squared, white noise of
    variance v having v everywhere."""
    power, shape = periodogram(joined)
    at, level, count = _bands(joined, power, shape)
    model = np.stack([first_order(at, memory, joined.dt) for memory in MEMORIES], axis=1)
    fitted = level
    for _ in range(4):  # relative errors: reweighted with what was fitted
        weight = np.sqrt(count) / fitted
        parts = positive_parts(model * weight[:, None], level * weight)
        fitted = model @ parts
    smooth = sum(
        p * first_order(joined.frequencies, memory, joined.dt)
        for p, memory in zip(parts, MEMORIES, strict=True)
    )
    ratio = np.where(at < FREE, 0.0, np.log(level / fitted))
    shaped: Array = smooth * np.exp(np.interp(joined.frequencies, at, ratio))
    return shaped


def first_order(frequency: Array, memory: float, dt: float) -> Array:
    """Spectrum of first-order noise of variance 1 and a correlation time [s] sampled each dt, at
    frequencies [Hz]; white for no memory."""
    keep = np.exp(-dt / memory) if memory > 0.0 else 0.0
    found: Array = (1.0 - keep**2) / (1.0 - 2.0 * keep * np.cos(2.0 * np.pi * frequency * dt) + keep**2)
    return found


def positive_parts(model: Array, target: Array) -> Array:
    """Parts p >= 0, (k,), of the columns of a model (n, k) that make up a target (n,) in least squares.

    The active set of `nnls` goes round in circles once in a thousand fits, the columns being so
    alike; an interior-point method, slower, takes over then.
    """
    from scipy.optimize import lsq_linear, nnls

    size = np.sqrt(np.sum(model**2, axis=0))
    try:
        parts = nnls(model / size, target)[0]
    except RuntimeError:
        parts = lsq_linear(model / size, target, bounds=(0.0, np.inf)).x
    found: Array = parts / size
    return found


def periodogram(joined: Joined) -> tuple[Array, float]:
    """Power at each frequency, averaged over the recordings, and its shape as a gamma distribution.

    Each recording is detrended by a line and tapered, so that a drift does not leak upwards.
    """
    from scipy.fft import rfft
    from scipy.signal import detrend
    from scipy.signal.windows import hann

    total, weights = np.zeros(len(joined.frequencies)), []
    for span in joined.spans:
        taper = hann(span.stop - span.start)
        if len(taper) < 16:
            continue
        total += np.abs(rfft(detrend(joined.value[span]) * taper, joined.length)) ** 2
        weights.append(np.sum(taper**2))
    shares = np.array(weights) / sum(weights)
    return np.maximum(total / sum(weights), 1e-30), float(1.0 / np.sum(shares**2))


def _bands(joined: Joined, power: Array, shape: float) -> tuple[Array, Array, Array]:
    """Centre [Hz], level and number of independent values of bands that widen with frequency."""
    from scipy.stats import gamma

    highest = joined.frequencies[-1]
    edges = [max(LOWEST, 3.0 / joined.longest)]
    while edges[-1] < highest:
        edges.append(max(edges[-1] * 1.25, edges[-1] + max(0.08, 6.0 / joined.duration)))
    edges[-1] = highest + 1.0
    found = np.searchsorted(joined.frequencies, edges)
    correction = shape / gamma.ppf(0.5, shape)
    rows = [
        (np.mean(joined.frequencies[a:b]), np.median(power[a:b]) * correction, b - a)
        for a, b in pairwise(found)
        if b - a >= 4
    ]
    at, level, count = np.array(rows).T
    return at, level, count
