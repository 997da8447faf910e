"""Fill/exhaust asymmetry: the regulator fills and exhausts at different speeds.

Exhausting through an orifice the flow follows the pressure above the outside's,
filling through one it follows what the supply has in hand, so that either speed
may change with the pressure (ISO 6358; below the critical ratio the flow is
proportional to the pressure upstream).  A valve that is fully open, or a small
pump, lets no more through however large the error is.  Where no regulator is, and the
command opens the valves or drives the pump, the pressure rests where as much flows in as out.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple, get_args

import numpy as np

from plants.effects.effect import Around, Effect, Linear, Nothing, Number, parameter
from plants.hysteresis import Side
from plants.rig import Rig

SLOWEST = 0.02
"""No valve is slower than this share of its nominal rate."""

SIDES: tuple[Side, ...] = get_args(Side)
"""Of a loop."""

NEAR_EMPTY = 0.01
"""Share of half the range of the pressure, above the outside's, below which the exhaust is linear."""

LEAST_CHANGE = 2.0
"""Factor by which gain or rate of valves without a regulator change over the pressures: 10 to 14 of a bellows
and a finger that were simulated with such valves, 1.3 of a regulator that this form was fitted to."""


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
    HAPPENS = "The flow in and out is limited"
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


class SampledOpenings(NamedTuple):
    """Rates of filling and exhausting in one sample, with valves that are open; the share by which filling
    closes the exhaust; pressures of supply and outside [kPa]; the exponent of the exhaust; half the range of
    the pressure [kPa]; the commanded pressure [kPa] at the lowest command, and shares of the way to the
    largest per kPa."""

    fill: Number
    exhaust: Number
    closes: Number
    full: Number
    outside: Number
    exponent: Number
    half: Number
    lowest: Number
    per_kPa: Number

    def chamber(self, s: Nothing, before: Number, target: Number, after: Number) -> Number:
        opened = np.minimum(np.maximum((target - self.lowest) * self.per_kPa, 0.0), 1.0)
        filling, exhausting = self.fill * opened, self.exhaust * (1.0 - self.closes * opened)
        above = np.maximum(before - self.outside, 0.0) / self.half
        # Next to the outside's pressure a power has an infinite slope, and no more can flow than there is.
        inside = np.maximum(above, NEAR_EMPTY)
        lost = np.minimum(exhausting * inside**self.exponent, 0.5 * inside) * np.minimum(above / inside, 1.0)
        change = filling * np.maximum(self.full - before, 0.0) - self.half * lost
        slope = filling + exhausting * self.exponent * inside ** (self.exponent - 1.0)
        moved = before + change / (1.0 + 0.5 * slope)  # to second order, and stable
        return np.where(self.fill > 0.0, moved, after)


@dataclass(frozen=True)
class CommandedOpenings(_TwoValves):
    """No regulator: the command opens the filling valve, or drives a pump, and may close the exhaust.

    With u the command's share of its range and H half the range of the pressure, dP/dt is
    fill u (supply - P) - exhaust (1 - closes u) H ((P - outside) / H)^exponent; the rates of the regulator
    have no part in it.  Linear and with `closes` 1, `exhaust` as `fill`, it is a first-order lag.
    Where `fill` is zero the effect is absent.
    """

    FORM = "valves opened by the command"
    HAPPENS = "The command opens the valves without a regulator of the pressure"
    RUGGED = True
    REGULATES = False
    SUPPLIES = True

    fill: Number = parameter(
        "1/s", "rate of filling at the largest command, per difference of pressure", 0.0, 500.0, 0.0,
        (1.0, 4.0, 15.0),
    )  # fmt: skip
    exhaust: Number = parameter(
        "1/s", "rate of exhausting through the open valve", 0.0, 500.0, 0.0, (1.0, 4.0, 15.0)
    )
    supply: Number = parameter("kPa", "pressure at which nothing flows in", -200.0, 2000.0, 200.0)
    outside: Number = parameter("kPa", "pressure at which nothing flows out", -400.0, 400.0, 0.0)
    exponent: Number = parameter(
        "1", "exponent of the pressure that drives the exhaust", 0.2, 2.0, 1.0, (0.5, 1.0)
    )
    closes: Number = parameter(
        "1", "share by which the largest command closes the exhaust", 0.0, 1.0, 1.0, (0.0, 1.0)
    )

    @classmethod
    def trials(cls, rig: Rig | None = None) -> Iterator[dict[str, float]]:
        """The trial values, with pressures of supply and outside about the range of the rig's."""
        low, high = cls.pressures(rig)
        for given, beyond in product(super().trials(rig), (0.03, 0.3, 1.5)):
            full = high + beyond * (high - low)
            yield {**given, "supply": full, "outside": low - 0.02 * (high - low)}

    def sampled(self, wrist: Any, dt: float) -> SampledOpenings:
        low, high = (wrist.regulator.gain * v for v in wrist.rig.command_range)
        return SampledOpenings(
            self.fill * dt, self.exhaust * dt, self.closes, self.supply, self.outside, self.exponent,
            wrist.rig.half_range, low, 1.0 / np.maximum(high - low, 1e-9),  # a command that never changed
        )  # fmt: skip

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        """Rates [1/s] and gains at both ends of the pressures [kPa] and amid them, each in equilibrium: the
        gain goes to the slopes of the loop."""
        low, high = (float(wrist.regulator.gain * v) for v in wrist.rig.command_range)
        rates, gains = self._within(reach, wrist.rig.half_range)
        within = min(gains) / (high - low), max(gains) / (high - low)
        return Linear(flows=(min(rates), max(rates)), slopes=dict.fromkeys(SIDES, within))

    def redundant(self, wrist: Any) -> bool:
        """A regulator has one gain and one rate; those of valves change with the pressure.  The supply of the
        valves is their own: beside another one they are a regulator's."""
        if any(e.SUPPLIES and e.NAME != self.NAME for e in wrist.effects):
            return True
        found = self._within(wrist.rig.pressure_range, wrist.rig.half_range)
        return not any(max(some) > LEAST_CHANGE * min(some) for some in found)

    def _within(self, reach: tuple[float, float], half: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Rates and gains of `_held` at both ends of some pressures [kPa] and amid them."""
        rates, gains = zip(*(self._held(p, half) for p in np.linspace(*reach, 5)), strict=True)
        return rates, gains

    def _held(self, pressure: float, half: float) -> tuple[float, float]:
        """Rate [1/s] of small motions about a pressure [kPa] that is held, and what the command's whole range
        would change it by [kPa], going on at that slope."""
        above = max((pressure - float(self.outside)) / half, NEAR_EMPTY)
        out, room = float(self.exhaust) * above ** float(self.exponent), float(self.supply) - pressure
        opened = half * out / max(float(self.fill) * room + half * out * float(self.closes), 1e-12)
        opened = min(max(opened, 0.0), 1.0)
        left = 1.0 - float(self.closes) * opened
        rate = float(self.fill) * opened + left * float(self.exponent) * out / above
        return rate, (float(self.fill) * max(room, 0.0) + half * out * float(self.closes)) / max(rate, 1e-9)
