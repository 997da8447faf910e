"""How sure the errors of free runs are."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.begin import measured
from plants.measured.fitting.fit import CHANNELS
from plants.measured.fitting.free_run import FreeRun, squares

Array = NDArray[np.float64]
BOOTSTRAP = 400
BLOCK = 2.0
"""Blocks of time [s] that are drawn for intervals of errors."""


def intervals(runs: Sequence[FreeRun], before: bool = False) -> dict[str, tuple[float, float] | None]:
    """Intervals at 95 % of the errors, by bootstrap over blocks of two seconds."""
    found: dict[str, tuple[float, float] | None] = {}
    for channel in CHANNELS:
        logged = [r for r in runs if r.role == "validate" and measured(r.recording, channel) is not None]
        times = [float(np.median(np.diff(r.recording.time))) for r in logged]
        found[channel] = interval(squares(runs, channel, before), times) if logged else None
    return found


def interval(squared: Sequence[Array], times: Sequence[float]) -> tuple[float, float]:
    """Interval at 95 % of the root mean square of errors whose squares are given, a series (n,) a recording,
    logged every so many seconds: by bootstrap over blocks of two seconds (Künsch, Ann. Statist. 17, 1989).

    >>> interval([np.ones(100)], [0.1])
    (1.0, 1.0)
    """
    pieces: list[Array] = []
    for series, dt in zip(squared, times, strict=True):
        rows = max(1, round(BLOCK / dt))
        pieces += np.array_split(series, max(1, len(series) // rows))
    sums, sizes = np.array([p.sum() for p in pieces]), np.array([p.size for p in pieces])
    draws = np.random.default_rng(0).integers(len(pieces), size=(BOOTSTRAP, len(pieces)))
    low, high = np.quantile(np.sqrt(sums[draws].sum(axis=1) / sizes[draws].sum(axis=1)), (0.025, 0.975))
    return float(low), float(high)
