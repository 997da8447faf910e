"""A residual without its sensor noise: what of it was there."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SPLINE = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16.0
"""Weights of the cubic B-spline that smooths from one scale to the next."""

MEDIAN = 0.6745
"""Median of the size of Gaussian noise of standard deviation 1."""


def denoised(series: Array, noise: float) -> Array:
    """A series (n,) without white noise, its slow part and its events kept.

    noise: least standard deviation [its unit]; it is taken larger where the finest details say so, as of a
    sensor that is quieter at rest (their median, Donoho & Johnstone).

    The stationary wavelet transform of the cubic B-spline ("starlet": Starck, Fadili & Murtagh, IEEE Trans.
    Image Process. 16 (2007) 297): the details of each scale that noise alone would exceed anywhere with a
    small probability (the universal threshold of Donoho & Johnstone, Biometrika 81 (1994) 425) are kept,
    the others are noise.

    >>> noise = np.random.default_rng(0).normal(0.0, 1.0, 3000)
    >>> event = np.where(np.abs(np.arange(3000) - 1000) < 40, 8.0, 0.0)
    >>> float(np.std(denoised(noise, 1.0))) < 0.1, float(denoised(event + noise, 1.0)[1000]) > 7.0
    (True, True)
    """
    from scipy.ndimage import convolve1d

    n = len(series)
    if n < 2 * len(SPLINE):
        return series
    scales = int(np.log2(n / len(SPLINE)))
    universal = np.sqrt(2.0 * np.log(n))
    impulse = np.zeros(1 + 2 * 2 ** (scales + 2))
    impulse[len(impulse) // 2] = 1.0
    kept, smooth = np.zeros(n), series
    for scale in range(scales):
        weights = np.zeros(4 * 2**scale + 1)
        weights[:: 2**scale] = SPLINE
        smoother = convolve1d(smooth, weights, mode="mirror")
        wider = convolve1d(impulse, weights, mode="constant")
        detail, spread = smooth - smoother, float(np.linalg.norm(impulse - wider))
        if scale == 0:
            noise = max(noise, float(np.median(np.abs(detail))) / (MEDIAN * spread))
        kept += np.where(np.abs(detail) > universal * noise * spread, detail, 0.0)
        smooth, impulse = smoother, wider
    return kept + smooth
