"""A channel as a recorder keeps it: values on a time axis of its own."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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
