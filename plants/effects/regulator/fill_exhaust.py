"""Fill/exhaust asymmetry: the regulator fills and exhausts at different speeds.

Exhausting through an orifice the flow follows the pressure above the outside's,
filling through one it follows what the supply has in hand, so that either speed
may change with the pressure (ISO 6358; below the critical ratio the flow is
proportional to the pressure upstream).  A valve that is fully open, or a small
pump, lets no more through however large the error is.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Linear, Nothing, Number, parameter

SLOWEST = 0.02
"""No valve is slower than this share of its nominal rate."""


class SampledAsymmetry(NamedTuple):
    """Factors of the rate in the middle of the range, their change per kPa, and that middle [kPa]."""

    fill: Number
    fill_slope: Number
    exhaust: Number
    exhaust_slope: Number
    middle: Number

    def valve(self, s: Nothing, pressure: Number, error: Number, around: Around) -> tuple[Number, Number]:
        x = pressure - self.middle
        speed = np.where(error > 0.0, self.fill + self.fill_slope * x, self.exhaust + self.exhaust_slope * x)
        return error, np.maximum(speed, SLOWEST)


@dataclass(frozen=True)
class _TwoValves(Effect):
    """What the forms share."""

    NAME = "fill-exhaust-asymmetry"
    STAGE = "regulator"
    HAPPENS = "The regulator fills and exhausts at different speeds"
    COMMON = True
    BOUND = "kept"

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        valve, quiet = self.sampled(wrist, dt).valve, Around()
        # Filling and exhausting, at both ends of the pressures.
        speeds = [float(valve(Nothing(), p, e, quiet)[1]) for e in (1.0, -1.0) for p in reach]
        return Linear(rates=tuple(dict.fromkeys(speeds)))


@dataclass(frozen=True)
class TwoRates(_TwoValves):
    """Exhausting is `ratio` times as fast as filling, at any pressure."""

    FORM = "two rates"

    ratio: Number = parameter("1", "rate of exhausting over rate of filling", 0.1, 5.0, 1.0, (0.7, 1.4))

    def sampled(self, wrist: Any, dt: float) -> SampledAsymmetry:
        return SampledAsymmetry(1.0, 0.0, self.ratio, 0.0, wrist.rig.rest_pressure)


@dataclass(frozen=True)
class PressureDependentRates(_TwoValves):
    """Both speeds change linearly with the pressure: factors 1 + fill x and ratio (1 + exhaust x)
    with x = (P - middle) / half the range."""

    FORM = "rates that depend on the pressure"

    ratio: Number = parameter("1", "rate of exhausting over rate of filling", 0.1, 5.0, 1.0, (0.7, 1.4))
    fill: Number = parameter("1", "change of filling over half the range", -0.95, 3.0, 0.0, (-0.3, 0.0))
    exhaust: Number = parameter("1", "change of exhausting over half the range", -0.95, 3.0, 0.0, (0.0, 0.4))

    def sampled(self, wrist: Any, dt: float) -> SampledAsymmetry:
        half = wrist.rig.half_range
        return SampledAsymmetry(
            1.0, self.fill / half, self.ratio, self.ratio * self.exhaust / half, wrist.rig.rest_pressure
        )


class SampledOrifice(NamedTuple):
    """Factor of the rate of exhausting in the middle of the range, its exponent, the pressure [kPa] added to
    the gauge's, and that middle [kPa]."""

    ratio: Number
    exponent: Number
    base: Number
    middle: Number

    def valve(self, s: Nothing, pressure: Number, error: Number, around: Around) -> tuple[Number, Number]:
        relative = np.maximum((pressure + self.base) / (self.middle + self.base), 1e-3)
        return error, np.where(error > 0.0, 1.0, np.maximum(self.ratio * relative**self.exponent, SLOWEST))


@dataclass(frozen=True)
class OrificeExhaust(_TwoValves):
    """Exhaust through an orifice: its speed goes with a power of the pressure above the outside's."""

    FORM = "exhaust through an orifice"

    ratio: Number = parameter(
        "1", "rate of exhausting over filling, in the middle of the range", 0.1, 5.0, 1.0, (0.7, 1.4)
    )
    exponent: Number = parameter("1", "exponent of the gauge pressure", 0.0, 2.0, 0.0, (0.5, 1.0))
    base: Number = parameter("kPa", "pressure that drives the exhaust at 0 kPa gauge", 0.5, 200.0, 20.0)

    def sampled(self, wrist: Any, dt: float) -> SampledOrifice:
        return SampledOrifice(self.ratio, self.exponent, self.base, wrist.rig.rest_pressure)


class SampledLimits(NamedTuple):
    """Factor of the rate of exhausting; the largest changes of a sample in the middle of the range [kPa] up
    and down, their shares per kPa, and that middle [kPa]."""

    ratio: Number
    fill: Number
    fill_slope: Number
    exhaust: Number
    exhaust_slope: Number
    middle: Number

    def valve(self, s: Nothing, pressure: Number, error: Number, around: Around) -> tuple[Number, Number]:
        return error, np.where(error > 0.0, 1.0, self.ratio)

    def supply(self, s: Nothing, before: Number, after: Number) -> tuple[Nothing, Number]:
        x = before - self.middle
        most = self.fill * np.maximum(1.0 + self.fill_slope * x, SLOWEST)
        least = self.exhaust * np.maximum(1.0 + self.exhaust_slope * x, SLOWEST)
        return s, np.minimum(np.maximum(after, before - least), before + most)


@dataclass(frozen=True)
class FlowLimits(_TwoValves):
    """Neither filling nor exhausting is faster than the valve, or the pump, lets air through: limits of the
    pressure's rate, which change linearly with the pressure.  Near the commanded pressure exhausting is
    `ratio` times as fast as filling."""

    FORM = "a limit of the flow each way"
    RUGGED = True

    fill: Number = parameter(
        "kPa/s", "fastest filling, in the middle of the range", 0.05, 1e5, 1e5, (15.0, 60.0, 250.0, 1000.0)
    )
    exhaust: Number = parameter(
        "kPa/s", "fastest exhausting, in the middle of the range", 0.05, 1e5, 1e5, (15.0, 60.0, 250.0, 1000.0)
    )
    ratio: Number = parameter("1", "rate of exhausting over filling, near to the target", 0.1, 5.0, 1.0)
    fill_change: Number = parameter(
        "1", "change of the fastest filling over half the range", -1.0, 3.0, 0.0, (-0.5, 0.0)
    )
    exhaust_change: Number = parameter(
        "1", "change of the fastest exhausting over half the range", -1.0, 3.0, 0.0, (0.0, 0.5)
    )

    def sampled(self, wrist: Any, dt: float) -> SampledLimits:
        half = wrist.rig.half_range
        return SampledLimits(
            self.ratio, self.fill * dt, self.fill_change / half, self.exhaust * dt,
            self.exhaust_change / half, wrist.rig.rest_pressure,
        )  # fmt: skip
