"""Figures of the tests: what was found, with the bounds that noise alone stays within."""

from dataclasses import dataclass

import numpy as np

from plants.measured.residual.battery import Battery
from plants.measured.residual.series.bins import Bins
from plants.measured.residual.series.remainder import Array

SHOWN = 0.01
"""Probability that noise alone leaves the bounds of a curve anywhere."""


@dataclass(frozen=True)
class BinnedCurve:
    """centre: bins in the unit of the variable, lags [s] or frequencies [Hz]; mean: what was found
    there; low, high: bounds that noise alone stays within everywhere with probability 1 - SHOWN."""

    centre: Array
    mean: Array
    low: Array
    high: Array


def curves_of(battery: Battery) -> dict[str, BinnedCurve]:
    """Conditional means by variable; ``autocorrelation``; ``spectrum``; ``correlation with`` each input."""
    found = {b.variable: _conditional(battery, b) for b in battery.bins if b.variable != "time"}
    found["autocorrelation"] = _autocorrelation(battery)
    found["spectrum"] = _spectrum(battery)
    for c in battery.correlations:
        bound = np.full(len(c.lag), _normal(len(c.lag)) * c.deviation)
        found[f"correlation with {c.variable}"] = BinnedCurve(c.lag, c.value, -bound, bound)
    return found


def _normal(many: int) -> float:
    from scipy.stats import norm

    return float(norm.isf(SHOWN / 2.0 / many))


def _conditional(battery: Battery, bins: Bins) -> BinnedCurve:
    """Means in the channel's unit, the mean of all rows included; the bounds are about that."""
    j = battery.design.where[bins.variable]
    counts = np.bincount(bins.label[bins.label >= 0], minlength=len(bins.centre))
    mean = battery.joined.mean
    found = mean + battery.sums.sums[j] / counts
    bound = _normal(len(j)) * np.sqrt(np.diag(battery.sums.covariance)[j]) / counts
    return BinnedCurve(bins.centre, found, mean - bound, mean + bound)


def _autocorrelation(battery: Battery) -> BinnedCurve:
    """Bounds are those of white noise: outside them the residual is coloured, which noise may be."""
    value = battery.autocorrelation
    lags = np.arange(1.0, len(value) + 1.0, dtype=np.float64) * battery.joined.dt
    bound = np.full(len(value), _normal(len(value)) / battery.joined.rows**0.5)
    return BinnedCurve(lags, value, -bound, bound)


def _spectrum(battery: Battery) -> BinnedCurve:
    """Power density [unit squared per Hz]; high: what noise of the level around stays below."""
    s = battery.spectrum
    density = 2.0 * battery.joined.dt
    return BinnedCurve(s.frequency, density * s.value, np.zeros(len(s.value)), density * s.bound(SHOWN))
