"""The way to a reference by the inverse: a model of the wrist that is inverted and goes ahead of it.

A controller carries the model along.  In every sample it asks of the model's static angle

    h_d = y + Tw dy_d/dt,     dy_d/dt = speed (r - y),

the lag inverted for a reference filter of the first order; gets the pressure for h_d from the inverse of
the loop with its memory, and the command for that pressure from the inverse of the regulator
(`plants.actuator.inverse`); clips the command to its range, and moves the model by what is left.  The angle
of the model is therefore one that the wrist can follow, and without disturbances does follow: the range is
respected by construction, at full throttle where the filter asks for more.

A static angle beyond the reference has to come back in time, across the whole loop.  So y in the law is
not that of now but that at which the wrist would stand once h is back at r, if the brake were full from now
on: on the transit until the other line is met, then on that line, the regulator at the rate of each piece
and the lag under a ramp.  At the end of the way both are the same.  This is a proximate time-optimal servo
(Workman, Adaptive Proximate Time-Optimal Servomechanisms, Stanford 1987): bang-bang far from
the reference, linear close to it.
"""

import warnings
from typing import NamedTuple

import numpy as np

from design.controllers.controller import remembers
from plants import dynamics
from plants.actuator import inverse
from plants.dynamics import Number, SampledWrist
from plants.errors import InputError, InputWarning
from plants.wrist import State, Wrist

WIDE = "wider than what the commands move the joint by, so that no angle is reached from every memory"


@remembers(
    outside=("", "samples in which the reference was out of reach and the nearest was taken"),
)
class ReferenceModel(NamedTuple):
    """The model, which runs ahead of the wrist, and in how many samples the reference was out of reach."""

    model: State
    outside: Number


class SampledReferenceModel(NamedTuple):
    """Coefficients of the model and of the way to the reference for one sample time."""

    wrist: SampledWrist
    k_fast: Number  # 1/s
    k_slow: Number  # 1/s
    Tw: Number  # s
    lead: Number  # Tw speed - 1
    low: Number  # V
    high: Number  # V


def at_return(m: State, r: Number, c: SampledReferenceModel) -> Number:
    """Angle [deg] of the model when its static angle is back at `r` [deg], the brake being full from now on;
    its angle now if the static angle is not beyond."""
    loop, up = c.wrist.hysteresis, m.angle < r
    end = loop.pressure_for(m.memory, m.pressure, r)
    corner, h = loop.turn(m.memory, m.pressure, end, m.angle >= r)
    brake = c.wrist.regulator.gain * np.where(up, c.low, c.high)
    y = _after(m.angle, m.memory.h, h, _time(m.pressure, corner, brake, c), c)
    y = _after(y, h, r, _time(corner, end, brake, c), c)
    beyond = (m.memory.h - r) * np.where(up, 1.0, -1.0) > 0.0
    return np.where(beyond, y, m.angle)


def _time(before: Number, after: Number, target: Number, c: SampledReferenceModel) -> Number:
    """Time [s] that the regulator takes between two pressures on its way to a third [kPa]."""
    far, near = np.abs(before - target), np.maximum(np.abs(after - target), 1.0)
    squared = 0.25 * (far + near) * (far + near)
    rate = c.k_slow + (c.k_fast - c.k_slow) * squared / (squared + c.wrist.regulator.e0_squared)
    return np.log(np.maximum(far / near, 1.0)) / rate


def _after(angle: Number, before: Number, after: Number, time: Number, c: SampledReferenceModel) -> Number:
    """The lag's angle [deg] after a time [s] in which the static angle goes straight on."""
    ratio = np.maximum(time / c.Tw, 1e-6)
    keep = np.exp(-ratio)
    mean = (1.0 - keep) / ratio
    return keep * angle + (mean - keep) * before + (1.0 - mean) * after


def proceed(s: ReferenceModel, reference: Number, c: SampledReferenceModel) -> tuple[ReferenceModel, Number]:
    """The model one sample later on its way to a reference [deg], and the command [V] that takes it there.

    A reference out of reach of the command's range is taken for the nearest within, and counted.
    """
    m, loop, regulator = s.model, c.wrist.hysteresis, c.wrist.regulator
    reach = c.low * regulator.gain, c.high * regulator.gain
    r = loop.clamped(reference, *reach)
    y, off = at_return(m, r, c), m.memory.h - r
    # The way gone until the return grows about with the square of `off`: what h_d asks for now is
    # taken back by what it does to y, at that slope, or h_d would be met and missed in turns.
    slope = 2.0 * (y - m.angle) / np.where(off == 0.0, 1.0, off)
    wanted = m.memory.h + (r + c.lead * (r - y) - m.memory.h) / (1.0 + np.abs(c.lead) * slope)
    wanted = loop.clamped(wanted, *reach)
    pressure = loop.pressure_for(m.memory, m.pressure, wanted)
    command = inverse.command_for(m.pressure, pressure, regulator)
    command = np.minimum(np.maximum(command, c.low), c.high)
    return ReferenceModel(
        dynamics.step(m, command, c.wrist), s.outside + np.where(r == reference, 0.0, 1.0)
    ), command


def no_inverse(plant: Wrist) -> str | None:
    """Why a wrist has no inverse, and what to do, in one line; None for one that has.

    A dead time needs none: it only makes the wrist late, which `FeedforwardPI.dead_time` allows for.

    >>> from plants.effects.wrist.creep import Creep
    >>> no_inverse(Wrist.flexion() + Creep(0.1, 4.0))
    'no inverse of the effect creep: invert the wrist without it (replace effects by ()), or use a PI'
    """
    stubborn = [e.NAME for e in plant.effects if not e.only_delays]
    if stubborn:
        words = f"the effect{'s' * (len(stubborn) > 1)} {', '.join(stubborn)}"
        return f"no inverse of {words}: invert the wrist without it (replace effects by ()), or use a PI"
    air = plant.regulator
    if air.k_slow > air.k_fast:
        return (
            f"no inverse of the regulator: k_slow {air.k_slow:.4g} is above k_fast {air.k_fast:.4g} 1/s; "
            "correct the parameters, or use a PI"
        )
    problem = plant.hysteresis.problem(*plant.reach)
    if problem:
        return f"no inverse of the loop: {problem}; correct the parameters, or use a PI"
    low, high = reachable(plant)
    if low > high:
        return f"no inverse of the loop: it is {WIDE}; correct the parameters, or use a PI"
    return None


def reachable(plant: Wrist) -> tuple[float, float]:
    """Angles [deg] that commands within the rig's range reach whatever the wrist's memory.

    >>> [round(angle, 2) for angle in reachable(Wrist.flexion())]
    [-30.0, 29.14]
    """
    found = plant.hysteresis.reachable(*plant.reach)
    return float(found[0]), float(found[1])


def within_reach(plant: Wrist, reference: float) -> float:
    """The reference [deg], clamped to what the wrist reaches.

    Warns (InputWarning), with the range, where that changes it; raises InputError for one that is not finite,
    and for any where the loop is so wide that no angle is reached from every memory.
    """
    if not np.isfinite(reference):
        raise InputError(f"reference {reference:g} deg: need a finite angle")
    low, high = reachable(plant)
    if low > high:
        raise InputError(
            f"reference {reference:g} deg: the loop is {WIDE}; correct the plant's loop or command range"
        )
    if low <= reference <= high:
        return reference
    nearest = min(max(reference, low), high)
    warnings.warn(
        f"reference {reference:g} deg is out of reach ({low:.2f} to {high:.2f} deg): "
        f"{nearest:.2f} deg is taken",
        InputWarning,
        stacklevel=2,
    )
    return nearest
