"""Paired intervals of differences, and ranks no finer than they support.

The plants are the sample: all controllers meet the same ones, so that the differences between two of them on
each plant are independent draws.  Their mean gets a bootstrap interval (BCa: Efron, Better bootstrap
confidence intervals, J. Am. Stat. Assoc. 82 (1987) 171, doi 10.1080/01621459.1987.10478410;
``scipy.stats.bootstrap``).  A controller is ahead of another where the interval of their difference lies
below zero, the level of each raised so that all pairs hold together with 95 % (Bonferroni); its rank is then
known to lie between 1 + the number ahead of it and the number of all less those behind it (Mogstad, Romano,
Shaikh & Wilhelm, Inference for ranks with applications to mobility across neighbourhoods and academic
achievement across countries, Rev. Econ. Stud. 91 (2024) 476, doi 10.1093/restud/rdad006).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEVEL = 0.95
"""Confidence of an interval, and of all ranks of one table together."""

RESAMPLES = 4999

FEWEST = 10
"""Plants below which no interval is given: a bootstrap of a handful is too sure of itself."""


@dataclass(frozen=True)
class ConfidenceInterval:
    """A mean and its confidence interval."""

    mean: float
    low: float
    high: float

    @property
    def sign(self) -> int:
        """-1 below zero, 1 above it, 0 where zero is inside."""
        return -1 if self.high < 0.0 else 1 if self.low > 0.0 else 0


def intervals(differences: Array, level: float = LEVEL, seed: int = 0) -> list[ConfidenceInterval]:
    """Mean of each row of differences, (pairs, plants), and its interval.

    The same value on every plant leaves an interval of no width; fewer than `FEWEST` plants an endless one.
    """
    from scipy.stats import bootstrap

    d = np.asarray(differences, float)
    mean = d.mean(axis=1)
    low, high = mean.copy(), mean.copy()
    if d.shape[1] < FEWEST:
        low, high = np.full_like(mean, -np.inf), np.full_like(mean, np.inf)
    varied = np.flatnonzero(np.ptp(d, axis=1) > 1e-12 * np.maximum(np.abs(mean), 1e-12))
    if d.shape[1] >= FEWEST and varied.size:
        found = bootstrap(
            (d[varied],), np.mean, n_resamples=RESAMPLES, batch=250, confidence_level=level, method="BCa",
            axis=-1, vectorized=True, rng=np.random.default_rng(seed),
        ).confidence_interval  # fmt: skip
        low[varied], high[varied] = found.low, found.high
    return [ConfidenceInterval(float(m), float(a), float(b)) for m, a, b in zip(mean, low, high, strict=True)]


def ranks(values: Mapping[str, Array], level: float = LEVEL, seed: int = 0) -> dict[str, tuple[int, int]]:
    """Best and worst rank of each of some controllers, 1 being the least mean, that the pairs support
    together at a level; `values`: (plants,) of each.

    >>> quick = np.arange(20.0)
    >>> ranks({"slow": quick + 5.0, "quick": quick, "as quick": quick[::-1]})
    {'slow': (2, 3), 'quick': (1, 2), 'as quick': (1, 3)}
    """
    names = list(values)
    pairs = list(combinations(names, 2))
    ahead, behind = dict.fromkeys(names, 0), dict.fromkeys(names, 0)
    if pairs:
        each = 1.0 - (1.0 - level) / len(pairs)
        found = intervals(np.array([values[a] - values[b] for a, b in pairs]), each, seed)
        for (a, b), interval in zip(pairs, found, strict=True):
            if interval.sign:
                first, second = (a, b) if interval.sign < 0 else (b, a)
                behind[first] += 1
                ahead[second] += 1
    return {n: (1 + ahead[n], len(names) - behind[n]) for n in names}
