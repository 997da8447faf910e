"""Whether the size of a residual changes: over what it is plotted against, over time, in bursts."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plants.measured.residual.checks.conditional import white_sums
from plants.measured.residual.checks.evidence import NOTHING, Evidence
from plants.measured.residual.series.design import Design
from plants.measured.residual.series.joined import Joined
from plants.measured.residual.series.remainder import Array

BURST = 0.5
"""Length of a burst of noise [s]."""

EDGE = 5
"""Rows at the ends of a recording that are not looked at."""

FREEDOM = 1000.0
"""Degrees of freedom of the variance of the sizes: there are as many as rows."""

LOCAL, LOUD = 10, 2.5
"""Rows over which the residual is loud when its power is this many times the usual."""

ROUGH = 0.12
"""Correlation of neighbours up to which loud moments are noise: 0.07 at most for noise of changing
size, 0.2 and more for what dead time, inertia and the like leave."""

BASELINE = 1.0
"""What lasts longer than this [s] is a mean that moves, and no part of the size."""


@dataclass(frozen=True)
class Sizes:
    """Sizes of the whitened residual, (n,), less their mean, which is 1 before; variance of a size."""

    value: Array
    variance: float


def sizes_of(joined: Joined, series: Array, spectrum: Array) -> Sizes:
    """Absolute values of a residual (n,), whitened with the spectrum of its noise, over their mean.

    Absolute values, as Brown and Forsythe take them, since squares would be ruled
    by a few outliers.  Whitening makes them independent where noise is stationary.
    """
    from scipy.ndimage import uniform_filter1d

    white = joined.filtered(series, 1.0 / np.sqrt(spectrum))
    white = white - uniform_filter1d(white, max(3, round(BASELINE / joined.dt)))
    there = joined.inner(EDGE)
    size = np.where(there, np.abs(white), 0.0)
    usual = float(np.mean(size[there])) if np.any(there) else 0.0
    if usual == 0.0:
        return Sizes(size, 1.0)
    size = np.where(there, size / usual - 1.0, 0.0)
    return Sizes(size, float(np.mean(size[there] ** 2)))


def size_tests(joined: Joined, sizes: Sizes, design: Design, variables: Sequence[str]) -> dict[str, Evidence]:
    """Whether the mean size differs between the bins of each variable.

    The power of a test is the mean square of the relative change of size.
    """
    sums = white_sums(joined, sizes.value, design, sizes.variance)
    return {v: sums.test(design.where[v], FREEDOM) for v in variables}


def burst_test(joined: Joined, sizes: Sizes) -> Evidence:
    """Whether the size changes between stretches of BURST: the mean square of their mean sizes.

    Of independent sizes with variance v and excess kurtosis k, the square of the mean of m has the
    mean v / m and the variance (v / m)^2 (2 + k / m); over j stretches it is close to gamma.
    """
    m = max(4, round(BURST / joined.dt))
    inside = sizes.value[joined.inside]
    j = len(inside) // m
    variance = float(np.mean(inside**2))
    if variance == 0.0 or j == 0:
        return NOTHING
    means = inside[: j * m].reshape(j, m).mean(axis=1)
    found = float(np.mean(means**2)) * m / variance
    kurtosis = float(np.mean(inside**4)) / variance**2 - 3.0
    shape = j / (2.0 + kurtosis / m)
    return Evidence(found, "gamma", (shape, 0.0, 1.0 / shape), 1.0, (found - 1.0) * variance / m)


def evened(joined: Joined, series: Array, spectrum: Array) -> Array:
    """A residual (n,) over its local size where that is more than usual, from half a second around."""
    from scipy.ndimage import maximum_filter1d, uniform_filter1d

    white = joined.filtered(series, 1.0 / np.sqrt(spectrum))
    rows = max(4, round(BURST / joined.dt))
    local = maximum_filter1d(uniform_filter1d(white**2, LOCAL), rows)
    usual = float(np.median(local[joined.inside]))
    found: Array = series / np.sqrt(np.maximum(local / max(usual, 1e-300), 1.0))
    return found


def is_rough(joined: Joined, series: Array, spectrum: Array) -> bool:
    """Whether a residual (n,) is noise where it is loud: the whitened neighbours are unrelated there.

    Transients that no test caught make the residual large too, but smooth.
    """
    from scipy.ndimage import uniform_filter1d

    white = np.where(joined.inner(EDGE), joined.filtered(series, 1.0 / np.sqrt(spectrum)), 0.0)
    local = uniform_filter1d(white**2, LOCAL)
    loud = local > LOUD * float(np.median(local[joined.inside]))
    power = float(np.sum(white[loud] ** 2))
    related = [abs(float(np.sum((white[:-k] * white[k:])[loud[k:]]))) for k in (1, 2, 3)]
    return power > 0.0 and max(related) < ROUGH * power
