"""When a channel is renewed that the logger holds in between."""

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.recording import HELD
from plants.measured.fitting.noise import resolution

Array = NDArray[np.float64]
JUMPS = 2.5
"""Steps of the sensor by which half of the new values differ from the held ones: a coarse sensor that moves
slowly differs by one."""

SHORTEST_GAPS, TICKS, IN_TIME = 0.05, 12, 0.95
"""Quantile of the gaps between changes that a clock's period is first taken from, gaps that are needed, and
share of them that has to be whole numbers of periods."""


def renewals(values: Array) -> NDArray[np.bool_] | None:
    """Rows at which a channel was renewed, None for one that is renewed in every row.

    >>> int(renewals(np.repeat(np.random.default_rng(0).normal(size=50), 4)).sum())
    50
    """
    changed = np.append(True, np.diff(values) != 0.0)
    at = np.flatnonzero(changed)
    if len(at) < 8 or changed.mean() > HELD:
        return None
    period = int(np.median(np.diff(at)))
    jumps = np.abs(np.diff(values[at]))
    if period < 2 or np.median(jumps) < JUMPS * resolution(values):
        period = clock(at)
    if period == 0:
        return None
    # A sensor at rest is renewed too, with the value it had.
    fresh = changed.copy()
    fresh[at[-1] :: period] = True
    for first, gap in zip(at[:-1], np.diff(at), strict=True):
        times = max(round(gap / period), 1)  # a clock of its own is now and then a row early or late
        fresh[first + np.arange(times) * gap // times] = True
    return fresh


def interval(times: Array) -> float:
    """Mean interval [s] between renewals at some times [s], but for pauses of the log.  The median is a whole
    number of rows, which a clock of the sensor's own is not.

    >>> round(interval(np.array([0.0, 0.16, 0.33, 0.5, 0.66, 7.0, 7.16, 7.33])), 4)
    0.165
    """
    gaps = np.diff(times)
    usual = np.median(gaps)
    return float(np.mean(gaps[np.abs(gaps - usual) <= 0.5 * usual]))


def clock(rows: NDArray[np.intp]) -> int:
    """Rows between renewals of a channel whose value changes at some rows: 0 unless these keep to a clock.

    A coarse channel that is held changes by one step, as one does that moves slowly; but its changes are
    whole numbers of periods apart.

    >>> rng = np.random.default_rng(0)
    >>> clock(40 * np.unique(rng.integers(0, 300, 60))), clock(np.unique(rng.integers(0, 12_000, 60)))
    (40, 0)
    """
    gaps = np.diff(rows).astype(float)
    period = float(np.quantile(gaps, SHORTEST_GAPS))
    if len(gaps) < TICKS or period < 3.0:
        return 0
    for reach in (2.0, 4.0, 8.0):  # the more periods a gap holds, the better it tells how long one is
        count = np.maximum(np.rint(gaps / period), 1.0)
        near = count <= reach
        period = float(gaps[near].sum() / count[near].sum()) if near.any() else period
    off = np.abs(gaps - np.maximum(np.rint(gaps / period), 1.0) * period)
    return round(period) if np.mean(off < 0.15 * period + 0.5) >= IN_TIME else 0
