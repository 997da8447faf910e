"""Noise floor of a measured channel, from the data alone."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
KEPT = 0.90
"""Share of the third differences that is used: the largest stem from motion, not from noise."""


def noise_floor(values: Array) -> float:
    """Standard deviation of white noise on a slowly moving signal, shape (n,), in its unit.

    Third differences remove any motion that is a parabola over four rows and
    multiply white noise by sqrt(20); their spread is taken from the smaller
    nine tenths, corrected for that trimming as for a normal distribution.  A
    rank statistic such as the MAD would be lumpy, since logs are rounded.  Never
    below the error of rounding.
    Raises ValueError for fewer than 8 values.

    >>> rng = np.random.default_rng(1)
    >>> round(noise_floor(np.sin(np.arange(20_000) / 50) + 0.1 * rng.standard_normal(20_000)), 3)
    0.1
    """
    from scipy.stats import norm

    if values.size < 8:
        raise ValueError("a noise floor needs at least 8 values")
    sizes = np.sort(np.abs(np.diff(values, 3)))
    kept = sizes[: max(4, round(KEPT * sizes.size))]
    cut = norm.ppf(0.5 + KEPT / 2.0)
    shrink = 1.0 - 2.0 * cut * norm.pdf(cut) / KEPT  # variance of a normal cut at that quantile
    spread = float(np.sqrt(np.mean(kept**2) / shrink / 20.0))
    return max(spread, float(resolution(values) / 12.0**0.5))


def resolution(values: Array) -> float:
    """Smallest step between the values of a channel; 0 for a channel that never changes.

    A channel cannot be known better than its rounding, whose error is uniform.
    """
    steps = np.diff(np.unique(values))
    return float(np.min(steps)) if steps.size else 0.0


def noise_of(recordings: list[Array]) -> float | None:
    """Noise floor of a channel over several recordings, weighted by their lengths; None for none."""
    usable = [r for r in recordings if r.size >= 8]
    if not usable:
        return None
    variances = [noise_floor(r) ** 2 for r in usable]
    return float(np.sqrt(np.average(variances, weights=[r.size for r in usable])))
