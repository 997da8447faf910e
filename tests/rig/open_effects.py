"""Hidden effects that no library lists; of a rig with one of them a tool should say "unexplained".

Each is a NamedTuple of parameters, null by default, with a `draw` of typical strength; `scale`
multiplies it.  The two loud noises (speed-noise, burst-noise) leave no structure in the mean.
"""

from collections.abc import Callable
from math import pi, sin
from typing import NamedTuple

import numpy as np
from numba import njit

from tests.rig.regulator_effects import sign


class EccentricSensor(NamedTuple):
    """The disc of the angle sensor runs out: amplitude [deg], cycles per revolution, phase [rad]."""

    amplitude: float = 0.0
    cycles: float = 1.0
    phase: float = 0.0


@njit
def run_out(p: EccentricSensor, angle: float) -> float:
    """Reading error [deg] at that angle; none at rest."""
    return p.amplitude * (sin(p.cycles * angle * pi / 180.0 + p.phase) - sin(p.phase))


class BendingLeak(NamedTuple):
    """A fitting that opens as the hand bends: dP/dt falls by rate [1/s] P (angle/20 deg)^2."""

    rate: float = 0.0


class SensorBacklash(NamedTuple):
    """Play of half_width [deg] between joint and sensor."""

    half_width: float = 0.0


class Slips(NamedTuple):
    """At random moments, every_s apart on average, the angle slips by about size [deg] and recovers."""

    every_s: float = 0.0
    size: float = 0.0
    recovery_s: float = 1.0


class Wander(NamedTuple):
    """Brownian wander of the reading (temperature): per_root_s [deg/s^0.5]."""

    per_root_s: float = 0.0


class PressureRipple(NamedTuple):
    """The braid's fibres ride over each other: amplitude [deg], sinusoid in pressure of period [kPa]."""

    amplitude: float = 0.0
    period: float = 1.0
    phase: float = 0.0


@njit
def ripple(p: PressureRipple, x: float) -> float:
    """Static angle [deg] that the ripple adds at the pressure difference x [kPa]."""
    turn = 2.0 * pi * x / p.period
    return p.amplitude * (sin(turn + p.phase) - sin(p.phase))


class SampledRegulator(NamedTuple):
    """The regulator reads its command only every period_s, out of step with the log."""

    period_s: float = 0.0
    offset_s: float = 0.0


class ValveCurrent(NamedTuple):
    """The valve's current disturbs the reading: amplitude [deg] at 4 V, with the command squared."""

    amplitude: float = 0.0


class GainDrift(NamedTuple):
    """The regulator's gain falls by loss (a fraction; negative: it rises) as it warms up with warming_s."""

    loss: float = 0.0
    warming_s: float = 1.0


class SpeedNoise(NamedTuple):
    """Noise of the reading grows with speed: its spread is multiplied by 1 + per_speed [s/deg] |y'|."""

    per_speed: float = 0.0


class BurstNoise(NamedTuple):
    """Noise of the reading is factor times louder in bursts of half a second, every_s apart."""

    factor: float = 1.0
    every_s: float = 0.0


class OpenEffects(NamedTuple):
    """All of them."""

    eccentric_sensor: EccentricSensor = EccentricSensor()
    bending_leak: BendingLeak = BendingLeak()
    sensor_backlash: SensorBacklash = SensorBacklash()
    slips: Slips = Slips()
    wander: Wander = Wander()
    pressure_ripple: PressureRipple = PressureRipple()
    sampled_regulator: SampledRegulator = SampledRegulator()
    valve_current: ValveCurrent = ValveCurrent()
    gain_drift: GainDrift = GainDrift()
    speed_noise: SpeedNoise = SpeedNoise()
    burst_noise: BurstNoise = BurstNoise()


def _sampled_regulator(k: float, r: np.random.Generator) -> SampledRegulator:
    period = k * r.uniform(0.10, 0.30)
    return SampledRegulator(period, r.uniform(0.0, period))


DRAWS: dict[str, Callable[[float, np.random.Generator], NamedTuple]] = {
    "eccentric-sensor": lambda k, r: EccentricSensor(
        k * r.uniform(0.5, 1.5), float(r.integers(6, 21)), r.uniform(0, 2 * pi)
    ),
    "bending-leak": lambda k, r: BendingLeak(k * r.uniform(0.03, 0.08)),
    "sensor-backlash": lambda k, r: SensorBacklash(k * r.uniform(0.8, 1.6)),
    "slips": lambda k, r: Slips(r.uniform(5.0, 10.0), k * r.uniform(1.0, 3.0), r.uniform(0.5, 2.0)),
    "wander": lambda k, r: Wander(k * r.uniform(0.06, 0.15)),
    "pressure-ripple": lambda k, r: PressureRipple(
        k * r.uniform(0.5, 1.2), r.uniform(25.0, 60.0), r.uniform(0, 2 * pi)
    ),
    "sampled-regulator": _sampled_regulator,
    "valve-current": lambda k, r: ValveCurrent(k * sign(r) * r.uniform(1.5, 3.5)),
    "gain-drift": lambda k, r: GainDrift(k * sign(r) * r.uniform(0.015, 0.04), r.uniform(20.0, 60.0)),
    "speed-noise": lambda k, r: SpeedNoise(k * r.uniform(0.05, 0.15)),
    "burst-noise": lambda k, r: BurstNoise(1.0 + k * r.uniform(3.0, 6.0), r.uniform(4.0, 10.0)),
}
