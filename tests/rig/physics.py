"""A wrist from first principles: outside every form of the vocabulary, for tools that must say so.

Two McKibben muscles pull against each other on a pulley.  Force and volume follow from the angle of
the braid (Chou and Hannaford 1996), friction of the braid from Maxwell-slip elements, the rubber's
creep from one Maxwell element, the pressure from gas flow through a spool valve (ISO 6358) into a chamber
whose volume moves with the joint.  The antagonist is held at its rest pressure.  SI units inside.
"""

from dataclasses import dataclass
from math import exp, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from tests.rig.core import TICK, Controller, Outside, pi_command
from tests.rig.rig import Bench, Noise, draw_noise
from tests.rig.signals import Signal

ATMOSPHERE = 101.3e3  # Pa
GAS = 287.0 * 293.0  # J/kg, gas constant of air times its temperature
DENSITY = 1.185  # kg/m^3 of air at the reference state of ISO 6358
POLYTROPIC = 1.2  # between slow (1) and sudden (1.4)
SLIDERS = 5


class Physics(NamedTuple):
    """Parameters of the wrist.

    thread [m], cos_rest: length of a braid's thread and cosine of its angle in the unloaded muscle;
    diameter [m] that the muscle would have at a braid angle of 90 deg; contraction of both at rest;
    radius [m] of the pulley; inertia [kg m^2], damping [N m s], stiffness [N m/rad] and hardening
    [N m/rad^3] of joint and rubber; friction [N m] of all sliders at rest pressure and breakaway
    [rad] of the last; rubber [N m/rad] and rubber_s [s] of the creeping element; gain [kPa/V];
    conductance [m^3/(s Pa)] of the open valve, critical pressure ratio, supply [Pa absolute],
    opening [kPa] at which the spool is fully open and overlap [kPa] below which it is closed; dead_volume
    [m^3] of the tube; rest_pressure [kPa].
    """

    thread: float
    cos_rest: float
    diameter: float
    contraction: float
    radius: float
    inertia: float
    damping: float
    stiffness: float
    hardening: float
    friction: float
    breakaway: float
    rubber: float
    rubber_s: float
    gain: float
    conductance: float
    critical: float
    supply: float
    opening: float
    overlap: float
    dead_volume: float
    rest_pressure: float


def draw_physics(axis: str, rng: np.random.Generator) -> Physics:
    """A plausible wrist, of less travel in deviation than in flexion."""

    def about(value: float, spread: float = 0.12) -> float:
        return float(value * rng.uniform(1 - spread, 1 + spread))

    radius = 0.0105 if axis == "flexion" else 0.0125
    return Physics(
        thread=about(0.217, 0.02),
        cos_rest=float(np.cos(np.radians(rng.uniform(22.0, 25.0)))),
        diameter=about(0.036, 0.03),
        contraction=about(0.14),
        radius=about(radius, 0.05),
        inertia=about(0.005),
        damping=about(0.26, 0.3),
        stiffness=about(1.15 if axis == "flexion" else 2.0),
        hardening=about(0.6, 0.5),
        friction=about(0.13, 0.3),
        breakaway=float(np.radians(rng.uniform(2.0, 6.0))),
        rubber=about(0.18, 0.4),
        rubber_s=float(rng.uniform(1.0, 6.0)),
        gain=about(49.4, 0.004),
        conductance=about(4.5e-10, 0.2),
        critical=float(rng.uniform(0.2, 0.45)),
        supply=float(rng.uniform(450e3, 700e3)),
        opening=float(rng.uniform(40.0, 90.0)),
        overlap=float(rng.uniform(0.1, 0.6)),
        dead_volume=about(2e-5, 0.3),
        rest_pressure=100.0,
    )


@njit
def pull(p: Physics, pressure: float, contraction: float) -> float:
    """Force [N] of a muscle at a gauge pressure [Pa]; it cannot push."""
    cosine = p.cos_rest * (1.0 - contraction)
    return max(0.25 * pi * p.diameter**2 * pressure * (3.0 * cosine**2 - 1.0), 0.0)


@njit
def volume(p: Physics, contraction: float) -> tuple[float, float]:
    """Volume [m^3] of a muscle with its tube, and its slope over contraction."""
    cosine = p.cos_rest * (1.0 - contraction)
    scale = 0.25 * pi * p.diameter**2 * p.thread
    slope = -p.cos_rest * scale * (1.0 - 3.0 * cosine**2)
    return p.dead_volume + scale * cosine * (1.0 - cosine**2), slope


@njit
def flow(conductance: float, upstream: float, downstream: float, critical: float) -> float:
    """Mass flow [kg/s] through an orifice, choked below the critical ratio; pressures absolute [Pa]."""
    if upstream <= downstream:
        return 0.0
    ratio = downstream / upstream
    full = conductance * DENSITY * upstream
    if ratio <= critical:
        return full
    return full * sqrt(1.0 - ((ratio - critical) / (1.0 - critical)) ** 2)


