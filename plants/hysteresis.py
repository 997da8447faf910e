"""Hysteresis of the wrist: pressure to static angle, four straight segments with memory.

Section 5 of the paper.  With x = P - rest_pressure:

    line 1   h = a1 x - w1   (right-hand; the wrist moves in the plus direction)
    line 2   h = a2 x + w2   (left-hand; the wrist moves in the minus direction)
    transit  slope s, between the two lines
    virgin   h = 0 from rest until a line is met (the dead zone of section 5.1)

Inside the loop the angle follows the transit slope and no line is ever
overstepped, which is all the memory there is: the angle itself, and whether
the wrist has left the virgin curve.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

Number = Any


@dataclass(frozen=True)
class Hysteresis:
    """Parameters of the loop: slopes a1, a2, s [deg/kPa], half widths w1, w2 [deg],
    rest_pressure [kPa]."""

    a1: Number
    w1: Number
    a2: Number
    w2: Number
    s: Number
    rest_pressure: Number = 100.0


class Memory(NamedTuple):
    """State of the loop: static angle h [deg]; virgin is 1.0 before a line was met, else 0.0."""

    h: Number
    virgin: Number


def line1(pressure: Number, p: Hysteresis) -> Number:
    """Angle [deg] on line 1, the lower right-hand branch, at a pressure [kPa]."""
    return p.a1 * (pressure - p.rest_pressure) - p.w1


def line2(pressure: Number, p: Hysteresis) -> Number:
    """Angle [deg] on line 2, the upper left-hand branch, at a pressure [kPa]."""
    return p.a2 * (pressure - p.rest_pressure) + p.w2


def line1_pressure(h: Number, p: Hysteresis) -> Number:
    """Pressure [kPa] at which line 1 has the angle h [deg]."""
    return p.rest_pressure + (h + p.w1) / p.a1


def line2_pressure(h: Number, p: Hysteresis) -> Number:
    """Pressure [kPa] at which line 2 has the angle h [deg]."""
    return p.rest_pressure + (h - p.w2) / p.a2


def step(memory: Memory, before: Number, after: Number, p: Hysteresis) -> Memory:
    """The loop after the pressure has moved monotonically from `before` to `after` [kPa].

    Rate-independent: however many steps a monotonic move is cut into, the
    result is the same to rounding.

    >>> loop = Hysteresis(a1=0.36, w1=6.0, a2=0.36, w2=6.0, s=0.08)
    >>> up = step(Memory(0.0, 1.0), 100.0, 150.0, loop)   # dead zone, then line 1
    >>> float(up.h), float(up.virgin)
    (12.0, 0.0)
    >>> float(step(up, 150.0, 140.0, loop).h)             # reversal: transit
    11.2
    """
    inside = memory.h + p.s * (1.0 - memory.virgin) * (after - before)
    return between(memory, inside, line1(after, p), line2(after, p))


def between(memory: Memory, inside: Number, low: Number, high: Number) -> Memory:
    """The loop whose angle [deg] has moved to `inside`, kept between its lines at `low` and `high`."""
    h = np.minimum(np.maximum(inside, low), high)
    return Memory(h, np.where(h == inside, memory.virgin, 0.0))
