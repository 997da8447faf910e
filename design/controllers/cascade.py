"""Cascade: a PI of the angle whose output is a pressure, which a proportional inner loop holds.

    p* = rest_pressure + Kp (b r - y) + Ki integral((r - y) dt),
    command = (p* + Kc (p* - p)) / gain, clipped to the range,

where p is the measured pressure and b the weight of the reference, as of `design.controllers.pi_two_dof`.  A
regulator that follows its command at a rate k follows p* at the rate (1 + Kc) k (Astrom & Hagglund, Advanced
PID Control, 2006, on cascade control).  Kc = 0 is the PI with two degrees of freedom.  The inner loop has no
integrator: where `gain` is not right, the outer one takes out what is left.  That stands still while the
command is clipped, as the integrator of `design.controllers.pi`.
"""

from dataclasses import dataclass, fields
from typing import Any, ClassVar, NamedTuple

import numpy as np

from design.controllers.controller import Measured, remembers
from design.controllers.pi import PI
from plants.wrist import SAMPLE_TIME, Wrist

Number = Any


@dataclass(frozen=True)
class CascadePI:
    """Settings: gains Kp [kPa/deg], Ki [kPa/(deg s)] of the outer loop, Kc [1] of the inner one, reference
    weight b [1]; floats or arrays of lanes.

    gain [kPa/V] and rest_pressure [kPa] are what the controller knows of the regulator; low and high [V]
    bound the command.  Raises ValueError for a gain or a weight that is negative or not finite.
    """

    TUNED: ClassVar[tuple[str, ...]] = ("b", "Kc")
    """Settings beside the outer gains that a tuning chooses."""

    Kp: Number
    Ki: Number
    b: Number = 1.0
    Kc: Number = 0.0
    gain: Number = PI.gain
    rest_pressure: Number = PI.rest_pressure
    low: Number = PI.low
    high: Number = PI.high

    def __post_init__(self) -> None:
        for f in fields(self)[:4]:
            value = np.asarray(getattr(self, f.name), float)
            if not (np.isfinite(value).all() and (value >= 0.0).all()):
                raise ValueError(f"{f.name} must be finite and not negative")

    @classmethod
    def of(cls, wrist: Wrist, Kp: Number, Ki: Number, b: Number = 1.0, Kc: Number = 0.0) -> "CascadePI":
        """The controller that knows of a wrist its regulator, its rest and the range of its command.

        >>> CascadePI.of(Wrist.flexion(), 2.0, 5.0, Kc=3.0).Kc
        3.0
        """
        low, high = wrist.rig.command_range
        return cls(Kp, Ki, b, Kc, wrist.regulator.gain, wrist.hysteresis.rest_pressure, low, high)

    def sampled(self, dt: float = SAMPLE_TIME) -> "SampledCascadePI":
        """Coefficients for a sample time `dt` [s]."""
        return SampledCascadePI(
            self.Kp, self.Ki * dt, self.b, self.Kc, 1.0 / self.gain, self.rest_pressure, self.low, self.high
        )

    def holding(self, pressure: Number, seen: Measured | None = None) -> "CascadePIState":
        """The state in which the controller holds a pressure [kPa] while the error is zero; the pressure that
        is seen may differ from it, since the gain is not known exactly.

        >>> c, seen = CascadePI(2.0, 5.0, b=1.5, Kc=4.0), Measured(0.0, 10.0, 128.0)
        >>> after, command = c.sampled().act(c.holding(130.0, seen), seen)
        >>> round(float(command) * c.gain, 9)
        130.0
        """
        angle, own = (0.0, pressure) if seen is None else (seen.angle, seen.pressure)
        target = (pressure + self.Kc * own) / (1.0 + self.Kc)
        return CascadePIState(target - self.rest_pressure - self.Kp * (self.b - 1.0) * angle, angle, own)

    def command(self, state: "CascadePIState") -> Number:
        """The command [V] that a state gives while the error is zero and nothing moves."""
        target = self.rest_pressure + self.Kp * (self.b - 1.0) * state.angle + state.integral
        return (target + self.Kc * (target - state.pressure)) / self.gain

    def open_loop(self, angle: Any, pressure: Any, z: Any, dt: float = SAMPLE_TIME) -> Any:
        """The loop, broken at the command: what comes back by way of angle and pressure, whose responses to
        the command [deg/V], [kPa/V] at points z are given; as `design.controllers.pi.PI.open_loop`."""
        outer = PI(self.Kp, self.Ki, self.gain).open_loop(angle, pressure, z, dt)
        return (1.0 + self.Kc) * outer + self.Kc / self.gain * pressure


class SampledCascadePI(NamedTuple):
    """Coefficients of the controller for one sample time."""

    Kp: Number
    Ki_dt: Number
    b: Number
    Kc: Number
    volts_per_kPa: Number
    rest_pressure: Number
    low: Number
    high: Number

    def act(self, state: "CascadePIState", seen: Measured) -> tuple["CascadePIState", Number]:
        """The law of `step`."""
        return step(state, seen, self)


@remembers(
    integral=("kPa", "integral part of the pressure that is wanted"),
    angle=("deg", "angle of the sample before"),
    pressure=("kPa", "pressure of the sample before"),
)
class CascadePIState(NamedTuple):
    """What the controller remembers: its integral part [kPa], and angle [deg] and pressure [kPa] of the
    sample before, from which it tells its command at rest."""

    integral: Number
    angle: Number
    pressure: Number


def step(s: CascadePIState, seen: Measured, c: SampledCascadePI) -> tuple[CascadePIState, Number]:
    """State after, and command [V] of, one sample.

    >>> c = CascadePI(Kp=1.2, Ki=2.2).sampled()
    >>> state, command = step(CascadePIState(0.0, 0.0, 100.0), Measured(15.0, 0.0, 100.0), c)
    >>> round(float(command), 3), float(state.integral)      # with Kc = 0 as the paper's PI
    (2.389, 0.033)
    """
    target = c.rest_pressure + c.Kp * (c.b * seen.reference - seen.angle) + s.integral
    wanted = (target + c.Kc * (target - seen.pressure)) * c.volts_per_kPa
    command = np.minimum(np.maximum(wanted, c.low), c.high)
    # The clipped part has the sign of the error that pushes further out.
    pushes_out = (wanted - command) * seen.error > 0.0
    integral = s.integral + np.where(pushes_out, 0.0, c.Ki_dt * seen.error)
    return CascadePIState(integral, seen.angle, seen.pressure), command
