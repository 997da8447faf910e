"""State feedback with integral action in velocity form, and an observer of the static angle.

While the command is not clipped the wrist has the states of `design.robustness.loop_model`,

    x = (r - y [deg],  h - y [deg],  q = gain v - P [kPa]),      d(gain v)/dt = w,

and the controller sets the speed of its command, w = Ke (r - y) + Kd (h - y) + Kq q.  A PI is
Ke = Ki, Kd = -Kp/Tw, Kq = 0.  Only y and P are measured.  The static angle is observed:

    dh'/dt = slope dP/dt + b^2 Tw (y - y'),      dy'/dt = (h' - y')/Tw + (2 b - 1/Tw) (y - y'),

with b the bandwidth (both poles of the error at -b [rad/s]) and `slope` a guess at that of the branch:
an error of it acts on h' like a disturbance in proportion to dP/dt, so that separation does not hold and
the loop with the observer has to be checked as a whole (`alternatives.lqi_design` does).  At rest y' = y = h'
whatever the slope.  What is left of q at rest, because the regulator's gain is not known exactly, is
taken out by a slow mean (`washout`, rad/s): without it there would be a steady error.

The loop starts from a step of the reference with a jump of the command, `jump` (r+ - r), as a PI does
with Kp: velocity feedback alone would ramp.  The integrated command itself is clipped, so that it never
winds up.  Astrom & Hagglund, Advanced PID Control (2006), on velocity form and windup; Anderson & Moore,
Optimal Control: Linear Quadratic Methods (1990), on what an observer does to the margins.
"""

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np

from design.controllers.controller import Measured, remembers
from design.controllers.double_pole import double_pole
from plants import lag
from plants.parameters.files import built_in
from plants.wrist import COMMAND_RANGE, SAMPLE_TIME, Wrist

Number = Any
_PAPER = built_in("flexion").values

WASHOUT = 0.3
"""Rate [rad/s] at which the controller unlearns what the regulator's gain is off by.  Assumed."""


@dataclass(frozen=True)
class LQI:
    """Gains Ke [kPa/(deg s)], Kd [kPa/(deg s)], Kq [1/s], jump [kPa/deg]; what the controller believes
    of the plant, slope [deg/kPa], Tw [s], gain [kPa/V]; bandwidth of its observer and washout [rad/s].

    Floats or arrays of lanes; low and high [V] bound the command.  Raises ValueError for a setting that
    is not finite, and for a Ke, slope, Tw, bandwidth or gain that is not positive.
    """

    Ke: Number
    Kd: Number
    Kq: Number
    jump: Number
    slope: Number
    Tw: Number
    bandwidth: Number
    washout: Number = WASHOUT
    gain: Number = _PAPER["gain"]
    low: Number = COMMAND_RANGE[0]
    high: Number = COMMAND_RANGE[1]

    def __post_init__(self) -> None:
        values = {f.name: np.asarray(getattr(self, f.name), float) for f in fields(self)}
        positive = ("Ke", "slope", "Tw", "bandwidth", "gain")
        if not all(np.isfinite(v).all() for v in values.values()):
            raise ValueError("settings of a state feedback must be finite")
        if not all((values[n] > 0.0).all() for n in positive):
            raise ValueError(f"{', '.join(positive)} must be positive")

    @classmethod
    def of(cls, wrist: Wrist, Ke: Number, Kd: Number, Kq: Number, jump: Number, bandwidth: Number) -> "LQI":
        """The controller of a wrist, with an observer that takes every branch for the mean of the lines.

        >>> round(LQI.of(Wrist.flexion(), 600.0, -640.0, -70.0, 8.0, 45.0).slope, 3)
        0.36
        """
        slope = 0.5 * float(sum(wrist.hysteresis.steepness))
        low, high = wrist.rig.command_range
        return cls(
            Ke, Kd, Kq, jump, slope, float(wrist.Tw), bandwidth, gain=float(wrist.regulator.gain), low=low,
            high=high,
        )  # fmt: skip

    def sampled(self, dt: float = SAMPLE_TIME) -> "SampledLQI":
        """Coefficients for a sample time `dt` [s]."""
        c = lag.sampled(self.Tw, dt)
        # Both poles of the observer's error at exp(-b dt).  Its matrix before the correction is
        # [[1, 0], [before + after, keep]] in (h', y'), and the correction sees the prediction.
        correct_y, correct_h = double_pole(c.keep, np.exp(-self.bandwidth * dt))
        return SampledLQI(
            self.Ke * dt, self.Kd * dt, self.Kq * dt, self.jump, self.slope, c, correct_h, correct_y,
            -np.expm1(-self.washout * dt), self.low * self.gain, self.high * self.gain, 1.0 / self.gain,
        )  # fmt: skip

    def holding(self, pressure: Number, seen: Measured | None = None) -> "LQIState":
        """The state in which the controller holds a pressure [kPa] while the error is zero, the observer
        at rest at the angle that is seen; what it sees of the pressure may be off by the gain.

        >>> c = LQI(Ke=8.0, Kd=-15.0, Kq=-1.0, jump=2.0, slope=0.36, Tw=0.16, bandwidth=20.0)
        >>> state = c.holding(130.0, Measured(0.0, 5.0, 128.0))
        >>> after, command = c.sampled().act(state, Measured(0.0, 5.0, 128.0))
        >>> round(float(command) * 49.4, 9), after == state
        (130.0, True)
        """
        seen = Measured(0.0, 0.0, pressure) if seen is None else seen
        return LQIState(
            pressure, seen.angle, seen.angle, seen.pressure, pressure - seen.pressure, seen.reference
        )

    def command(self, state: "LQIState") -> Number:
        """The command [V] that a state gives while nothing moves."""
        return state.target / self.gain


