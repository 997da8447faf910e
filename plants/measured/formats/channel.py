"""A channel as a recorder keeps it: values on a time axis of its own."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
GAP = 2.5
"""Steps longer than this many sample times are gaps; loggers jitter and may skip one row."""

SKIPPED = 1.5
"""Steps longer than this many sample times have a sample less than others."""


class LoggedChannel(NamedTuple):
    """One signal of a log.

    name: as the file has it; unit: as the file writes it, "" where it does not say; time [s], shape (n,);
    values, shape (n,), in that unit.
    """

    name: str
    unit: str
    time: Array
    values: Array

    @property
    def step(self) -> float:
        """Median distance of two samples [s]; 0 for fewer than two.

        >>> LoggedChannel("p", "bar", np.array([0.0, 0.1, 0.2]), np.zeros(3)).step
        0.1
        """
        return float(np.median(np.diff(self.time))) if len(self.time) > 1 else 0.0

    @property
    def rate(self) -> float:
        """Samples in a second [Hz], skipped ones and gaps aside; 0 for fewer than two samples.

        A camera of 30 Hz among rows 10 ms apart has steps of 30 and 40 ms.

        >>> time = np.array([0.0, 0.03, 0.06, 0.1, 0.13, 0.16, 0.2])
        >>> round(LoggedChannel("angle", "deg", time, time).rate, 6)
        30.0
        """
        distances = np.diff(self.time)
        usual = distances[distances < SKIPPED * self.step]
        return 1.0 / float(np.mean(usual)) if usual.size else 0.0


class LoggedSeries(NamedTuple):
    """Values without a time axis: name, unit ("" where the file does not say), values (n,), and distance of
    two samples [s], 0 where the file does not say."""

    name: str
    unit: str
    values: Array
    step: float = 0.0


def numeric(values: object) -> Array | None:
    """A one-dimensional series of real numbers as floats; None for anything else.

    >>> numeric(np.array([1, 2])), numeric(["a"]), numeric(np.zeros((2, 2)))
    (array([1., 2.]), None, None)
    """
    array = np.asarray(values)
    if array.ndim != 1 or array.dtype.kind not in "biuf" or len(array) < 2:
        return None
    return array.astype(np.float64)
