"""Regressors of the angle: what loops, curved branches and creep make of a pressure, linear in weights.

A model of nothing, but a close one: what it leaves is often within a few times the noise, so that small and
constant differences between recordings show.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.recording import Recording
from plants.measured.guess.rough_models import REACHES, extent, lagged, median_step, plays, smoothed

Array = NDArray[np.float64]
BENDS = (0.1, 0.2, 0.35, 0.5, 0.65, 0.8)
"""Shares of the range at which the outer branches may bend."""

LOOP_BENDS = (0.15, 0.35, 0.6)
"""Shares of the range at which what a play makes may bend."""

SLOW = (3.0, 10.0, 30.0)
"""Time constants of creep [s]."""

TINY = 1e-4
"""Singular values below this share of the largest are left out of a regression."""


@dataclass(frozen=True)
class Regressors:
    """For pressures from `low` to `high` [kPa] and a lag of the joint [s]."""

    low: float
    high: float
    lag: float

    @staticmethod
    def of(recordings: Sequence[Recording], lag: float) -> "Regressors":
        """For the range of the pressure of recordings."""
        return Regressors(*extent([smooth_pressure(r) for r in recordings]), lag)

    def over(self, recording: Recording) -> Array:
        """Values in each row, (rows, n); all plays begin in the middle of their gaps."""
        dt = median_step(recording)
        x = (smooth_pressure(recording) - self.low) / (self.high - self.low)
        played = plays(x, np.array(REACHES))
        bent = [np.maximum(x - b, 0.0) for b in BENDS]
        bent += [np.maximum(p - b, 0.0) for p in played.T[1::2] for b in LOOP_BENDS]
        late = [lagged(x, dt, tau, 0.0) for tau in SLOW]
        columns = np.column_stack([np.ones(len(x)), x, played, *bent, *late])
        return lagged(columns, dt, self.lag, 0.0)


def smooth_pressure(recording: Recording) -> Array:
    """The pressure of a recording, smoothed."""
    assert recording.pressure is not None
    return smoothed(recording.pressure)


def left_by(columns: Array, values: Array) -> Array:
    """What columns (rows, n) leave of values (rows,) at the least squares."""
    size = np.maximum(np.abs(columns).max(axis=0), 1e-12)
    weights = np.linalg.lstsq(columns / size, values, rcond=TINY)[0]
    left: Array = values - columns / size @ weights
    return left
