"""Whether the size of a remainder changes: over what it is plotted against, over time, in bursts."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plants.measured.residual.conditional import sums_of
from plants.measured.residual.evidence import Evidence
from plants.measured.residual.joined import Joined
from plants.measured.residual.remainder import Array

BURST = 0.5
"""Length of a burst of noise [s]."""

EDGE = 5
"""Rows at the ends of a recording that are not looked at."""

SHUFFLES = 60
FREEDOM = 1000.0
"""Degrees of freedom of the variance of the sizes: there are as many as rows."""

LOCAL, LOUD = 10, 2.5
"""Rows over which the remainder is loud when its power is this many times the usual."""

ROUGH = 0.12
"""Correlation of neighbours up to which loud moments are noise: 0.07 at most for noise of changing
size, 0.2 and more for what dead time, inertia and the like leave."""

BASELINE = 1.0
"""What lasts longer than this [s] is a mean that moves, and no part of the size."""


@dataclass(frozen=True)
class Sizes:
    """Sizes of the whitened remainder, (n,), less their mean, which is 1 before; variance of a size."""

    value: Array
    variance: float


def sizes_of(joined: Joined, series: Array, spectrum: Array) -> Sizes:
    """Absolute values of a remainder (n,), whitened with the spectrum of its noise, over their mean.

    Absolute values, as Brown and Forsythe take them, since squares would be ruled
    by a few outliers.  Whitening makes them independent where noise is stationary.
    """
    from scipy.ndimage import uniform_filter1d

    white = joined.filtered(series, 1.0 / np.sqrt(spectrum))
    white = white - uniform_filter1d(white, max(3, round(BASELINE / joined.dt)))
    there = joined.inner(EDGE)
    size = np.where(there, np.abs(white), 0.0)
    size = np.where(there, size / float(np.mean(size[there])) - 1.0, 0.0)
    return Sizes(size, float(np.mean(size[there] ** 2)))


def size_tests(
    joined: Joined, sizes: Sizes, columns: NDArray[np.float32], where: Sequence[Sequence[int]]
) -> list[Evidence]:
    """Whether the mean size differs between the bins of each variable, given by their columns.

    The power of a test is the mean square of the relative change of size.
    """
    sums = sums_of(joined, sizes.value, columns, sizes.variance)
    return [sums.test(w, FREEDOM) for w in where]


def burst_test(joined: Joined, sizes: Sizes, seed: int) -> Evidence:
    """Whether the size changes between stretches of BURST, against the same sizes in random order."""
    rows = max(4, round(BURST / joined.dt))
    inside = sizes.value[joined.inside]
    stretches = len(inside) // rows
    rng = np.random.default_rng(seed)

    def spread(values: Array) -> float:
        return float(np.mean(values[: stretches * rows].reshape(stretches, rows).mean(axis=1) ** 2))

    found = spread(inside)
    drawn = np.array([spread(rng.permutation(inside)) for _ in range(SHUFFLES)])
    mean, variance = float(drawn.mean()), float(drawn.var(ddof=1))
    shape = mean**2 / max(variance, 1e-300)
    return Evidence(found / mean, "gamma", (shape, 0.0, 1.0 / shape), 1.0, found - mean)


def is_rough(joined: Joined, series: Array, spectrum: Array) -> bool:
    """Whether a remainder (n,) is noise where it is loud: the whitened neighbours are unrelated there.

    Transients that no test caught make the remainder large too, but smooth.
    """
    from scipy.ndimage import uniform_filter1d

    white = np.where(joined.inner(EDGE), joined.filtered(series, 1.0 / np.sqrt(spectrum)), 0.0)
    local = uniform_filter1d(white**2, LOCAL)
    loud = local > LOUD * float(np.median(local[joined.inside]))
    power = float(np.sum(white[loud] ** 2))
    related = [abs(float(np.sum((white[:-k] * white[k:])[loud[k:]]))) for k in (1, 2, 3)]
    return power > 0.0 and max(related) < ROUGH * power
