"""What friction is found from: displacement and force in time, with the load where it was logged."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SMOOTHED = 9
"""Rows over which a displacement is smoothed before it is differentiated."""


@dataclass(frozen=True)
class ForceRun:
    """Displacement and force [N], every `dt` [s], of shape (n,); load: what presses, a pressure say, in
    proportion to which there is a force without any motion, or None.

    The unit of the displacement is the log's, and so are those of all that is made of it.
    """

    displacement: Array
    force: Array
    load: Array | None = None
    dt: float = 0.01

    @cached_property
    def smooth(self) -> Array:
        """The displacement, smoothed by parabolas (Savitzky & Golay, Anal. Chem. 36, 1964)."""
        return self._smoothed(0)

    @cached_property
    def speed(self) -> Array:
        """Of the smoothed displacement [1/s]."""
        return self._smoothed(1)

    @cached_property
    def travel(self) -> Array:
        """Way that was gone since the run began."""
        return np.append(0.0, np.cumsum(np.abs(np.diff(self.smooth))))

    def _smoothed(self, derivative: int) -> Array:
        from scipy.signal import savgol_filter

        found: Array = savgol_filter(self.displacement, SMOOTHED, 2, deriv=derivative, delta=self.dt)
        return found

    def rows(self, first: int, last: int) -> "ForceRun":
        """The rows from `first` to before `last`, a run of its own."""
        s = slice(first, last)
        load = None if self.load is None else self.load[s]
        return ForceRun(self.displacement[s], self.force[s], load, self.dt)