@njit
def mass_flow(p: Physics, error: float, absolute: float) -> float:
    """Into the chamber [kg/s], negative out of it, with the spool moved by the pressure error [kPa]."""
    beyond = abs(error) - p.overlap
    if beyond <= 0.0:
        return 0.0
    open_part = p.conductance * min(beyond / (p.opening - p.overlap), 1.0)
    if error > 0.0:
        return flow(open_part, p.supply, absolute, p.critical)
    return -flow(open_part, absolute, ATMOSPHERE, p.critical)


@njit
def rates(
    p: Physics, target: float, absolute: float, angle: float, speed: float, dragging: float
) -> tuple[float, float]:
    """(dP/dt [Pa/s], angular acceleration [rad/s^2]) with the drag [N m] of friction and rubber."""
    stretch = p.radius / (p.thread * p.cos_rest)  # contraction for each rad
    one, other = p.contraction + stretch * angle, p.contraction - stretch * angle
    held, slope = volume(p, one)
    inflow = mass_flow(p, target - (absolute - ATMOSPHERE) / 1e3, absolute)
    squeezed = absolute * slope * stretch * speed
    torque = p.radius * (pull(p, absolute - ATMOSPHERE, one) - pull(p, p.rest_pressure * 1e3, other))
    torque -= p.stiffness * angle + p.hardening * angle**3 + p.damping * speed + dragging
    return POLYTROPIC * (GAS * inflow - squeezed) / held, torque / p.inertia


@njit(cache=True)
def integrate_physics(
    p: Physics, closed: bool, noisy: bool, controller: Controller, outside: Outside, substeps: int
) -> Signal:
    """Columns at every tick as `integrate` of the core: command, pressure, true and measured angle."""
    ticks = len(outside.command)
    dt = TICK / substeps
    out = np.empty((ticks, 4))
    bent = np.zeros(SLIDERS)  # rad, of each slider's spring
    absolute, angle, speed, rubber = ATMOSPHERE + p.rest_pressure * 1e3, 0.0, 0.0, 0.0
    command, integral, filtered = 0.0, 0.0, 0.0
    relax = 1.0 - exp(-dt / p.rubber_s)
    for tick in range(ticks):
        degrees = angle * 180.0 / pi
        reading = degrees + outside.sensor[tick] + outside.joint[tick]
        measured = reading + outside.noise[tick]
        if closed and tick % controller.every == 0:
            seen_angle = measured if noisy else reading
            command, integral, filtered = pi_command(
                controller, outside.reference[tick], seen_angle, filtered, integral
            )
        elif not closed:
            command = outside.command[tick]
        out[tick, 0], out[tick, 1] = command, (absolute - ATMOSPHERE) / 1e3
        out[tick, 2], out[tick, 3] = degrees, measured
        target = command * p.gain
        for _ in range(substeps):
            # The braid rubs the harder, the higher the pressure in it.
            load = 0.4 + 0.6 * (absolute - ATMOSPHERE) / (p.rest_pressure * 1e3)
            drag = p.rubber * (angle - rubber)
            for i in range(SLIDERS):
                drag += load * p.friction / p.breakaway * 2.0 / (SLIDERS + 1) * bent[i]
            flow1, turn1 = rates(p, target, absolute, angle, speed, drag)
            angle1, speed1 = angle + dt * speed, speed + dt * turn1
            flow2, turn2 = rates(p, target, absolute + dt * flow1, angle1, speed1, drag)
            moved = 0.5 * dt * (speed + speed1)
            absolute += 0.5 * dt * (flow1 + flow2)
            angle, speed = angle + moved, speed + 0.5 * dt * (turn1 + turn2)
            rubber += (angle - rubber) * relax
            for i in range(SLIDERS):
                most = p.breakaway * (i + 1) / SLIDERS
                bent[i] = min(max(bent[i] + moved, -most), most)
    return out


@dataclass(frozen=True)
class PhysicsRig(Bench):
    """The wrist from first principles, to be run and recorded like any other rig."""

    physics: Physics

    def _columns(
        self, closed: bool, noisy: bool, controller: Controller, outside: Outside, substeps: int
    ) -> Signal:
        columns: Signal = integrate_physics(self.physics, closed, noisy, controller, outside, substeps)
        return columns

    @property
    def truth(self) -> dict[str, Any]:
        """What the rig is, as plain numbers."""
        return self.common | {"physics": self.physics._asdict()}


def make_physics_rig(axis: str, seed: int, noise: Noise | None = None) -> PhysicsRig:
    """A wrist of that motion, drawn from the seed."""
    loud = noise or draw_noise(np.random.default_rng([seed, 2]))
    physics = draw_physics(axis, np.random.default_rng([seed, 3]))
    return PhysicsRig(axis, ("physics",), loud, seed, physics)
