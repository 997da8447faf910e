"""Hidden effects at the joint: mass, stops and friction.

As in the regulator's file: a NamedTuple of parameters with `form` 0 where absent, the laws that the
integrator calls, and a `draw`.  x is pressure minus rest pressure [kPa]; angles are in deg.
"""

from math import exp
from typing import NamedTuple

import numpy as np
from numba import njit

from tests.rig.parameters import Declared
from tests.rig.regulator_effects import sign
from tests.rig.signals import Signal


class Inertia(NamedTuple):
    """A joint of second order instead of a lag: y'' = wn^2 (u - y) - 2 zeta wn y'.

    wn [rad/s], zeta; form 2: damping grows by drag [s/deg] |y'|; form 3: wn^2 grows by
    stiffening, a fraction for each 100 kPa above rest.
    """

    form: int = 0
    wn: float = 0.0
    zeta: float = 0.0
    drag: float = 0.0
    stiffening: float = 0.0


@njit
def joint_acceleration(p: Inertia, u: float, y: float, speed: float, x: float) -> float:
    """Of a joint with inertia [deg/s^2]."""
    stiffness = p.wn**2 * (1.0 + p.stiffening * x / 100.0)
    return stiffness * (u - y) - 2.0 * p.zeta * p.wn * speed * (1.0 + p.drag * abs(speed))


def draw_inertia(form: int, scale: float, rng: np.random.Generator) -> Inertia:
    wn, zeta = rng.uniform(6.0, 20.0) / scale, rng.uniform(0.15, 0.5)
    if form == 1:
        return Inertia(1, wn, zeta)
    if form == 2:
        return Inertia(2, wn, 0.7 * zeta, drag=rng.uniform(0.005, 0.02))
    return Inertia(3, wn, zeta, stiffening=sign(rng) * rng.uniform(0.15, 0.4))


class EndStop(NamedTuple):
    """The joint meets a stop at high or low [deg].

    form 1: it cannot pass; form 2: it meets a spring, contact times as stiff as the joint;
    form 3: a pad, whose push grows with the square of its compression, contact at 1 deg.
    """

    form: int = 0
    low: float = -1e9
    high: float = 1e9
    contact: float = 0.0


@njit
def stop_push(p: EndStop, y: float) -> float:
    """Push of a soft stop against the joint, in deg of its own spring."""
    over = max(y - p.high, 0.0) - max(p.low - y, 0.0)
    if p.form == 2:
        return p.contact * over
    if p.form == 3:
        return p.contact * over * abs(over)
    return 0.0


def draw_end_stop(form: int, scale: float, rng: np.random.Generator, rig: Declared) -> EndStop:
    highest, lowest = rig.a1 * 97.0 - rig.w1, -rig.a2 * 100.0 + rig.w2
    share = rng.uniform(0.60, 0.85, 2) / scale
    sides = str(rng.choice(["low", "high", "both"]))
    high = float(share[0] * highest) if sides != "low" else 1e9
    low = float(share[1] * lowest) if sides != "high" else -1e9
    give = rng.uniform(0.05, 0.2)  # slope beyond the stop, relative to the free joint
    contact = {1: 0.0, 2: 1.0 / give - 1.0, 3: rng.uniform(0.8, 2.5)}[form]
    return EndStop(form, low, high, contact)


class StickSlip(NamedTuple):
    """A joint that sticks, in deg of its own spring.

    form 1: without mass, it holds until its spring is off by breakaway, then moves until residue is left;
    form 2: LuGre's law: bristles of stiffness times the joint's spring, whose pull is z' = v - |v| z/g(v)
    with g from breakaway at rest to coulomb at speeds above stribeck [deg/s]; form 3: four springs of the
    joint's stiffness times `stiffness` in all, each of which slips at a part of breakaway that grows with its
    number (Maxwell slip), without mass.
    """

    form: int = 0
    breakaway: float = 0.0
    residue: float = 0.0
    coulomb: float = 0.0
    stribeck: float = 1.0
    stiffness: float = 1.0


@njit
def bristles(p: StickSlip, speed: float, pull: float) -> float:
    """Rate of the bristles' pull [deg/s] at a speed of the joint [deg/s]."""
    most = p.coulomb + (p.breakaway - p.coulomb) * exp(-((speed / p.stribeck) ** 2))
    return p.stiffness * (speed - abs(speed) * pull / most)


@njit
def lugre(p: StickSlip, Tw: float, u: float, y: float, pull: float) -> tuple[float, float]:
    """Speed of a joint without mass [deg/s] and rate of the bristles' pull [deg/s].

    The joint is where Tw v = u - y - pull.
    """
    speed = (u - y - pull) / Tw
    return speed, bristles(p, speed, pull)


SPRINGS = 4


@njit
def maxwell_slip(p: StickSlip, pulls: Signal, move: float) -> float:
    """Pull of all springs [deg] after the joint has moved [deg]; `pulls` are theirs, and change."""
    whole = 0.0
    for i in range(SPRINGS):
        most = p.breakaway * 2.0 * (i + 1) / (SPRINGS * (SPRINGS + 1))
        pulls[i] = min(max(pulls[i] + p.stiffness / SPRINGS * move, -most), most)
        whole += pulls[i]
    return whole


def draw_stick_slip(form: int, scale: float, rng: np.random.Generator) -> StickSlip:
    breakaway = scale * rng.uniform(1.0, 2.5)
    if form == 1:
        return StickSlip(1, breakaway, 0.25 * breakaway)
    if form == 3:
        return StickSlip(3, breakaway, stiffness=rng.uniform(4.0, 10.0))
    return StickSlip(
        2,
        breakaway,
        coulomb=breakaway * rng.uniform(0.3, 0.6),
        stribeck=rng.uniform(1.0, 4.0),
        stiffness=rng.uniform(15.0, 40.0),
    )
