"""Describing functions of the loop's two nonlinearities: the hysteresis and the regulator's rate.

The hysteresis.  Take the transit out of the angle, h = s x + g.  Between the lines g stands still, and
the lines keep it between (a1 - s) x - w1 and (a2 - s) x + w2.  With parallel lines, a1 = a2 = a, that is
the backlash (play) of slope a - s and half gap b = (w1 + w2) / (2 (a - s)) in pressure, whatever the
centre of the oscillation, so that for an amplitude A of the pressure

    N(A) = s + (a - s) B(b / A),    B = 1/2 + f / pi + j g / pi    for b < A, else 0,
    f = asin(c) + c cos(asin(c)),   g = -(1 - c^2),                c = 1 - 2 b / A,

the known describing function of backlash (Gelb & Vander Velde, Multiple-input describing functions and
nonlinear system design, 1968; Slotine & Li, Applied nonlinear control, 1991, section 5.3).
Lines that are not parallel give a harmonic of the same four pieces, integrated piece by piece: up
from the reversal on line 2 with g at rest, along line 1, down with g at rest, along line 2.  It then
depends on the centre of the oscillation too.

The regulator.  dP/dt = k(e) e is odd and without memory: for an error of amplitude E

    K(E) = k_fast - (k_fast - k_slow) (2 / u) (1 - 1 / sqrt(1 + u)),    u = (E / e0)^2,

from the mean of sin^2 / (E^2 sin^2 + e0^2) over a cycle, 1 - e0 / sqrt(e0^2 + E^2) over E^2.
"""

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plants.actuator.regulator import Regulator
from plants.hysteresis import FourSegment, HysteresisLaw

Array = NDArray[np.float64]
POINTS = 720
"""Of a swept cycle; a multiple of four, so that the reversals are among them."""


def backlash(half_gap: float, amplitude: Any) -> NDArray[np.complex128]:
    """Describing function of backlash of slope 1, for amplitudes of the shape of `amplitude`.

    half_gap: half the width of the gap, in the unit of the amplitude.  Zero where the gap is not crossed.

    >>> complex(backlash(1.0, 2.0))                      # c = 0: half the amplitude, 1/pi late
    (0.5-0.3183098861837907j)
    """
    A = np.asarray(amplitude, float)
    c = 1.0 - 2.0 * half_gap / np.maximum(A, max(half_gap, 1e-300))
    real = 0.5 + (np.arcsin(c) + c * np.sqrt(1.0 - c * c)) / np.pi
    return np.asarray(np.where(half_gap < A, real - 1j * (1.0 - c * c) / np.pi, 0.0), complex)


def half_gap(p: FourSegment) -> float:
    """Amplitude of pressure [kPa] up to which an oscillation stays between parallel lines."""
    return float((p.w1 + p.w2) / (2.0 * (p.a1 - p.s)))


def swept(p: HysteresisLaw, amplitude: Any, centre: Any, points: int = POINTS) -> tuple[Array, Array]:
    """Pressure [kPa] and static angle [deg] over one steady cycle, each (points + 1, amplitudes).

    The pressure is centre + amplitude sin, from the centre upwards, stepped by the law of the simulator
    through one cycle to forget and one to show.  A cycle that stays between the lines keeps what memory
    it came with; it comes here from half-way between the lines.
    """
    A, middle = (np.ravel(x) for x in np.broadcast_arrays(np.asarray(amplitude, float), centre))
    sine = np.sin(np.arange(2 * points + 1) * (2.0 * np.pi / points))
    pressure = np.asarray(middle + A * sine[:, None], float)
    start = 0.5 * (p.ascending(middle) + p.descending(middle))
    memory, angle = p.resting("inside", start, middle), [start]
    for before, after in pairwise(pressure):
        memory = p.step(memory, before, after)
        angle.append(memory.h)
    return pressure[points:], np.asarray(angle, float)[points:]


def hysteresis_function(
    p: HysteresisLaw, amplitude: Any, centre: Any = None
) -> tuple[NDArray[np.complex128], Array]:
    """Describing function [deg/kPa] of the loop and the mean static angle [deg], each (amplitudes,).

    amplitude: of the pressure about `centre` [kPa], the rest pressure where not given; arrays of one
    shape.  An oscillation that stays between the lines keeps what memory it came with; the mean is then
    that of one from half-way between them.

    >>> N, mean = hysteresis_function(FourSegment(0.36, 6.0, 0.36, 6.0, 0.08), [1.0, 1e6])
    >>> [complex(n.round(3)) for n in N]                 # the transit, and in the end the lines
    [(0.08+0j), (0.36-0j)]
    """
    A = np.atleast_1d(np.asarray(amplitude, float))
    if not isinstance(p, FourSegment):
        return _numerically(p, A, p.rest_pressure if centre is None else centre)
    x = np.broadcast_to(p.rest_pressure if centre is None else centre, A.shape) - p.rest_pressure
    low, high = (p.a1 - p.s, -p.w1), (p.a2 - p.s, p.w2)  # slope and offset of what keeps g
    top, bottom = low[0] * (x + A) + low[1], high[0] * (x - A) + high[1]
    meets1 = np.arcsin(np.clip(((bottom - low[1]) / low[0] - x) / A, -1.0, 1.0))
    meets2 = np.pi - np.arcsin(np.clip(((top - high[1]) / high[0] - x) / A, -1.0, 1.0))
    right, left = 0.5 * np.pi, 1.5 * np.pi  # turns [rad] of the upper and of the lower reversal
    pieces = (
        (0.0, bottom, -right, meets1),
        (*low, meets1, right),
        (0.0, top, right, meets2),
        (*high, meets2, left),
    )
    harmonic, total = np.zeros(A.shape, complex), np.zeros(A.shape)
    for m, q, begin, end in pieces:
        h1, t1 = _integrals(m * A, q + m * x, np.asarray(end))
        h0, t0 = _integrals(m * A, q + m * x, np.asarray(begin))
        harmonic, total = harmonic + h1 - h0, total + t1 - t0
    cycles = top > bottom
    half_way = np.clip(
        0.5 * ((low[0] + high[0]) * x + low[1] + high[1]), np.minimum(top, bottom), bottom
    )  # moved by the one line that it may touch
    mean = p.s * x + np.where(cycles, total / (2.0 * np.pi), half_way)
    return np.asarray(p.s + np.where(cycles, harmonic / (np.pi * A), 0.0), complex), np.asarray(mean, float)


