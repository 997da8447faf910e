"""The rough output curve between a sum of plays and the angle."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plants.hysteresis.output_curve import OutputCurve
from plants.hysteresis.rough_loop import RoughCurve

Array = NDArray[np.float64]

CENTRES = np.linspace(0.2, 0.8, 7)
"""Where the middle of the curve is tried, as shares of the range of the sum."""

SPANS = np.linspace(1 / 24, 1 / 4, 6)
"""Distances from there at which it bends first that are tried, as shares of the range."""

FLATTEST = 0.05
"""Slope of a piece, relative to the steepest, that stands for none."""

POINTS = 600
"""Of the series that are looked at, about."""


def rough_curve(total: Array, angle: Array) -> RoughCurve | None:
    """The curve from a sum of plays (n,) to an angle (n,) [deg] with least squares, its slopes not negative;
    None where the angle does not rise with the sum.

    >>> total = np.linspace(0.0, 60.0, 300)
    >>> found = rough_curve(total, np.maximum(total - 10.0, 0.0))
    >>> [round(float(m), 3) for m in (found.about.b2, found.about.c2)]
    [0.05, 1.0]
    """
    from scipy.optimize import nnls

    thin = slice(None, None, max(1, len(total) // POINTS))
    u, y = total[thin], angle[thin]
    low, high = float(u.min()), float(u.max())
    width, ones = high - low, np.ones_like(u)
    found: RoughCurve | None = None
    least = float(np.linalg.norm(y - y.mean()))
    for centre in low + width * CENTRES:
        for span in width * SPANS:
            knots = centre + span * np.array([-2.0, -1.0, 1.0, 2.0])
            if knots[0] <= low or knots[-1] >= high:
                continue
            rises = [np.clip(u, a, b) - np.clip(centre, a, b) for a, b in pairwise((low, *knots, high))]
            entries, left = nnls(np.column_stack([*rises, ones, -ones]), y)
            if left < least and entries[:5].max() > 0.0:
                least = left
                b2, b1, middle, c1, c2 = map(
                    float, np.maximum(entries[:5], FLATTEST * float(entries[:5].max()))
                )
                about = OutputCurve(middle * span, b2 / middle, b1 / middle, c1 / middle, c2 / middle)
                found = RoughCurve(middle, middle * float(centre), about, float(entries[5] - entries[6]))
    return found
