"""Hidden effects at the wrist: what makes the true angle differ from declared hysteresis and lag.

As in the regulator's file: a NamedTuple of parameters with `form` 0 where absent, the laws that the
integrator calls, and a `draw`.  x is pressure minus rest pressure [kPa]; angles are in deg.
"""

from math import cos, exp, pi, tanh
from typing import NamedTuple

import numpy as np
from numba import njit

from tests.rig.parameters import Declared, loop_width
from tests.rig.regulator_effects import sign


class Curvature(NamedTuple):
    """Branches of the loop that are no straight lines.

    cubic: slope change, form 1: a x (1 + cubic (x/100)^2); knee [kPa]: form 2: a knee tanh(x/knee);
    bow1, bow2 [deg]: form 3: line 1 lowered and line 2 raised by bow (1 - (x/100)^2).
    """

    form: int = 0
    cubic: float = 0.0
    knee: float = 1.0
    bow1: float = 0.0
    bow2: float = 0.0


@njit
def bent(p: Curvature, x: float) -> float:
    """The pressure difference that takes the place of x in both lines."""
    if p.form == 1:
        return x * (1.0 + p.cubic * (x / 100.0) ** 2)
    if p.form == 2:
        return p.knee * tanh(x / p.knee)
    return x


@njit
def lens(p: Curvature, x: float) -> float:
    """How far each bow reaches at x, as a fraction."""
    return 1.0 - (x / 100.0) ** 2 if p.form == 3 else 0.0


def draw_curvature(form: int, scale: float, rng: np.random.Generator, rig: Declared) -> Curvature:
    if form == 1:
        return Curvature(1, cubic=scale * sign(rng) * rng.uniform(0.08, 0.18))
    if form == 2:
        return Curvature(2, knee=rng.uniform(105.0, 170.0) / scale)
    # A lens (equal signs) or a banana (opposite ones); the loop must stay open at its waist.
    most = min(3.0, 0.4 * loop_width(rig, 0.0))
    bow1, bow2 = scale * rng.uniform(0.4, 1.0, 2) * most
    side = sign(rng)
    return Curvature(3, bow1=float(bow1), bow2=float(side * bow2))


class RateDependence(NamedTuple):
    """A loop that widens with the pressure's rate r [kPa/s].

    slope [deg s/kPa]: widening of each half, form 1 slope r, form 3 slope r after a low pass of
    memory_s; widest [deg]: form 2 widest r/(r + half), form 4 widest (r/100)^power; half [kPa/s].
    """

    form: int = 0
    slope: float = 0.0
    widest: float = 0.0
    half: float = 1.0
    power: float = 1.0
    memory_s: float = 1.0


@njit
def widening(p: RateDependence, rate: float, remembered_rate: float) -> float:
    """Widening [deg] of each half of the loop."""
    if p.form == 1:
        return p.slope * rate
    if p.form == 2:
        return p.widest * rate / (rate + p.half)
    if p.form == 3:
        return p.slope * remembered_rate
    if p.form == 4:
        return p.widest * (rate / 100.0) ** p.power
    return 0.0


def draw_rate_dependence(form: int, scale: float, rng: np.random.Generator) -> RateDependence:
    if form == 1:
        return RateDependence(1, slope=scale * rng.uniform(0.006, 0.014))
    if form == 2:
        return RateDependence(2, widest=scale * rng.uniform(1.2, 3.0), half=rng.uniform(30.0, 150.0))
    if form == 3:
        return RateDependence(3, slope=scale * rng.uniform(0.006, 0.014), memory_s=rng.uniform(0.05, 0.2))
    return RateDependence(4, widest=scale * rng.uniform(0.7, 1.6), power=rng.uniform(0.4, 0.7))


class Softening(NamedTuple):
    """Slopes that change as the actuator is worked, to (1 + change) times their first values.

    scale: of what softens it: kPa of accumulated pressure change (form 1), s since the start
    (form 2, warming), kPa of the largest pressure difference so far (form 3, Mullins).
    """

    form: int = 0
    change: float = 0.0
    scale: float = 1.0


@njit
def slope_factor(p: Softening, work: float, time: float, largest: float) -> float:
    """Factor on a1, a2 and s."""
    if p.form == 0:
        return 1.0
    done = work if p.form == 1 else (time if p.form == 2 else largest)
    return 1.0 + p.change * (1.0 - exp(-done / p.scale))


def draw_softening(form: int, scale: float, rng: np.random.Generator) -> Softening:
    change = scale * sign(rng) * rng.uniform(0.07, 0.15)
    if form == 1:
        return Softening(1, change, rng.uniform(300.0, 1500.0))
    if form == 2:
        return Softening(2, change, rng.uniform(30.0, 80.0))
    return Softening(3, 1.5 * change, rng.uniform(40.0, 80.0))


LONGEST_SPECTRUM = 6