def _numerically(p: HysteresisLaw, A: Array, centre: Any) -> tuple[NDArray[np.complex128], Array]:
    """The same for a law without a closed form: first harmonic and mean of a swept cycle."""
    _, angle = swept(p, A, np.broadcast_to(centre, A.shape))
    turns = np.arange(POINTS) * (2.0 * np.pi / POINTS)
    harmonic = 2.0 / POINTS * (np.sin(turns) + 1j * np.cos(turns)) @ angle[:-1]
    return np.asarray(harmonic / A, complex), np.asarray(angle[:-1].mean(axis=0), float)


def _integrals(size: Any, level: Any, turn: Array) -> tuple[NDArray[np.complex128], Array]:
    """Primitives, at a turn t [rad], of g (sin t + j cos t) and of g, where g = level + size sin t."""
    sine, cosine = np.sin(turn), np.cos(turn)
    real = -level * cosine + size * (0.5 * turn - 0.5 * sine * cosine)
    imag = level * sine + 0.5 * size * sine * sine
    return np.asarray(real + 1j * imag, complex), np.asarray(level * turn - size * cosine, float)


def centre_of(p: HysteresisLaw, amplitude: Any, angle: float) -> Array:
    """Pressure [kPa] about which an oscillation has a mean static angle [deg], shape of `amplitude`.

    An integrator holds the mean error at zero, so that this is where a limit cycle about a reference
    sits.  By secants; the mean angle rises with the centre.
    """
    A = np.atleast_1d(np.asarray(amplitude, float))
    middle = 0.5 * (p.ascending_pressure(angle) + p.descending_pressure(angle))
    x0 = np.full(A.shape, float(middle))
    x1 = x0 + 1.0
    f0, f1 = (hysteresis_function(p, A, x)[1] - angle for x in (x0, x1))
    for _ in range(30):
        moved = (np.abs(x1 - x0) > 1e-12) & (np.abs(f1) > 1e-10)
        if not moved.any():
            break
        rise = (f1 - f0) / np.where(moved, x1 - x0, 1.0)
        ahead = np.where(moved, x1 - f1 / np.where(np.abs(rise) > 1e-9, rise, p.steepness[0]), x1)
        x0, f0, x1 = x1, f1, ahead
        f1 = hysteresis_function(p, A, x1)[1] - angle
    return np.asarray(x1, float)


def regulator_function(p: Regulator, amplitude: Any) -> Array:
    """Describing function [1/s] of k(e) e for an error of an amplitude [kPa].

    >>> p = Regulator(49.4, 9.0, 0.55, 9.0)
    >>> [float(regulator_function(p, E).round(2)) for E in (0.0, 9.0, 1e6)]
    [0.55, 4.05, 9.0]
    """
    u = (np.asarray(amplitude, float) / p.e0) ** 2
    # (2 / u) (1 - 1 / sqrt(1 + u)) without its cancellation near zero.
    root = np.sqrt(1.0 + u)
    return np.asarray(p.k_fast - (p.k_fast - p.k_slow) * 2.0 / (root * (1.0 + root)), float)


def regulator_rate(p: Regulator, flow: Any) -> Array:
    """Describing function [1/s] of k(e) e at the error that moves the pressure at `flow` [kPa/s].

    flow: amplitude of dP/dt, K(E) E, which rises with E; solved for E by Newton's method from a table.
    """
    table = np.geomspace(1e-6, 1e7, 2000) * p.e0
    moved = regulator_function(p, table) * table
    Q = np.clip(np.asarray(flow, float), moved[0], moved[-1])
    E = np.exp(np.interp(np.log(Q), np.log(moved), np.log(table)))
    for _ in range(3):
        miss = np.log(regulator_function(p, E) * E / Q)
        ahead = np.log(regulator_function(p, E * 1.0001) * E * 1.0001 / Q)
        E = E * np.exp(-miss * np.log(1.0001) / (ahead - miss))
    return regulator_function(p, E)
