"""Hidden effects at the regulator: what makes the measured pressure differ from the declared law.

Each effect is a NamedTuple of its parameters with `form` 0 where it is absent, the laws that the
integrator calls, and a `draw`.  Pressures are gauge, in kPa; targets are commanded pressures.
"""

from math import exp, sqrt, tanh
from typing import NamedTuple

import numpy as np
from numba import njit


def sign(rng: np.random.Generator) -> float:
    """Plus or minus one."""
    return float(rng.choice([-1.0, 1.0]))


class DeadTime(NamedTuple):
    """The target reaches the valve late.

    transport_s: pure delay; tube_s: time constant of the tube behind it (form 2).
    """

    form: int = 0
    transport_s: float = 0.0
    tube_s: float = 0.0


def draw_dead_time(form: int, scale: float, rng: np.random.Generator) -> DeadTime:
    if form == 1:
        return DeadTime(1, scale * rng.uniform(0.020, 0.120))
    return DeadTime(2, scale * rng.uniform(0.015, 0.090), scale * rng.uniform(0.005, 0.020))


class Asymmetry(NamedTuple):
    """Exhausting is another speed than filling.

    ratio: exhaust rate over fill rate, everywhere (form 1), at 100 kPa (form 2, times the root of
    pressure) or at 200 kPa (form 3, linear in pressure); base [kPa] keeps the rate above zero at 0.
    fill, exhaust [kPa/s]: most that a valve passes at 100 kPa (form 4): from a tank at 300 kPa and to the
    outside, with the root of the difference of pressure, less sharply the nearer the valve is to its limit.
    """

    form: int = 0
    ratio: float = 1.0
    base: float = 0.0
    fill: float = 1e9
    exhaust: float = 1e9


@njit
def valve_rate(p: Asymmetry, rate: float, pressure: float) -> float:
    """Rate [kPa/s] at which the pressure changes, where the regulator asks for one."""
    above = max(pressure, 0.0)
    if p.form == 4:
        if rate >= 0.0:
            most = p.fill * sqrt(max(300.0 - above, 1.0) / 200.0)
        else:
            most = p.exhaust * sqrt((above + 5.0) / 105.0)
        return most * tanh(rate / most)
    if p.form == 0 or rate >= 0.0:
        return rate
    if p.form == 1:
        return rate * p.ratio
    if p.form == 2:
        return rate * p.ratio * sqrt((above + p.base) / (100.0 + p.base))
    return rate * p.ratio * (p.base + above) / (p.base + 200.0)


def draw_asymmetry(form: int, scale: float, rng: np.random.Generator) -> Asymmetry:
    if form == 1:
        ratio = rng.uniform(0.5, 0.8) if rng.random() < 0.6 else rng.uniform(1.25, 1.6)
        return Asymmetry(1, ratio**scale)
    if form == 2:
        return Asymmetry(2, rng.uniform(0.6, 0.95) ** scale, rng.uniform(8.0, 20.0))
    if form == 3:
        return Asymmetry(3, rng.uniform(0.9, 1.2) ** scale, rng.uniform(40.0, 90.0))
    fill = rng.uniform(80.0, 250.0) / scale
    return Asymmetry(4, fill=fill, exhaust=fill * rng.uniform(0.4, 0.9))


class Deadband(NamedTuple):
    """Small changes of the command are ignored (form 1, latch) or followed at a distance (form 2, play).

    width [kPa]: the threshold of the latch, or the half-width of the play.
    """

    form: int = 0
    width: float = 0.0


@njit
def accepted_target(p: Deadband, target: float, accepted: float) -> float:
    """The target that the regulator works on, after `accepted`."""
    if p.form == 0:
        return target
    if p.form == 1:
        return target if abs(target - accepted) > p.width else accepted
    return min(max(accepted, target - p.width), target + p.width)


def draw_deadband(form: int, scale: float, rng: np.random.Generator) -> Deadband:
    return Deadband(form, scale * (rng.uniform(2.0, 4.0) if form == 1 else rng.uniform(1.0, 4.0)))


class Supply(NamedTuple):
    """A supply that sags as air is used, and recovers with a time constant.

    full [kPa]: when rested; sag: kPa lost for each kPa filled (forms 1 and 3); most [kPa]: the
    deepest sag (form 2); used [kPa]: filling that brings 63 % of it; recovery_s: time constant.
    orifice [1/s]: fill rate for each kPa of supply above the chamber, near empty difference (form 3).
    """

    form: int = 0
    full: float = 1e9
    sag: float = 0.0
    most: float = 0.0
    used: float = 1.0
    recovery_s: float = 1.0
    orifice: float = 1e9


@njit
def supply_pressure(p: Supply, use: float) -> float:
    """Pressure [kPa] after a decaying use [kPa] of air."""
    if p.form == 2:
        return p.full - p.most * (1.0 - exp(-use / p.used))
    return p.full - p.sag * use


@njit
def limited_rate(p: Supply, rate: float, pressure: float, supply: float) -> float:
    """Rate [kPa/s] at which the chamber can really change."""
    if p.form == 3 and rate > 0.0:
        over = max(supply - pressure, 0.0)
        # Flow through an orifice goes with the root of the difference, and linearly where it is small.
        return min(rate, p.orifice * over / sqrt(1.0 + over / 20.0))
    return rate


def draw_supply(form: int, scale: float, rng: np.random.Generator) -> Supply:
    full, recovery = rng.uniform(188.0, 202.0), rng.uniform(3.0, 15.0)
    if form == 2:
        most, used = scale * rng.uniform(20.0, 45.0), rng.uniform(60.0, 180.0)
        return Supply(2, full, 0.0, most, used, recovery)
    sag = scale * min(rng.uniform(0.12, 0.3), 1.3 / recovery)  # a fast sine must leave some supply
    if form == 1:
        return Supply(1, full, sag, recovery_s=recovery)
    return Supply(3, full + 6.0, sag, recovery_s=recovery, orifice=rng.uniform(4.0, 9.0))


OUTSIDE = 101.3  # kPa absolute


class Leak(NamedTuple):
    """Air that is lost: dP/dt falls by what flows out.

    flow [kPa/s]: at 100 kPa, through an orifice (form 1: choked beyond the critical ratio of pressures, ISO
    6358) or through a slit, with the root of the pressure (form 2), beside pores that lose porous [1/s].
    """

    form: int = 0
    flow: float = 0.0
    critical: float = 0.5
    porous: float = 0.0


@njit
def orifice(pressure: float, critical: float) -> float:
    """Mass flow of ISO 6358 to the outside, of no unit, at a gauge pressure."""
    inside = pressure + OUTSIDE
    ratio = OUTSIDE / inside
    if ratio <= critical:
        return inside
    return inside * sqrt(1.0 - ((ratio - critical) / (1.0 - critical)) ** 2)


@njit
def leaked(p: Leak, pressure: float) -> float:
    """Fall of the pressure [kPa/s]."""
    inside = max(pressure, 0.0)
    if p.form == 1:
        return p.flow * orifice(inside, p.critical) / orifice(100.0, p.critical)
    if p.form == 2:
        return p.porous * inside + p.flow * sqrt(inside / 100.0)
    return 0.0


def draw_leak(form: int, scale: float, rng: np.random.Generator) -> Leak:
    if form == 1:
        return Leak(1, scale * rng.uniform(1.5, 5.0), rng.uniform(0.2, 0.5))
    return Leak(2, scale * rng.uniform(0.5, 2.0), porous=scale * rng.uniform(0.005, 0.02))
