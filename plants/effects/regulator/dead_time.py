"""Dead time: the pressure answers the command late, for the air has to travel through the tube."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.actuator import delay
from plants.actuator.delay import DelayLine, SampledDelay
from plants.effects.effect import Around, Effect, Linear, Number, parameter
from plants.meanings import remembers
from plants.second_order import NULL, second_order_hold


@remembers(
    line=("kPa", "commanded pressure in the tube"),
    behind=("kPa", "commanded pressure behind the tube's lag"),
)
class Tube(NamedTuple):
    """The line, and the pressure [kPa] behind the tube's own lag."""

    line: DelayLine
    behind: Number


@remembers(
    line=("kPa", "commanded pressure on its way to the valve"),
    behind=("kPa", "commanded pressure that the valve has taken up"),
    speed=("kPa/s", "rate of the commanded pressure that the valve has taken up"),
)
class LaggedTarget(NamedTuple):
    """The line, the pressure [kPa] behind a transient of second order, and its rate [kPa/s]."""

    line: DelayLine
    behind: Number
    speed: Number


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


class SampledSecondOrder(NamedTuple):
    """Delay in samples; what the pressure behind, its rate and the input that is held over the sample give
    to pressure and rate."""

    delay: SampledDelay
    yy: Number
    yv: Number
    yu: Number
    vy: Number
    vv: Number
    vu: Number

    def target(self, s: LaggedTarget, target: Number, around: Around) -> tuple[LaggedTarget, Number]:
        line, out = delay.step(s.line, target, self.delay)
        behind = self.yy * s.behind + self.yv * s.speed + self.yu * out
        speed = self.vy * s.behind + self.vv * s.speed + self.vu * out
        return LaggedTarget(line, behind, speed), behind


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

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Tube | LaggedTarget:
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


@dataclass(frozen=True)
class SecondOrderDeadTime(_Late):
    """Transport, and a regulator whose spool or inner loop swings: a delay, then
    inertia^2 P'' + 2 damping inertia P' + P = commanded pressure, `delay` and `inertia` in s.

    >>> SecondOrderDeadTime().values["dead-time.inertia"]
    0.0
    """

    FORM = "transport and a second-order lag"
    RUGGED = True

    delay: Number = parameter("s", "transport delay", 0.0, 1.0, 0.0, (0.01, 0.05, 0.15, 0.35))
    inertia: Number = parameter("s", "1 / natural frequency", 0.0, 0.3, 0.0, (0.02, 0.06))
    damping: Number = parameter("1", "damping ratio", 0.1, 1.5, 1.0, (0.7,))

    def sampled(self, wrist: Any, dt: float) -> SampledSecondOrder:
        late = delay.sampled(self.delay, dt)
        yy, yv, yb, ya, vy, vv, vb, va = second_order_hold(self.inertia, self._lag, dt)
        return SampledSecondOrder(late, yy, yv, yb + ya, vy, vv, vb + va)

    @property
    def _lag(self) -> Number:
        return 2.0 * self.damping * np.maximum(self.inertia, NULL)

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> LaggedTarget:
        return LaggedTarget(delay.at_rest(pressure), pressure, 0.0)

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        c = self.sampled(wrist, dt)
        # What leaves in a sample is what has come in during it: Cramer's rule, with z u as the input.
        determinant = (z - c.yy) * (z - c.vv) - c.yv * c.vy
        swings = z * (c.yu * (z - c.vv) + c.yv * c.vu) / determinant
        return Linear(command=_transport(z, c.delay) * swings)

    @property
    def only_delays(self) -> bool:
        return not np.any(self.inertia)

    def lags(self, wrist: Any) -> tuple[Number, ...]:
        """Two halves of the lag that it has at low frequencies."""
        return self.damping * self.inertia, self.damping * self.inertia

    def no_bound(self, wrist: Any) -> str | None:
        return "a regulator that swings is no monotone map" if float(self.damping) < 1.0 else None
