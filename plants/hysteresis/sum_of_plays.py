"""The inverse of a sum of plays, in closed form.

Plays of one input are ordered, |p_i - p_j| <= |r_i - r_j|, so that on a monotone move they engage one after
the other, the smallest threshold first, and the sum is convex on the way up and concave on the way down.  The
input is then the least (largest) of the n + 1 straight pieces' (Kuhnen, European J. Control 9 (2003) 407,
doi 10.3166/ejc.9.407-418).
"""

from collections.abc import Sequence
from itertools import accumulate
from typing import Any

import numpy as np

Number = Any

LEVEL = 1e-30
"""A slope below this counts as none, so that no quotient overflows."""


def summed(x: Number, v0: Number, v: Sequence[Number], plays: Sequence[Number]) -> Number:
    """v0 x + v1 p1 + ... of plays p and their weights v.

    >>> summed(3.0, 0.5, (1.0, 2.0), (2.0, 1.0))
    5.5
    """
    return v0 * x + sum(w * p for w, p in zip(v, plays, strict=True))


def inputs_for(
    total: Number, v0: Number, v: Sequence[Number], plays: Sequence[Number], thresholds: Sequence[Number]
) -> tuple[Number, Number]:
    """The inputs at which the sum comes to a total, on the way up and on the way down from where the plays
    are; of a total that lies the other way the one or the other is meaningless.

    >>> up, down = inputs_for(8.0, 0.5, (1.0, 2.0), (0.0, 0.0), (1.0, 2.0))     # from x = 0
    >>> round(float(up), 9), round(float(summed(up, 0.5, (1.0, 2.0), (up - 1.0, up - 2.0))), 9)
    (3.714285714, 8.0)
    """
    aim = total - summed(0.0, v0, v, plays)
    slopes = list(accumulate((v0, *v)))
    ends = []
    for sign in (1.0, -1.0):
        corners = [p + sign * r for p, r in zip(plays, thresholds, strict=True)]
        offsets = accumulate(w * c for w, c in zip(v, corners, strict=True))
        pieces = [
            (aim + offset) / np.maximum(slope, LEVEL)
            for slope, offset in zip(slopes, (0.0, *offsets), strict=True)
        ]
        best = pieces[0]
        for piece in pieces[1:]:
            best = np.minimum(best, piece) if sign > 0 else np.maximum(best, piece)
        ends.append(best)
    return ends[0], ends[1]
