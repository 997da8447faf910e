"""Any controller behind a check of what it is shown: a sample that no plant can have made holds its output.

    controller = Screened.of(LQI(...), wrist)

is a controller as the one within, for any loop; on plausible samples it does what that one does, to the bit.
The exported C does the same for every controller (`design.export`), the MPCs do it in every period
(`design.mpc.fallback`).
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from design.controllers.controller import Controller, Measured, remembers
from design.controllers.measurement.plausible import Channel, LastBelieved, SensorLimits, believed
from plants.kernel import pytrees
from plants.wrist import SAMPLE_TIME, Wrist

Number = Any


@dataclass(frozen=True)
class Screened:
    """A controller that holds its output on implausible samples of its sensors."""

    inner: Controller
    sensors: SensorLimits

    @classmethod
    def of(cls, inner: Controller, wrist: Wrist) -> "Screened":
        """A controller with the sensors of a wrist's rig."""
        return cls(inner, SensorLimits.of(wrist))

    @property
    def gain(self) -> Number:
        """The inner controller's [kPa/V]."""
        return self.inner.gain

    @property
    def low(self) -> Number:
        """Least command [V]."""
        return self.inner.low

    @property
    def high(self) -> Number:
        """Largest command [V]."""
        return self.inner.high

    def sampled(self, dt: float = SAMPLE_TIME) -> "SampledScreened":
        """Coefficients for a sample time `dt` [s]."""
        angle, pressure = self.sensors.angle, self.sensors.pressure
        return SampledScreened(self.inner.sampled(dt), angle.sampled(dt), pressure.sampled(dt))

    def holding(self, pressure: Number, seen: Measured | None = None) -> "ScreenedState":
        """The state in which the inner controller holds a pressure [kPa] at what is seen."""
        state = self.inner.holding(pressure, seen)
        at = Measured(0.0, 0.0, pressure) if seen is None else seen
        command = np.minimum(np.maximum(self.inner.command(state), self.low), self.high)
        return ScreenedState(state, LastBelieved(at.angle), LastBelieved(at.pressure), command)

    def command(self, state: "ScreenedState") -> Number:
        """The command [V] that a state gives while the error is zero."""
        return self.inner.command(state.inner)


@remembers(command=("V", "command of the last sample that was believed"))
class ScreenedState(NamedTuple):
    """State of the inner controller, the last readings that were believed, the last command [V]."""

    inner: Any
    angle: LastBelieved
    pressure: LastBelieved
    command: Number


class SampledScreened(NamedTuple):
    """Coefficients of the inner controller, and what each sensor can show from sample to sample."""

    inner: Any
    angle: Channel
    pressure: Channel

    def act(self, state: ScreenedState, seen: Measured) -> tuple[ScreenedState, Number]:
        """State after, and command [V] of, one sample; the ones before where it is not believed."""
        angle, a = believed(state.angle, seen.angle, self.angle)
        pressure, p = believed(state.pressure, seen.pressure, self.pressure)
        good = a * p
        # The law sees numbers that it can have been shown, also where its answer is dropped.
        shown = Measured(np.where(good > 0.5, seen.error, 0.0), angle.value, pressure.value)
        after, given = self.inner.act(state.inner, shown)
        pairs = zip(pytrees.leaves(after), pytrees.leaves(state.inner), strict=True)
        kept = pytrees.like(after, [np.where(good > 0.5, new, old) for new, old in pairs])
        command = np.where(good > 0.5, given, state.command)
        return ScreenedState(kept, angle, pressure, command), command
