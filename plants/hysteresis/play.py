"""The play, or backlash: the one primitive that every law here with a memory is made of.

A play follows its input only when pushed: its value stays where it is while the input moves inside the
gap, and is carried along by either end of it (Krasnosel'skii & Pokrovskii, Systems with Hysteresis,
1989; Brokate & Sprekels, Hysteresis and Phase Transitions, 1996).  In a *generalised* play the ends are
two curves of the input, and the value may creep along between them.
"""

from typing import Any

import numpy as np

Number = Any


def kept(value: Number, low: Number, high: Number) -> Number:
    """A value kept between the two ends of its gap.

    >>> [float(kept(h, 1.0, 2.0)) for h in (0.0, 1.5, 3.0)]
    [1.0, 1.5, 2.0]
    """
    return np.minimum(np.maximum(value, low), high)


def play(value: Number, x: Number, threshold: Number) -> Number:
    """The play of a threshold after its input has moved monotonically to `x`, `value` being what it was.

    >>> float(play(0.0, 3.0, 1.0)), float(play(2.0, 2.5, 1.0)), float(play(2.0, 0.0, 1.0))
    (2.0, 2.0, 1.0)
    """
    return kept(value, x - threshold, x + threshold)
