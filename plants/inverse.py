"""Inverses of the wrist's laws: the pressure that gives an angle, and the command that gives a pressure.

The four segments with memory (`plants.hysteresis`) have an exact right inverse.  A monotone move
from the memory (h, virgin) at the pressure P goes along the transit until it meets a line,

    up     H(P') = max(h + s (P' - P), line1(P')),
    down   H(P') = min(h + s (P' - P), line2(P')),      s = 0 on the virgin curve,

and both rise with P', so that the pressure of an angle r is where the first of the two gets there:
the transit's pressure of r, kept between those at which line 2 and line 1 have r.  Where many
pressures give r (r = h on the virgin curve, or on a transit without slope) the smallest move is
taken: to stay.  Kuhnen, European J. Control 9 (2003), inverts play operators likewise, by
memory; the general theory is Krasnosel'skii & Pokrovskii, Systems with Hysteresis (1989).

All functions are NumPy ufuncs of floats, lanes or symbols, as the laws are.
"""

from typing import Any

import numpy as np

from plants import hysteresis
from plants.hysteresis import Hysteresis, Memory
from plants.regulator import SampledRegulator, share

Number = Any

LEVEL = 1e-30
"""A transit less steep than this [deg/kPa] counts as one without slope, so that no quotient overflows."""

NEWTON_STEPS = 10
"""Of `error_for`: to rounding for every regulator within the bounds of its parameters at 1 ms."""


def pressure_for(memory: Memory, before: Number, angle: Number, p: Hysteresis) -> Number:
    """Pressure [kPa] after a monotone move from `before` [kPa] that takes the loop to `angle` [deg].

    ``hysteresis.step(memory, before, pressure_for(memory, before, angle, p), p).h`` is the angle, to
    rounding, for every memory that a loop which `plants.quantities.loop_problem` passes can have.
    The pressure is not bounded: `clamped` keeps an angle within what a range of pressures reaches.

    >>> loop = Hysteresis(a1=0.36, w1=6.0, a2=0.36, w2=6.0, s=0.08)
    >>> float(pressure_for(Memory(0.0, 1.0), 100.0, 12.0, loop))    # through the dead zone, to line 1
    150.0
    >>> float(pressure_for(Memory(12.0, 0.0), 150.0, 11.2, loop))   # reversal: the transit
    140.0
    >>> float(pressure_for(Memory(0.0, 1.0), 103.0, 0.0, loop))     # of many pressures, to stay
    103.0
    """
    low, high = hysteresis.line2_pressure(angle, p), hysteresis.line1_pressure(angle, p)
    slope = p.s * (1.0 - memory.virgin)
    slopes = slope > LEVEL
    inside = before + (angle - memory.h) / np.where(slopes, slope, 1.0)
    transit = np.minimum(np.maximum(inside, low), high)
    straight = np.where(angle > memory.h, high, low)
    return np.where(angle == memory.h, before, np.where(slopes, transit, straight))


def reachable(p: Hysteresis, low: Number, high: Number) -> tuple[Number, Number]:
    """Angles [deg] that pressures from `low` to `high` [kPa] reach whatever the memory: from line 2 at
    the one to line 1 at the other.

    >>> loop = Hysteresis(a1=0.36, w1=6.0, a2=0.36, w2=6.0, s=0.08)
    >>> [round(float(angle), 3) for angle in reachable(loop, 0.0, 197.6)]
    [-30.0, 29.136]
    """
    return hysteresis.line2(low, p), hysteresis.line1(high, p)


def clamped(angle: Number, p: Hysteresis, low: Number, high: Number) -> Number:
    """The angle [deg] that is nearest to `angle` among those that pressures from `low` to `high` [kPa]
    reach whatever the memory; `pressure_for` of it lies between these pressures."""
    least, most = reachable(p, low, high)
    return np.minimum(np.maximum(angle, least), most)


def corner_pressure(memory: Memory, before: Number, up: Number, p: Hysteresis) -> Number:
    """Pressure [kPa] at which the transit from the memory at `before` [kPa] meets line 1 (`up` true) or
    line 2: where a move in that direction leaves it."""
    slope = p.s * (1.0 - memory.virgin)
    a, w = np.where(up, p.a1, p.a2), np.where(up, -p.w1, p.w2)
    return before + (memory.h - a * (before - p.rest_pressure) - w) / (a - slope)


def error_for(change: Number, c: SampledRegulator) -> Number:
    """Error gain v - P [kPa] that the regulator needs for a change of pressure [kPa] in one sample.

    Solves ``share(e, c) e = change`` by Newton's method.  The rate grows with the size of the error, so
    there is one solution; since k(e) e >= k_fast e - (k_fast - k_slow) e0 / 2, it lies at most e0 / 2
    beyond that of the fast rate, which is where the iteration starts.

    >>> from plants.regulator import Regulator, sampled
    >>> c = sampled(Regulator(49.4, 9.0, 0.55, 9.0), 0.001)
    >>> round(float(error_for(0.5, c)), 6), round(float(share(error_for(0.5, c), c) * error_for(0.5, c)), 12)
    (57.110748, 0.5)
    """
    size = np.abs(change)
    half = 0.5 * np.sqrt(c.e0_squared)
    error = np.minimum(size / (c.alpha_slow + c.alpha_rise) + half, size / c.alpha_slow)
    for _ in range(NEWTON_STEPS):
        squared = error * error
        w = squared / (squared + c.e0_squared)
        by_w = c.alpha_rise - c.z_rise * ((1.0 - 2.0 * w) * c.z_centre + (2.0 - 3.0 * w) * w * c.z_rise)
        of_error = share(error, c)
        error = error - (of_error * error - size) / (of_error + 2.0 * w * (1.0 - w) * by_w)
    return np.where(change < 0.0, -error, error)


def command_for(before: Number, after: Number, c: SampledRegulator) -> Number:
    """Command [V] that takes the regulator from one pressure to another [kPa] in one sample; not bounded."""
    return (before + error_for(after - before, c)) / c.gain
