"""Conditional means of a remainder over bins, and what stationary noise of a given spectrum makes of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plants.measured.residual.bins import Bins
from plants.measured.residual.evidence import NOTHING, Evidence
from plants.measured.residual.joined import Joined
from plants.measured.residual.remainder import Array

SINGULAR = 1e-6
"""Directions of the columns with less than this part of the largest variance do not count."""


@dataclass(frozen=True)
class Sums:
    """Sums of a remainder over bins of many variables.

    sums: (k,); overlap: (k, k), rows that two bins share; covariance: (k, k) of the sums for noise
    alone; rows: of the remainder.
    """

    sums: Array
    overlap: Array
    covariance: Array
    rows: int

    def without(self, columns: Sequence[int]) -> "Sums":
        """What is left of the sums when these columns have been regressed out of the remainder."""
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
        """Least-squares coefficients of the remainder over these columns."""
        j = np.asarray(columns)
        found: Array = (
            np.linalg.pinv(self.overlap[np.ix_(j, j)], rcond=SINGULAR, hermitian=True) @ self.sums[j]
        )
        return found


def sums_of(joined: Joined, series: Array, columns: NDArray[np.float32], spectrum: Array | float) -> Sums:
    """Sums of a series (n,) over columns (k, n), with their covariance for noise of a spectrum.

    The covariance of two sums is the overlap of the columns' spectra weighted
    with the noise's: right for any stationary noise, white or coloured.
    """
    overlap = (columns @ columns.T).astype(float)
    sums = columns.astype(float) @ series
    if isinstance(spectrum, float):
        return Sums(sums, overlap, spectrum * overlap, joined.rows)
    weight = spectrum * joined.counts
    shaped = joined.transform(columns) * np.sqrt(weight).astype(np.float32)
    both = np.concatenate([shaped.real, shaped.imag], axis=1)
    return Sums(sums, overlap, (both @ both.T).astype(float) / joined.length, joined.rows)


def centred(joined: Joined, columns: NDArray[np.float32]) -> NDArray[np.float32]:
    """Columns with their mean over the rows taken off: a constant is no dependence."""
    means = columns[:, joined.inside].mean(axis=1, dtype=float).astype(np.float32)
    found: NDArray[np.float32] = columns - means[:, None] * joined.inside.astype(np.float32)
    return found


def stacked(joined: Joined, bins: Sequence[Bins]) -> tuple[NDArray[np.float32], list[list[int]]]:
    """Columns of all bins one under the other, centred, and which belong to each."""
    blocks = [b.columns for b in bins]
    ends = np.cumsum([0, *(len(b) for b in blocks)])
    where = [list(range(a, b)) for a, b in pairwise(ends)]
    return centred(joined, np.concatenate(blocks)), where
