"""Noise floor of a measured channel, from the data alone."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
KEPT = 0.90
"""Share of the third differences that is used: the largest stem from motion, not from noise."""

HUMS, LINE, SLOWEST_HUM = 3, 40.0, 0.02
"""Lines of a sinusoid that are looked for; how far one stands above the power around it, which noise reaches
in one of 1e13 recordings; and the slowest [cycles per row]: differences hardly see slower ones."""

STRIDE = 3
"""Rows over which differences are compared with those from row to row, to tell noise with a memory."""

LEAST_COLOUR = 0.06
"""Noise whose differences over STRIDE rows are larger by less than this part is as good as white."""

SURE, SCATTER = 5.0, 1.5
"""Standard deviations by which they must be larger; its square, times the number of differences."""

ROUNDED = 1e-12
"""Share of the largest value below which a step is the rounding of a conversion."""


def noise_floor(values: Array) -> float:
    """Standard deviation of white noise on a slowly moving signal, shape (n,), in its unit.

    Third differences remove any motion that is a parabola over four rows and
    multiply white noise by sqrt(20); their spread is taken from the smaller
    nine tenths, corrected for that trimming as for a normal distribution.  A
    rank statistic such as the MAD would be lumpy, since logs are rounded.  A fast
    sinusoid, which differences would take for noise, is taken out of them.  Never
    below the error of rounding.
    Raises ValueError for fewer than 8 values.

    >>> rng = np.random.default_rng(1)
    >>> round(noise_floor(np.sin(np.arange(20_000) / 50) + 0.1 * rng.standard_normal(20_000)), 3)
    0.1
    """
    if values.size < 8:
        raise ValueError("a noise floor needs at least 8 values")
    return max(_trimmed(_without_hum(np.diff(values, 3))), float(resolution(values) / 12.0**0.5))


def _without_hum(differences: Array) -> Array:
    """Third differences without the lines of a sinusoid that stand out of their spectrum beyond doubt."""
    n = differences.size
    if n < 500:
        return differences
    left = differences.copy()
    for _ in range(HUMS):
        # What stems from motion is cut, so that it makes no lines of its own.
        most = 4.0 * 20.0**0.5 * _trimmed(left)
        calm = np.clip(left, -most, most)
        power = np.abs(np.fft.rfft(calm, 4 * n)) ** 2
        first = int(SLOWEST_HUM * 4 * n)
        k = first + int(np.argmax(power[first:]))
        around = np.delete(
            power[max(first, k - 800) : k + 800],
            slice(k - max(first, k - 800) - 8, k - max(first, k - 800) + 8),
        )
        if power[k] < LINE * np.mean(around):
            break
        phase = 2.0 * np.pi * k / (4 * n) * np.arange(n)
        waves = np.column_stack([np.sin(phase), np.cos(phase)])
        left -= waves @ (waves.T @ calm * (2.0 / n))
    return left


def _trimmed(differences: Array) -> float:
    """Standard deviation of the noise behind third differences, from the smaller of them."""
    from scipy.stats import norm

    sizes = np.sort(np.abs(differences))
    kept = sizes[: max(4, round(KEPT * sizes.size))]
    cut = norm.ppf(0.5 + KEPT / 2.0)
    shrink = 1.0 - 2.0 * cut * norm.pdf(cut) / KEPT  # variance of a normal cut at that quantile
    return float(np.sqrt(np.mean(kept**2) / shrink / 20.0))


def resolution(values: Array) -> float:
    """Smallest step between the values of a channel; 0 for a channel that never changes.

    A channel cannot be known better than its rounding, whose error is uniform.  Steps as small as the
    rounding of a conversion of units are none.

    >>> resolution(np.array([0.1, 0.3, 0.1 + 0.2]))
    0.19999999999999998
    """
    steps = np.diff(np.unique(values))
    steps = steps[steps > ROUNDED * np.abs(values).max(initial=0.0)]
    return float(np.min(steps)) if steps.size else 0.0


def in_steps(values: Array, of: Array) -> Array:
    """Values that lie between those `of` a channel, in the steps of its sensor: others would look like those
    of a finer one.

    >>> in_steps(np.array([0.26, 0.44]), np.array([0.1, 0.3, 0.5])).round(3).tolist()
    [0.3, 0.5]
    """
    step = resolution(of)
    return of[0] + step * np.rint((values - of[0]) / step) if step else values


def noise_of(recordings: list[Array]) -> float | None:
    """Noise floor of a channel over several recordings, weighted by their lengths; None for none."""
    usable = [r for r in recordings if r.size >= 8]
    if not usable:
        return None
    variances = [noise_floor(r) ** 2 for r in usable]
    return float(np.sqrt(np.average(variances, weights=[r.size for r in usable])))


def is_coloured(stretches: Sequence[Array]) -> bool:
    """Whether noise has a memory: its differences over STRIDE rows exceed those over one, for certain."""
    near = [np.diff(s, 3) for s in stretches]
    far = [
        s[3 * STRIDE :] - 3 * s[2 * STRIDE : -STRIDE] + 3 * s[STRIDE : -2 * STRIDE] - s[: -3 * STRIDE]
        for s in stretches
    ]
    count = sum(len(f) for f in far)
    if count < 100:
        return False
    one, several = _trimmed(np.concatenate(near)), _trimmed(np.concatenate(far))
    # Where the channel stands still, or its quantum hides the noise, both are 0, which is no colour.
    return bool(one > 0.0 and several / one > 1.0 + LEAST_COLOUR + SURE * (SCATTER / count) ** 0.5)