@remembers(
    target=("kPa", "pressure that is commanded"),
    static_angle=("deg", "static angle as observed"),
    angle=("deg", "angle as observed"),
    pressure=("kPa", "pressure of the sample before"),
    lack=("kPa", "mean of commanded less measured pressure"),
    reference=("deg", "reference of the sample before"),
)
class LQIState(NamedTuple):
    """What the controller remembers: pressure that it commands [kPa], static and measured angle as
    observed [deg], pressure of the sample before [kPa], mean of the lack q [kPa], reference [deg]."""

    target: Number
    static_angle: Number
    angle: Number
    pressure: Number
    lack: Number
    reference: Number


class SampledLQI(NamedTuple):
    """Coefficients of the controller for one sample time; Ke, Kd and Kq times it."""

    Ke: Number
    Kd: Number
    Kq: Number
    jump: Number
    slope: Number
    lag: lag.SampledLag
    correct_h: Number
    correct_y: Number
    forget: Number
    low: Number  # kPa
    high: Number  # kPa
    volts_per_kPa: Number

    def act(self, state: LQIState, seen: Measured) -> tuple[LQIState, Number]:
        """The law of `step`."""
        return step(state, seen, self)


def step(s: LQIState, seen: Measured, c: SampledLQI) -> tuple[LQIState, Number]:
    """State after, and command [V] of, one sample."""
    ahead = s.static_angle + c.slope * (seen.pressure - s.pressure)
    predicted = lag.step(s.angle, s.static_angle, ahead, c.lag)
    off = seen.angle - predicted
    static_angle, angle = ahead + c.correct_h * off, predicted + c.correct_y * off

    q = s.target - seen.pressure
    lack = s.lack + c.forget * (q - s.lack)
    speed = c.Ke * seen.error + c.Kd * (static_angle - angle) + c.Kq * (q - lack)
    wanted = s.target + c.jump * (seen.reference - s.reference) + speed
    target = np.minimum(np.maximum(wanted, c.low), c.high)
    after = LQIState(target, static_angle, angle, seen.pressure, lack, seen.reference)
    return after, target * c.volts_per_kPa
