"""What a figure shows, apart from how it is drawn: panels of named series with units."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Series:
    """One curve or set of points, x and y of shape (n,); low and high, where given, bound y.

    role: how it is meant: ``model``, ``command`` (what was asked for), ``points``,
    ``beside`` (another model to compare with) or ``guide`` (an auxiliary line).
    """

    name: str
    x: Array
    y: Array
    role: str = "model"
    low: Array | None = None
    high: Array | None = None


@dataclass(frozen=True)
class Panel:
    """Axes with their labels, units in brackets, and what is in them."""

    title: str
    x_label: str
    y_label: str
    series: tuple[Series, ...]

    def named(self, name: str) -> Series:
        """The series of a name; raises KeyError where there is none."""
        for s in self.series:
            if s.name == name:
                return s
        raise KeyError(name)
