"""Errors of free runs from the command, and how sure they are."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plants.measured.fit import CHANNELS
from plants.measured.problem import measured
from plants.measured.trace.result import Played

Array = NDArray[np.float64]
BOOTSTRAP = 400
BLOCK = 2.0
"""Blocks of time [s] that are drawn for intervals of errors."""


def squares(runs: Sequence[Played], channel: str, side: str, role: str = "validate") -> list[Array]:
    """Squared errors of the recordings of a role, one array for each."""
    name = ("pressure" if channel == "pressure_kPa" else "angle") + side
    used = [r for r in runs if r.role == role]
    pairs = [(getattr(r, name), measured(r.recording, channel), r.recording.judged) for r in used]
    return [(a - b)[rows] ** 2 for a, b, rows in pairs if a is not None and b is not None]


def free_run_errors(runs: Sequence[Played]) -> dict[str, float | None]:
    """Root-mean-square error of each channel [deg, kPa] over the runs that judge; None without any."""
    found = {c: squares(runs, c, "") for c in CHANNELS}
    return {c: float(np.sqrt(np.mean(np.concatenate(s)))) if s else None for c, s in found.items()}


def intervals(runs: Sequence[Played], side: str) -> dict[str, tuple[float, float] | None]:
    """Intervals at 95 % of the errors, by bootstrap over blocks of two seconds."""
    found: dict[str, tuple[float, float] | None] = {}
    for channel in CHANNELS:
        pieces = []
        logged = [r for r in runs if r.role == "validate" and measured(r.recording, channel) is not None]
        for run, squared in zip(logged, squares(runs, channel, side), strict=True):
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
