"""Conditional means of a residual over bins, and what stationary noise of a given spectrum makes of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plants.measured.residual.checks.evidence import NOTHING, Evidence
from plants.measured.residual.series.design import Design
from plants.measured.residual.series.joined import Joined
from plants.measured.residual.series.remainder import Array

FAST = 12.5
"""Frequency [Hz] above which the noise counts as flat where its effect on sums over bins is concerned."""

SINGULAR = 1e-6
"""Directions of the columns with less than this part of the largest variance do not count."""


@dataclass(frozen=True)
class Sums:
    """Sums of a residual over bins of many variables.

    sums: (k,); overlap: (k, k), rows that two bins share; covariance: (k, k) of the sums for noise
    alone; rows: of the residual.
    """

    sums: Array
    overlap: Array
    covariance: Array
    rows: int

    def without(self, columns: Sequence[int]) -> "Sums":
        """What is left of the sums when these columns have been regressed out of the residual."""
        if not len(columns):
            return self
        j = np.asarray(columns)
        share = self.overlap[:, j] @ np.linalg.pinv(
            self.overlap[np.ix_(j, j)], rcond=SINGULAR, hermitian=True
        )
        cross = share @ self.covariance[j]
        return Sums(
            self.sums - share @ self.sums[j],
            self.overlap - share @ self.overlap[j],
            self.covariance - cross - cross.T + share @ self.covariance[np.ix_(j, j)] @ share.T,
            self.rows,
        )

    def test(self, columns: Sequence[int], freedom: float) -> Evidence:
        """Whether the sums over these columns are more than noise makes them; `freedom` is how
        many degrees of freedom the spectrum was estimated with."""
        j = np.asarray(columns)
        b, covariance, overlap = self.sums[j], self.covariance[np.ix_(j, j)], self.overlap[np.ix_(j, j)]
        values, vectors = np.linalg.eigh(covariance)
        kept = values > SINGULAR * np.max(values)
        rank = int(np.count_nonzero(kept))
        if rank == 0:
            return NOTHING
        statistic = float(np.sum((vectors[:, kept].T @ b) ** 2 / values[kept])) / rank
        inverse = np.linalg.pinv(overlap, rcond=SINGULAR, hermitian=True)
        power = float(b @ inverse @ b - np.sum(inverse * covariance)) / self.rows
        return Evidence(statistic, "f", (rank, freedom), 1.0, power)

    def coefficients(self, columns: Sequence[int]) -> Array:
        """Least-squares coefficients of the residual over these columns."""
        j = np.asarray(columns)
        found: Array = (
            np.linalg.pinv(self.overlap[np.ix_(j, j)], rcond=SINGULAR, hermitian=True) @ self.sums[j]
        )
        return found


def sums_of(joined: Joined, series: Array, design: Design, spectrum: Array) -> Sums:
    """Sums of a series (n,) over the columns of a design, with their covariance for noise of a spectrum.

    The covariance of two sums is the product of the columns' spectra weighted with the
    noise's: right for any stationary noise, white or coloured.  Above FAST, where
    indicators of bins have little power and ever less, the noise counts as flat.
    """
    slow = joined.frequencies < FAST
    flat = 0.0
    if not np.all(slow):
        weight = joined.frequencies[~slow] ** -2.0
        flat = float(np.sum(weight * spectrum[~slow]) / np.sum(weight))
    transforms = joined.transform(design.columns)[:, slow]
    both = np.concatenate([transforms.real, transforms.imag], axis=1)
    extra = ((spectrum[slow] - flat) * joined.counts[slow] / joined.length).astype(np.float32)
    covariance = (both * np.tile(extra, 2)) @ both.T + flat * design.overlap
    return Sums(design.sums(series), design.overlap, covariance, joined.rows)


def white_sums(joined: Joined, series: Array, design: Design, variance: float) -> Sums:
    """The same for white noise of a variance."""
    return Sums(design.sums(series), design.overlap, variance * design.overlap, joined.rows)
