"""Dead time: the pressure answers the command late, for the air has to travel through the tube."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.actuator import delay
from plants.actuator.delay import DelayLine, SampledDelay
from plants.effects.effect import Around, Effect, Linear, Number, parameter
from plants.meanings import remembers


@remembers(
    line=("kPa", "commanded pressure in the tube"),
    behind=("kPa", "commanded pressure behind the tube's lag"),
)
class Tube(NamedTuple):
    """The line, and the pressure [kPa] behind the tube's own lag."""

    line: DelayLine
    behind: Number


class SampledDeadTime(NamedTuple):
    """Delay in samples."""

    delay: SampledDelay

    def target(self, s: Tube, target: Number, around: Around) -> tuple[Tube, Number]:
        line, out = delay.step(s.line, target, self.delay)
        return Tube(line, out), out


class SampledTube(NamedTuple):
    """Delay in samples, and the share of the way that the lag goes in one."""

    delay: SampledDelay
    share: Number

    def target(self, s: Tube, target: Number, around: Around) -> tuple[Tube, Number]:
        line, out = delay.step(s.line, target, self.delay)
        behind = s.behind + self.share * (out - s.behind)
        return Tube(line, behind), behind


def _transport(z: Any, c: SampledDelay) -> Any:
    """Frequency response of a delay line at points z = exp(j omega dt)."""
    return z**-c.samples * (1.0 - c.share + c.share / z)


class _Late(Effect):
    """What the forms share."""

    NAME = "dead-time"
    STAGE = "regulator"
    HAPPENS = "The pressure answers the command late"
    COMMON = True
    DELAY = "delay"
    BOUND = "kept"

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Tube:
        return Tube(delay.at_rest(pressure), pressure)


@dataclass(frozen=True)
class DeadTime(_Late):
    """Pure transport: the regulator sees the command `delay` [s] late.

    >>> DeadTime(0.05).values
    {'dead-time.delay': 0.05}
    """

    FORM = "transport"

    delay: Number = parameter("s", "transport delay", 0.0, 1.0, 0.0, (0.01, 0.03, 0.08, 0.15, 0.35, 0.7))

    def sampled(self, wrist: Any, dt: float) -> SampledDeadTime:
        return SampledDeadTime(delay.sampled(self.delay, dt))

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        return Linear(command=_transport(z, delay.sampled(self.delay, dt)))

    @property
    def only_delays(self) -> bool:
        return True


@dataclass(frozen=True)
class TubeDeadTime(_Late):
    """Transport and the filling of the tube: a delay, then a first-order lag, both in s."""

    FORM = "transport and tube lag"

    delay: Number = parameter("s", "transport delay", 0.0, 1.0, 0.0, (0.01, 0.05, 0.1, 0.35, 0.7))
    lag: Number = parameter("s", "time constant of the tube's filling", 0.0, 0.2, 0.0, (0.01, 0.04))

    def sampled(self, wrist: Any, dt: float) -> SampledTube:
        return SampledTube(delay.sampled(self.delay, dt), -np.expm1(-dt / np.maximum(self.lag, 1e-9)))

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        c = self.sampled(wrist, dt)
        return Linear(command=_transport(z, c.delay) * c.share * z / (z - 1.0 + c.share))

    @property
    def only_delays(self) -> bool:
        return not np.any(self.lag)

    def lags(self, wrist: Any) -> tuple[Number, ...]:
        return (self.lag,)
