"""Blocks of time that count as one each, and whether an error falls over them for certain."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
BLOCK, LEAST_BLOCKS = 10.0, 12
"""Length [s] of the blocks that are left out in turn, long against every memory but the slowest; but short
recordings make at least so many: were a fold one block or two, a fit to the others would be judged on nothing
but a range that it never met."""

CERTAIN = 0.9
"""Confidence that an error falls."""


def judged_blocks(times: Sequence[Array]) -> NDArray[np.intp]:
    """Number of the block that each row of recordings falls in, of those that an error is judged over; times
    [s] of their rows, (n,) each.

    Each counts as much as any, so that what is left at the end of a recording, below half a block, is
    part of the last one.
    """
    duration = sum(float(t[-1] - t[0]) for t in times)
    return blocks(times, min(BLOCK, duration / LEAST_BLOCKS), least=0.5)


def blocks(times: Sequence[Array], length: float, least: float = 0.0) -> NDArray[np.intp]:
    """Number of the block of a length [s] that each row falls in; none spans two recordings.

    least: share of a block that what is left at the end of a recording needs to be one of its own.
    """
    numbers = []
    for i, time in enumerate(times):
        since = time - time[0]
        last = max(np.floor(float(since[-1]) / length + 1.0 - least), 1.0) - 1.0
        numbers.append(1e6 * i + np.minimum(np.floor(since / length), last))
    return np.unique(np.concatenate(numbers), return_inverse=True)[1]


def lower(before: Array, after: Array, of: NDArray[np.intp], tests: int = 1) -> bool:
    """Whether residuals (rows,) are smaller than others for certain: in total over all recordings, and the
    lower bound of that total (Student's, one-sided) from its scatter over blocks is above zero, or that of
    its share in each block.

    Where a fit to the other rows runs away on one block, the scatter of the gains themselves is that block's;
    the mean of the gains over their blocks' sums is not.  of: number of the block of each row; tests: how
    many of one kind are made, by which the confidence of each is the higher (Bonferroni).
    """
    from scipy.stats import t

    gain = np.asarray(np.bincount(of, before**2 - after**2), float)
    size = np.asarray(np.bincount(of, before**2 + after**2), float)
    n = len(gain)
    if n < 2:
        return float(gain.sum()) > 0.0
    share = gain / np.maximum(size, 1e-300)

    def certain(values: Array) -> bool:
        bound = float(t.ppf(1.0 - (1.0 - CERTAIN) / tests, n - 1)) * float(np.std(values, ddof=1)) * n**0.5
        return bool(values.sum() > bound)

    return certain(gain) or (float(gain.sum()) > 0.0 and certain(share))
