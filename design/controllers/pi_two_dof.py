"""PI with two degrees of freedom: a weighted reference and a filtered angle beside the gains.

The standard form of the field (Astrom & Hagglund, Advanced PID Control, 2006):

    command = (rest_pressure + Kp (b r - yf) + Ki integral((r - yf) dt)) / gain, clipped to the range,

where yf is the measured angle behind a first-order lag Tf.  The paper's PI is b = 1 and Tf = 0.  The weight
b changes the response to the reference alone, and no margin: the loop sees neither.  Below 1 it softens a
step; above 1 it gives a step's pressure at once that the integrator would have to gather.
The integrator stands still while the command is clipped, as that of `design.controllers.pi`.
"""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from design.controllers.controller import Measured, remembers
from design.controllers.pi import PI
from plants.wrist import SAMPLE_TIME, Wrist

Number = Any


@dataclass(frozen=True)
class TwoDofPI(PI):
    """Settings: gains and range as of a `PI`, reference weight b [1], time constant Tf [s] of the filter of
    the angle.

    Raises ValueError for gains, a weight or a time constant that are negative or not finite.
    """

    TUNED: ClassVar[tuple[str, ...]] = ("b", "Tf")

    b: Number = 1.0
    Tf: Number = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        more = np.concatenate([np.ravel(self.b), np.ravel(self.Tf)])
        if not (np.isfinite(more).all() and (more >= 0.0).all()):
            raise ValueError("b and Tf must be finite and not negative")

    @property
    def pi(self) -> "TwoDofPI":
        """What closes the loop: itself, whose margins know of the filter."""
        return self

    @classmethod
    def of(cls, wrist: Wrist, Kp: Number, Ki: Number, b: Number = 1.0, Tf: Number = 0.0) -> "TwoDofPI":
        """The controller that knows of a wrist its regulator, its rest and the range of its command.

        >>> TwoDofPI.of(Wrist.flexion(), 2.0, 5.0, 1.5).b
        1.5
        """
        return cls(**vars(PI.of(wrist, Kp, Ki)), b=b, Tf=Tf)

    def sampled(self, dt: float = SAMPLE_TIME) -> Any:
        """Coefficients for a sample time `dt` [s]."""
        return SampledTwoDofPI(
            self.Kp, self.Ki * dt, self.b, self._share(dt), 1.0 / self.gain, self.rest_pressure, self.low,
            self.high,
        )  # fmt: skip

    def holding(self, pressure: Number, seen: Measured | None = None) -> Any:
        """The state in which the controller holds a pressure [kPa] while the error is zero, the filter at
        the angle that is seen.

        >>> c = TwoDofPI(2.0, 5.0, b=1.5)
        >>> seen = Measured(0.0, 10.0, 130.0)
        >>> after, command = c.sampled().act(c.holding(130.0, seen), seen)
        >>> round(float(command) * c.gain, 9)
        130.0
        """
        angle = 0.0 if seen is None else seen.angle
        return TwoDofPIState(pressure - self.rest_pressure - self.Kp * (self.b - 1.0) * angle, angle)

    def command(self, state: Any) -> Number:
        """The command [V] that a state gives while the error is zero."""
        weighted = self.Kp * (self.b - 1.0) * state.angle
        return (self.rest_pressure + weighted + state.integral) / self.gain

    def transfer(self, z: Any, dt: float = SAMPLE_TIME) -> Any:
        """What closes the loop: the filter, which acts without a delay on the sample it is given, and the
        PI's transfer function [V/deg]; as `design.controllers.pi.PI.transfer`."""
        return super().transfer(z, dt) * self._filter(z, dt)

    def swinging(self, held: Any, swing: Any, z: Any, dt: float = SAMPLE_TIME) -> Any:
        """As of a PI, the filtered angle [deg] one sample [s] behind what it is next."""
        filtered = swing * self._filter(z, dt)
        return super().swinging(held, filtered, z, dt)._replace(angle=held.angle + (filtered / z).imag)

    def _filter(self, z: Any, dt: float) -> Any:
        share = self._share(dt)
        return share * z / (z - (1.0 - share))

    def _share(self, dt: float) -> Any:
        """Of the way to the measured angle that the filter goes in a sample."""
        Tf = np.asarray(self.Tf, float)
        return np.where(Tf > 0.0, -np.expm1(-dt / np.where(Tf > 0.0, Tf, 1.0)), 1.0)[()]


class SampledTwoDofPI(NamedTuple):
    """Coefficients of the controller for one sample time."""

    Kp: Number
    Ki_dt: Number
    b: Number
    share: Number  # of the way to the measured angle that the filter goes in a sample
    volts_per_kPa: Number
    rest_pressure: Number
    low: Number
    high: Number

    def act(self, state: "TwoDofPIState", seen: Measured) -> tuple["TwoDofPIState", Number]:
        """The law of `step`."""
        return step(state, seen, self)

    def following(self, state: "TwoDofPIState", seen: Measured, command: Number) -> "TwoDofPIState":
        """The state from which the law gives a command [V] within its range at what is seen; its filter goes
        on."""
        angle = state.angle + self.share * (seen.angle - state.angle)
        proportional = self.Kp * (self.b * (seen.error + seen.angle) - angle)
        return TwoDofPIState(command / self.volts_per_kPa - self.rest_pressure - proportional, state.angle)


@remembers(
    integral=("kPa", "integral part of the command, gain included"),
    angle=("deg", "angle behind the filter"),
)
class TwoDofPIState(NamedTuple):
    """What the controller remembers: its integral part [kPa], gain included, and the filtered angle [deg]."""

    integral: Number
    angle: Number


def step(s: TwoDofPIState, seen: Measured, c: SampledTwoDofPI) -> tuple[TwoDofPIState, Number]:
    """State after, and command [V] of, one sample.

    >>> c = TwoDofPI(Kp=1.2, Ki=2.2, b=1.0, Tf=0.0).sampled()
    >>> state, command = step(TwoDofPIState(0.0, 0.0), Measured(15.0, 0.0, 100.0), c)
    >>> round(float(command), 3), float(state.integral)      # as the paper's PI
    (2.389, 0.033)
    """
    angle = s.angle + c.share * (seen.angle - s.angle)
    reference = seen.error + seen.angle
    error = reference - angle
    wanted = (c.rest_pressure + c.Kp * (c.b * reference - angle) + s.integral) * c.volts_per_kPa
    command = np.minimum(np.maximum(wanted, c.low), c.high)
    # The clipped part has the sign of the error that pushes further out.
    pushes_out = (wanted - command) * error > 0.0
    return TwoDofPIState(s.integral + np.where(pushes_out, 0.0, c.Ki_dt * error), angle), command
