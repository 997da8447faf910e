"""Where estimates lie together: within their joint confidence region, along the axes of their correlation.

An interval of two standard errors holds one estimate at 95 % confidence.  That many estimates all lie at the
ends of theirs is less likely the more there are: with 26, a corner of the intervals is ten standard errors
off.  The joint region is the ball of squared distances, in standard errors along the principal axes, that a
chi-square variable of as many degrees of freedom exceeds no more often (Draper and Smith, Applied Regression
Analysis, 1998, section 5.4).  It is taken no smaller than what holds `AT_ENDS` of them at their ends at once:
up to that many, every corner of the intervals counts.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from design.robustness.intervals import Interval, StandardErrors
from plants.parameters.correlation import Pairs, matrix_of

Array = NDArray[np.float64]
AT_ENDS = 10
"""Estimates that may lie at the ends of their intervals at once however many there are: as many as a declared
wrist has."""


@dataclass(frozen=True, eq=False)
class ConfidenceRegion:
    """Which intervals of a box are of estimates, at (m,), and their half-widths in standard errors, counts
    (m,); correlation (m, m) of their errors."""

    at: NDArray[np.intp]
    counts: Array
    correlation: Array

    @classmethod
    def of(cls, intervals: Sequence[Interval], correlation: Pairs) -> "ConfidenceRegion":
        """That of the estimates among some intervals."""
        found = [(k, i.origin.count) for k, i in enumerate(intervals) if isinstance(i.origin, StandardErrors)]
        at = np.array([k for k, _ in found], np.intp)
        counts = np.array([count for _, count in found], float)
        return cls(at, counts, matrix_of(correlation, [intervals[k].name for k in at]))

    @cached_property
    def radius(self) -> float:
        """Of the region, in standard errors; at least as likely to hold all estimates as the widest interval
        is to hold one.

        >>> from design.robustness.intervals import Interval, StandardErrors
        >>> some = [Interval(f"p{k}", 0.0, 1.0, 2.0, "1", StandardErrors(2.0, "log")) for k in range(40)]
        >>> [round(ConfidenceRegion.of(some[:m], {}).radius, 2) for m in (1, 4, 20, 40)]
        [2.0, 4.0, 6.32, 7.5]
        """
        if not self.at.size:
            return 0.0
        widest, m = float(self.counts.max()), self.at.size
        joint = float(np.sqrt(chi2.ppf(chi2.cdf(widest**2, 1), m)))
        return max(joint, widest * float(np.sqrt(min(m, AT_ENDS))))

    def within(self, shares: Array) -> Array:
        """Places of a box, (intervals, ...), those of estimates drawn straight towards the middle into the
        region."""
        if self.at.size <= AT_ENDS:
            return shares
        counts = self.counts.reshape(-1, *[1] * (shares.ndim - 1))
        away = counts * (2.0 * shares[self.at] - 1.0)
        far = np.sqrt(np.sum(away * away, axis=0))
        nearer = np.minimum(1.0, self.radius / np.maximum(far, 1e-12))
        found = shares.copy()
        found[self.at] = 0.5 + (shares[self.at] - 0.5) * nearer
        return found

    @cached_property
    def _correlated(self) -> NDArray[np.intp]:
        """Which of the estimates have correlated errors."""
        return np.flatnonzero(np.abs(self.correlation - np.eye(self.at.size)).sum(axis=1))

    @property
    def tied(self) -> NDArray[np.intp]:
        """Which intervals are of estimates whose errors are correlated."""
        return self.at[self._correlated]

    @cached_property
    def _root(self) -> Array:
        """The symmetric square root of their correlation."""
        part = self.correlation[np.ix_(self._correlated, self._correlated)]
        sizes, vectors = np.linalg.eigh(part)
        return np.asarray((vectors * np.sqrt(np.maximum(sizes, 0.0))) @ vectors.T)

    def along_axes(self, shares: Array) -> Array:
        """How far estimates whose errors are correlated lie from the middle at places of a box, in
        half-widths of their intervals, (tied, ...)."""
        return np.asarray(np.tensordot(self._root, 2.0 * shares[self.tied] - 1.0, axes=1))
