"""A rising curve of five straight pieces, the middle one of slope 1, which bends twice on either side."""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from plants.hysteresis.play import kept

Number = Any


class OutputCurve(NamedTuple):
    """Slope 1 between -span and span, c1 and c2 beyond span and 2 span, b1 and b2 below -span and -2 span; a
    superposition of one-sided dead zones (Kuhnen, European J. Control 9 (2003) 407,
    doi 10.3166/ejc.9.407-418).

    >>> curve = OutputCurve(10.0, b2=0.1, b1=0.5, c1=2.0, c2=1.0)
    >>> [float(curve.value(z)) for z in (-25.0, -15.0, 5.0, 15.0, 25.0)]
    [-15.5, -12.5, 5.0, 20.0, 35.0]
    >>> [float(curve.inverse(y)) for y in (-15.5, -12.5, 5.0, 20.0, 35.0)]
    [-25.0, -15.0, 5.0, 15.0, 25.0]
    """

    span: Number
    b2: Number = 1.0
    b1: Number = 1.0
    c1: Number = 1.0
    c2: Number = 1.0

    @property
    def slopes(self) -> tuple[Number, ...]:
        """Of the pieces, the lowest first."""
        return self.b2, self.b1, 1.0, self.c1, self.c2

    def slopes_between(self, low: float, high: float) -> list[float]:
        """Of the pieces that z reaches between two values, both ends of a piece being of it.

        >>> OutputCurve(10.0, b1=0.5, c1=2.0).slopes_between(-5.0, 12.0)
        [1.0, 2.0]
        """
        s = float(self.span)
        knots = (-np.inf, -2.0 * s, -s, s, 2.0 * s, np.inf)
        return [
            float(m) for m, (a, b) in zip(self.slopes, pairwise(knots), strict=True) if a <= high and b >= low
        ]

    def value(self, z: Number) -> Number:
        """The curve at z, both in the unit of the span."""
        s = self.span
        up = self.c1 * (kept(z, s, 2.0 * s) - s) + self.c2 * (np.maximum(z, 2.0 * s) - 2.0 * s)
        down = self.b1 * (kept(z, -2.0 * s, -s) + s) + self.b2 * (np.minimum(z, -2.0 * s) + 2.0 * s)
        return kept(z, -s, s) + up + down

    def inverse(self, y: Number) -> Number:
        """Where the curve has the value y, in closed form: it is piecewise linear."""
        s = self.span
        high, low = s * (1.0 + self.c1), -s * (1.0 + self.b1)
        up = (kept(y, s, high) - s) / self.c1 + (np.maximum(y, high) - high) / self.c2
        down = (kept(y, low, -s) + s) / self.b1 + (np.minimum(y, low) - low) / self.b2
        return kept(y, -s, s) + up + down
