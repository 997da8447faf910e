"""Rate dependence: the loop is wider when the pressure moves faster.

Friction in the braid and the bladder's viscosity hold the wrist back the more
the faster it is driven.  Where friction remembers (it takes time to build up
and to decay), the width follows the rate behind a lag.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Nothing, Number, parameter
from plants.meanings import remembers


class Saturating(NamedTuple):
    """Widening of each half of the loop per rate [deg s/kPa], 1 / rate at which it saturates [s/kPa]."""

    widening: Number
    per_limit: Number

    def at(self, rate: Number) -> Number:
        """Widening [deg] of each half at a rate [kPa/s]."""
        return self.widening * rate / (1.0 + rate * self.per_limit)


class PowerLaw(NamedTuple):
    """Widening of each half [deg] at a rate of 1, exponent."""

    widening: Number
    exponent: Number

    def at(self, rate: Number) -> Number:
        """Widening [deg] of each half at a rate, in half the range of the pressure a second."""
        return self.widening * np.maximum(rate, 1e-9) ** self.exponent


class SampledWidening(NamedTuple):
    """Rate per pressure moved in a sample, in the law's unit of the rate; how the widening follows it."""

    per_dt: Number
    law: Saturating | PowerLaw

    def bend(
        self, s: Nothing, before: Number, after: Number, loop: Any, around: Around
    ) -> tuple[Nothing, Number, Number, Number]:
        extra = self.law.at(np.abs(after - before) * self.per_dt)
        return s, -extra, extra, 1.0


@remembers(rate=("kPa/s", "rate that the friction has come to feel"))
class Remembered(NamedTuple):
    """The rate that the friction has come to feel [kPa/s]."""

    rate: Number


class SampledMemory(NamedTuple):
    """As `SampledWidening`, and the share of the way that the felt rate goes in one sample."""

    per_dt: Number
    law: Saturating
    share: Number

    def bend(
        self, s: Remembered, before: Number, after: Number, loop: Any, around: Around
    ) -> tuple[Remembered, Number, Number, Number]:
        rate = s.rate + self.share * (np.abs(after - before) * self.per_dt - s.rate)
        extra = self.law.at(rate)
        return Remembered(rate), -extra, extra, 1.0


class _Widening(Effect):
    """What the forms share: a loop that widens with the rate, so that the wrist goes no further than with
    a loop that does not."""

    NAME = "rate-dependence"
    STAGE = "wrist"
    HAPPENS = "The loop is wider when the pressure moves faster"
    BOUND = "taken away"

    widening: Number

    def no_bound(self, wrist: Any) -> str | None:
        if self.widening < 0.0:
            return "a loop that narrows with the rate rewards haste and slowness alike"
        return None


_WIDENING = parameter("deg s/kPa", "widening of each half of the loop per rate", -0.2, 0.5, 0.0, (0.01,))


@dataclass(frozen=True)
class Viscous(_Widening):
    """Each half of the loop widens in proportion to the rate of the pressure."""

    FORM = "proportional to the rate"

    widening: Number = _WIDENING

    def sampled(self, wrist: Any, dt: float) -> SampledWidening:
        return SampledWidening(1.0 / dt, Saturating(self.widening, 0.0))


@dataclass(frozen=True)
class SaturatingWidening(_Widening):
    """The widening saturates: rate / (1 + rate / limit), `limit` in kPa/s."""

    FORM = "saturating with the rate"

    widening: Number = parameter("deg s/kPa", "widening per rate, at low rates", -0.5, 2.0, 0.0, (0.03,))
    limit: Number = parameter(
        "kPa/s", "rate at which the widening is half its most", 2.0, 5e3, 5e3, (15.0, 60.0, 250.0)
    )

    def sampled(self, wrist: Any, dt: float) -> SampledWidening:
        return SampledWidening(1.0 / dt, Saturating(self.widening, 1.0 / np.asarray(self.limit, float)))


@dataclass(frozen=True)
class PowerWidening(_Widening):
    """The widening goes with a power of the rate, as friction of rubber does over decades of it."""

    FORM = "power of the rate"

    widening: Number = parameter(
        "deg", "widening of each half at half the range a second", -10.0, 20.0, 0.0, (1.0,)
    )
    exponent: Number = parameter("1", "exponent of the rate", 0.1, 2.0, 0.5, (0.3, 0.6, 1.4))

    def sampled(self, wrist: Any, dt: float) -> SampledWidening:
        return SampledWidening(1.0 / (wrist.rig.half_range * dt), PowerLaw(self.widening, self.exponent))


@dataclass(frozen=True)
class RememberedRate(_Widening):
    """Friction that remembers: the widening follows the rate behind a lag, and saturates."""

    FORM = "friction that remembers the rate"

    widening: Number = parameter("deg s/kPa", "widening per rate, at low rates", -0.5, 2.0, 0.0, (0.02,))
    limit: Number = parameter(
        "kPa/s", "rate at which the widening is half its most", 2.0, 5e3, 5e3, (30.0, 500.0)
    )
    memory: Number = parameter("s", "time constant of the friction", 0.002, 3.0, 0.05, (0.05, 0.3))

    def sampled(self, wrist: Any, dt: float) -> SampledMemory:
        share = -np.expm1(-dt / np.asarray(self.memory, float))
        return SampledMemory(1.0 / dt, Saturating(self.widening, 1.0 / np.asarray(self.limit, float)), share)

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Remembered:
        return Remembered(0.0)
