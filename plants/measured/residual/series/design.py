"""The columns that a residual is regressed on: indicators of bins, and the waves of a hum."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plants.measured.residual.series.bins import Bins
from plants.measured.residual.series.joined import Joined
from plants.measured.residual.series.remainder import Array


@dataclass(frozen=True)
class Design:
    """Columns (k, n) less their mean over the rows, since a constant is no dependence; overlap (k, k):
    their products; where: which columns belong to a variable."""

    columns: NDArray[np.float32]
    overlap: Array
    where: dict[str, list[int]]

    def sums(self, series: Array) -> Array:
        """Products of the columns with a series (n,)."""
        found: Array = (self.columns @ series.astype(np.float32)).astype(np.float64)
        return found

    def with_waves(self, name: str, waves: Array) -> "Design":
        """With the waves (w, n) of a sinusoid added under a name."""
        more = waves.astype(np.float32)
        across = (self.columns @ more.T).astype(np.float64)
        overlap = np.block([[self.overlap, across], [across.T, waves @ waves.T]])
        added = list(range(len(self.columns), len(self.columns) + len(waves)))
        return Design(np.concatenate([self.columns, more]), overlap, {**self.where, name: added})


def design_of(joined: Joined, bins: Sequence[Bins]) -> Design:
    """Indicators of all bins, one variable after the other."""
    from scipy.sparse import csr_array

    ends = np.cumsum([0, *(len(b.centre) for b in bins)])
    rows = [np.where(b.label >= 0, b.label + first, -1) for b, first in zip(bins, ends[:-1], strict=True)]
    row, at = np.concatenate(rows), np.tile(np.arange(len(joined.value)), len(bins))
    known = row >= 0
    entries = (np.ones(np.count_nonzero(known), dtype=np.float32), (row[known], at[known]))
    indicator = csr_array(entries, shape=(int(ends[-1]), len(joined.value)))
    counts = indicator.sum(axis=1).astype(np.float64)
    overlap = (indicator @ indicator.T).toarray() - np.outer(counts, counts) / joined.rows
    columns = indicator.toarray()
    columns -= np.outer(counts / joined.rows, joined.inside).astype(np.float32)
    where = {b.variable: list(range(a, z)) for b, (a, z) in zip(bins, pairwise(ends), strict=True)}
    return Design(columns, overlap, where)
