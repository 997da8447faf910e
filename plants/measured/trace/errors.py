"""How sure the errors of free runs are."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plants.measured.begin import measured
from plants.measured.fit import CHANNELS
from plants.measured.free_run import FreeRun, squares

Array = NDArray[np.float64]
BOOTSTRAP = 400
BLOCK = 2.0
"""Blocks of time [s] that are drawn for intervals of errors."""


def intervals(runs: Sequence[FreeRun], before: bool = False) -> dict[str, tuple[float, float] | None]:
    """Intervals at 95 % of the errors, by bootstrap over blocks of two seconds."""
    found: dict[str, tuple[float, float] | None] = {}
    for channel in CHANNELS:
        pieces = []
        logged = [r for r in runs if r.role == "validate" and measured(r.recording, channel) is not None]
        for run, squared in zip(logged, squares(runs, channel, before), strict=True):
            rows = max(1, round(BLOCK / float(np.median(np.diff(run.recording.time)))))
            pieces += np.array_split(squared, max(1, len(squared) // rows))
        if not pieces:
            found[channel] = None
            continue
        sums, sizes = np.array([p.sum() for p in pieces]), np.array([p.size for p in pieces])
        draws = np.random.default_rng(0).integers(len(pieces), size=(BOOTSTRAP, len(pieces)))
        low, high = np.quantile(np.sqrt(sums[draws].sum(axis=1) / sizes[draws].sum(axis=1)), (0.025, 0.975))
        found[channel] = (float(low), float(high))
    return found