class Creep(NamedTuple):
    """The static angle goes on: u = h + sum gain_i c_i, each c_i following h with its time constant.

    form 1: one element; form 2: two, a second and ten; form 3: six over decades, near log(time).
    """

    form: int = 0
    gains: tuple[float, ...] = (0.0,) * LONGEST_SPECTRUM
    times_s: tuple[float, ...] = (1.0,) * LONGEST_SPECTRUM


def draw_creep(form: int, scale: float, rng: np.random.Generator) -> Creep:
    if form == 1:
        gains, times = [rng.uniform(0.06, 0.15)], [rng.uniform(2.0, 8.0)]
    elif form == 2:
        gains, times = list(rng.uniform(0.04, 0.09, 2)), [rng.uniform(0.6, 1.2), rng.uniform(7.0, 14.0)]
    else:
        total, longest = rng.uniform(0.12, 0.22), rng.uniform(40.0, 90.0)
        gains = [total / LONGEST_SPECTRUM] * LONGEST_SPECTRUM
        times = list(np.geomspace(0.3, longest, LONGEST_SPECTRUM))
    rest = LONGEST_SPECTRUM - len(gains)
    return Creep(
        form,
        tuple(scale * float(g) for g in gains) + (0.0,) * rest,
        tuple(float(t) for t in times) + (1.0,) * rest,
    )


class LoadStep(NamedTuple):
    """A load picked up at moment_s: the angle shifts by shift [deg], and the hand turns stiffer or softer.

    form 1: at once; form 2: through a ramp of ramp_s; form 3: at once, and the static angle is also
    multiplied by 1 + slope_change.
    """

    form: int = 0
    moment_s: float = 0.0
    shift: float = 0.0
    ramp_s: float = 0.0
    slope_change: float = 0.0


@njit
def loaded(p: LoadStep, angle: float, time: float) -> float:
    """Static angle with whatever is held by then."""
    if p.form == 0 or time < p.moment_s:
        return angle
    if p.form == 2 and time < p.moment_s + p.ramp_s:
        return angle + p.shift * 0.5 * (1.0 - cos(pi * (time - p.moment_s) / p.ramp_s))
    return angle * (1.0 + p.slope_change) + p.shift


def draw_load_step(form: int, scale: float, rng: np.random.Generator) -> LoadStep:
    moment, shift = rng.uniform(8.0, 20.0), scale * sign(rng) * rng.uniform(0.8, 3.0)
    ramp = rng.uniform(0.2, 0.5) if form == 2 else 0.0
    change = -rng.uniform(0.01, 0.04) if form == 3 else 0.0  # a weight hangs: it only takes angle away
    return LoadStep(form, moment, shift, ramp, scale * change)


class Coupling(NamedTuple):
    """The other motion's pressure moves this angle; d is that pressure minus 100 kPa.

    angle [deg/kPa]: angle d before the lag (forms 1, 3); bend [deg/kPa]: bend d^2/100 besides (form 3);
    pressure: kPa on the hysteresis for each kPa of d (form 2).
    """

    form: int = 0
    angle: float = 0.0
    bend: float = 0.0
    pressure: float = 0.0


def draw_coupling(form: int, scale: float, rng: np.random.Generator) -> Coupling:
    side = scale * sign(rng)
    if form == 1:
        return Coupling(1, angle=side * rng.uniform(0.01, 0.04))
    if form == 2:
        return Coupling(2, pressure=side * rng.uniform(0.06, 0.14))
    bend = scale * sign(rng) * rng.uniform(0.006, 0.02)
    return Coupling(3, angle=side * rng.uniform(0.01, 0.03), bend=bend)


PLAYS = 5


class LoopShape(NamedTuple):
    """Further hysteresis beside the loop, of slope [deg/kPa] in all.

    form 1: five plays of half-widths up to widest [kPa]; form 2: Bouc-Wen's law,
    z' = x' (1 - |z/widest|^power) on the way out and x' on the way back, so that the loop is smooth;
    form 3: curved transits, as steep as the line that they lead to where they reach it: the share of its
    slope goes with that power of the way from the other line.
    """

    form: int = 0
    slope: float = 0.0
    widest: float = 1.0
    power: float = 1.0


@njit
def bouc_wen(p: LoopShape, z: float, move: float) -> float:
    """What z [kPa] is after the pressure has moved."""
    if move * z <= 0.0:
        return z + move
    return z + move * (1.0 - abs(z / p.widest) ** p.power)


def draw_loop_shape(form: int, scale: float, rng: np.random.Generator) -> LoopShape:
    if form == 1:
        return LoopShape(1, scale * rng.uniform(0.08, 0.15), rng.uniform(25.0, 50.0))
    if form == 2:
        return LoopShape(2, scale * rng.uniform(0.12, 0.25), rng.uniform(10.0, 30.0), rng.uniform(1.0, 2.0))
    return LoopShape(3, power=rng.uniform(1.0, 2.5) / scale)


@njit
def curved_transit(p: LoopShape, s: float, line: float, way: float) -> float:
    """Slope [deg/kPa] of a transit that has gone a share `way` of the gap to a line of slope `line`."""
    return s + (line - s) * min(max(way, 0.0), 1.0) ** p.power
