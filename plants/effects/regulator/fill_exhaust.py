"""Fill/exhaust asymmetry: the regulator fills and exhausts at different speeds.

Exhausting through an orifice the flow follows the pressure above the outside's,
filling through one it follows what the supply has in hand, so that either speed
may change with the pressure (ISO 6358; below the critical ratio the flow is
proportional to the pressure upstream).
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Linear, Nothing, Number, parameter

SLOWEST = 0.02
"""No valve is slower than this share of its nominal rate."""


class SampledAsymmetry(NamedTuple):
    """Factors of the rate at 100 kPa gauge, and their change per kPa."""

    fill: Number
    fill_slope: Number
    exhaust: Number
    exhaust_slope: Number

    def valve(self, s: Nothing, pressure: Number, error: Number, around: Around) -> tuple[Number, Number]:
        x = pressure - 100.0
        speed = np.where(error > 0.0, self.fill + self.fill_slope * x, self.exhaust + self.exhaust_slope * x)
        return error, np.maximum(speed, SLOWEST)


@dataclass(frozen=True)
class _TwoValves(Effect):
    """What the forms share."""

    NAME = "fill-exhaust-asymmetry"
    STAGE = "regulator"
    HAPPENS = "The regulator fills and exhausts at different speeds"
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
        return SampledAsymmetry(1.0, 0.0, self.ratio, 0.0)


@dataclass(frozen=True)
class PressureDependentRates(_TwoValves):
    """Both speeds change linearly with the pressure: factors 1 + fill x and ratio (1 + exhaust x)
    with x = (P - 100 kPa) / 100 kPa."""

    FORM = "rates that depend on the pressure"

    ratio: Number = parameter("1", "rate of exhausting over rate of filling", 0.1, 5.0, 1.0, (0.7, 1.4))
    fill: Number = parameter("1", "change of the filling rate per 100 kPa", -0.95, 3.0, 0.0, (-0.3, 0.0))
    exhaust: Number = parameter("1", "change of the exhausting rate per 100 kPa", -0.95, 3.0, 0.0, (0.0, 0.4))

    def sampled(self, wrist: Any, dt: float) -> SampledAsymmetry:
        return SampledAsymmetry(1.0, self.fill / 100.0, self.ratio, self.ratio * self.exhaust / 100.0)


class SampledOrifice(NamedTuple):
    """Factor of the rate of exhausting at 100 kPa, its exponent, and the pressure [kPa] added to the
    gauge's."""

    ratio: Number
    exponent: Number
    base: Number

    def valve(self, s: Nothing, pressure: Number, error: Number, around: Around) -> tuple[Number, Number]:
        relative = np.maximum((pressure + self.base) / (100.0 + self.base), 1e-3)
        return error, np.where(error > 0.0, 1.0, np.maximum(self.ratio * relative**self.exponent, SLOWEST))


@dataclass(frozen=True)
class OrificeExhaust(_TwoValves):
    """Exhaust through an orifice: its speed goes with a power of the pressure above the outside's."""

    FORM = "exhaust through an orifice"

    ratio: Number = parameter("1", "rate of exhausting over filling, at 100 kPa", 0.1, 5.0, 1.0, (0.7, 1.4))
    exponent: Number = parameter("1", "exponent of the gauge pressure", 0.0, 2.0, 0.0, (0.5, 1.0))
    base: Number = parameter("kPa", "pressure that drives the exhaust at 0 kPa gauge", 0.5, 200.0, 20.0)

    def sampled(self, wrist: Any, dt: float) -> SampledOrifice:
        return SampledOrifice(self.ratio, self.exponent, self.base)
