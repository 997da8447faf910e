"""PI controller of the wrist: angle error to command voltage.

The paper (section 6.1) controls the wrist with a PI controller and lost its
equations; whether it acts on volts or on kPa is not told.  This form is assumed:

    command = (rest_pressure + Kp e + Ki integral(e dt)) / gain, clipped to the range,

with e in deg, Kp in kPa/deg and Ki in kPa/(deg s).  The integrator stands still
while the command is clipped, unless the error drives it back into the range
(without that exception a controller with Kp = 0 would stay clipped for ever).
"""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from design.controllers.controller import Measured, remembers
from plants.parameters.files import built_in
from plants.wrist import COMMAND_RANGE, SAMPLE_TIME, Wrist

Number = Any
_PAPER = built_in("flexion").values


@dataclass(frozen=True)
class PI:
    """Gains of the controller: Kp [kPa/deg], Ki [kPa/(deg s)]; floats, or arrays with one entry per
    simulation.

    gain [kPa/V] and rest_pressure [kPa] are the controller's values of the regulator, by default those of the
    built-in wrist; low and high [V] bound the
    command.  Raises ValueError for gains
    that are negative or not finite.
    """

    TUNED: ClassVar[tuple[str, ...]] = ()
    """Settings beside the gains that a tuning chooses."""

    SENSORS: ClassVar[tuple[str, ...]] = ("angle",)

    Kp: Number
    Ki: Number
    gain: Number = _PAPER["gain"]
    rest_pressure: Number = _PAPER["rest_pressure"]
    low: Number = COMMAND_RANGE[0]
    high: Number = COMMAND_RANGE[1]

    def __post_init__(self) -> None:
        gains = np.concatenate([np.ravel(self.Kp), np.ravel(self.Ki)])
        if not (np.isfinite(gains).all() and (gains >= 0.0).all()):
            raise ValueError("gains must be finite and not negative")

    @property
    def pi(self) -> "PI":
        """The PI that closes the loop: itself."""
        return self

    @classmethod
    def of(cls, wrist: Wrist, Kp: Number, Ki: Number) -> "PI":
        """The controller that knows of a wrist its regulator, its rest and the range of its command.

        >>> PI.of(Wrist.flexion(), 3.1, 10.4) == PI(3.1, 10.4)
        True
        """
        low, high = wrist.rig.command_range
        return cls(Kp, Ki, wrist.regulator.gain, wrist.hysteresis.rest_pressure, low, high)

    def sampled(self, dt: float = SAMPLE_TIME) -> "SampledPI":
        """Coefficients for a sample time `dt` [s]."""
        return SampledPI(self.Kp, self.Ki * dt, 1.0 / self.gain, self.rest_pressure, self.low, self.high)

    def holding(self, pressure: Number, seen: Measured | None = None) -> "PIState":
        """The state in which the controller holds a pressure [kPa] while the error is zero, whatever
        is measured then."""
        return PIState(pressure - self.rest_pressure)

    def command(self, state: "PIState") -> Number:
        """The command [V] that a state gives while the error is zero."""
        return (self.rest_pressure + state.integral) / self.gain

    def transfer(self, z: Any, dt: float = SAMPLE_TIME) -> Any:
        """What closes the loop: the transfer function [V/deg] from the error to the command, not clipped, at
        points z or of a python-control z, for a sample time [s]; gains that are lanes go by broadcasting.

        >>> PI(2.0, 0.0, gain=50.0).transfer(1j)
        (0.04+0j)
        """
        return (self.Kp + self.Ki * dt / (z - 1.0)) * (1.0 / self.gain)

    def open_loop(self, angle: Any, pressure: Any, z: Any, dt: float = SAMPLE_TIME) -> Any:
        """The loop, broken at the command: what comes back by way of the angle, whose response to the command
        [deg/V] at points z is given; a PI does not measure the pressure [kPa/V]."""
        return self.transfer(z, dt) * angle

    def swinging(self, held: Any, swing: Any, z: Any, dt: float = SAMPLE_TIME) -> Any:
        """A state beside which the angle swings about a reference that stands: the imaginary part of swing
        [deg], which one sample [s] multiplies by z."""
        return held._replace(integral=held.integral - (self.Ki * dt / (z - 1.0) * swing).imag)


class SampledPI(NamedTuple):
    """Coefficients of the controller for one sample time."""

    Kp: Number
    Ki_dt: Number
    volts_per_kPa: Number
    rest_pressure: Number
    low: Number
    high: Number

    def act(self, state: "PIState", seen: Measured) -> tuple["PIState", Number]:
        """The law of `step`, for a loop that shows a controller more than the error."""
        return step(state, seen.error, self)

    def following(self, state: "PIState", seen: Measured, command: Number) -> "PIState":
        """The state from which the law gives a command [V] within its range at what is seen."""
        return PIState(command / self.volts_per_kPa - self.rest_pressure - self.Kp * seen.error)


@remembers(
    integral=("kPa", "integral part of the command, gain included"),
)
class PIState(NamedTuple):
    """What the controller remembers: its integral part [kPa], gain included."""

    integral: Number


def step(state: PIState, error: Number, c: SampledPI) -> tuple[PIState, Number]:
    """State after, and command [V] of, one sample with an angle error [deg].

    >>> state, command = step(PIState(0.0), 15.0, PI(Kp=1.2, Ki=2.2).sampled())
    >>> round(float(command), 3), float(state.integral)
    (2.389, 0.033)
    """
    wanted = (c.rest_pressure + c.Kp * error + state.integral) * c.volts_per_kPa
    command = np.minimum(np.maximum(wanted, c.low), c.high)
    # The clipped part has the sign of the error that pushes further out.
    pushes_out = (wanted - command) * error > 0.0
    return PIState(state.integral + np.where(pushes_out, 0.0, c.Ki_dt * error)), command
