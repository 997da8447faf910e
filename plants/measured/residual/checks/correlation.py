"""Cross-correlation of a residual with the changes of its inputs."""

from dataclasses import dataclass

import numpy as np

from plants.measured.residual.checks.evidence import Evidence
from plants.measured.residual.series.joined import Joined
from plants.measured.residual.series.remainder import Array

BEFORE, AFTER = 0.5, 3.0
"""Lags of the residual behind the input [s]: some before it, where nothing may be found."""

FEWEST = 12.0
"""Changes, counted by their squares, from which a correlation means anything: one or two jumps show
only what the noise happened to be there."""

AGREED = 3.0
"""And only if the changes agree on it by this many of their own standard deviations."""

HIGH = 5.0
"""Lags with more than this many standard deviations count towards what is explained."""


@dataclass(frozen=True)
class Correlation:
    """Correlation of a residual with the changes of a variable, (k,) at lags [s].

    deviation: standard deviation of each value for noise alone; agreement: value over its standard
    deviation as the changes' own products scatter, which few large ones or loud moments do not
    impress; sharpness: 1 where the changes are white, less where they last.
    """

    variable: str
    lag: Array
    value: Array
    deviation: float
    agreement: Array
    sharpness: float

    def evidence(self, power: float) -> Evidence:
        """Whether the largest value is more than noise makes of all lags; `power` is the mean
        square of the residual."""
        z = np.abs(self.value) / self.deviation
        high = (z > HIGH) & (np.abs(self.agreement) > AGREED)
        explained = float(np.sum(self.value[high] ** 2 - self.deviation**2)) * self.sharpness
        return Evidence(float(np.max(z)), "norm", (), float(len(z)), power * min(1.0, explained))


def correlation(joined: Joined, series: Array, variable: str, spectrum: Array) -> Correlation | None:
    """Correlation of a series (n,) with the changes of a variable; None where it has FEWEST or fewer.

    Differences make steps and random walks white, as Box and Jenkins prescribe for the
    input.  The residual keeps its colour, and the deviation accounts for it: the
    variance is the sum over the product of the two spectra, the same at every lag.
    """
    from scipy.fft import irfft

    changes = np.diff(joined.variables[variable], prepend=np.nan)
    changes = np.where(np.isfinite(changes), changes, 0.0)
    if np.sum(changes**2) ** 2 <= FEWEST * np.sum(changes**4):
        return None
    moved = joined.transform(changes)
    products: Array = irfft(joined.transform(series) * np.conj(moved), joined.length)
    lasting: Array = irfft(np.abs(moved) ** 2, joined.length)
    lags = np.arange(-round(BEFORE / joined.dt), round(AFTER / joined.dt) + 1)
    seconds = (joined.dt * lags).astype(np.float64)
    scattered: Array = irfft(
        joined.transform(series**2) * np.conj(joined.transform(changes**2)), joined.length
    )
    agreement = products[lags] / np.sqrt(np.maximum(scattered[lags], 1e-300))
    scale = float(np.sqrt(lasting[0] * np.sum(series**2))) or 1.0
    variance = float(np.sum(joined.counts * np.abs(moved) ** 2 * spectrum)) / joined.length
    sharpness = 1.0 / float(np.sum((lasting[lags] / lasting[0]) ** 2))
    deviation = float(np.sqrt(max(variance, 1e-300))) / scale
    return Correlation(variable, seconds, products[lags] / scale, deviation, agreement, sharpness)
