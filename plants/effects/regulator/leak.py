"""Leak: air is lost, so that the pressure stands below what is commanded, and sags.

A porous bladder loses air in proportion to its gauge pressure, as a laminar flow does; a worn fitting or a
tear loses it through an orifice, whose flow goes with a power of the pressure: about the root while it
is slow, and more nearly the first power once it is choked (ISO 6358).  The chamber comes to rest where the
regulator gives what is lost, below the commanded pressure, the more so the slower the regulator is near it;
without a regulator, in a closed volume, it never does.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Nothing, Number, parameter
from plants.effects.hints import ExcitationHints
from plants.meanings import remembers

EMPTY = 1e-8
"""Share of the reference pressure at which nothing flows any more, so that a power of it has a slope."""

LEAST_EXPONENT = 0.3
"""Exponent of the pressure below which a loss is no flow; it is at least a half in an orifice."""


class SampledLaminarLeak(NamedTuple):
    """Share of the gauge pressure that is lost in one sample."""

    share: Number

    def supply(self, s: Nothing, before: Number, after: Number) -> tuple[Nothing, Number]:
        return s, after - self.share * np.maximum(before, 0.0)


class SampledPowerLeak(NamedTuple):
    """What is lost in one sample at a reference pressure, that pressure [kPa], and the exponent."""

    loss: Number
    reference: Number
    exponent: Number

    def supply(self, s: Nothing, before: Number, after: Number) -> tuple[Nothing, Number]:
        empty = EMPTY * self.reference
        inside = np.maximum(before, empty)
        lost = self.loss * (inside / self.reference) ** self.exponent
        # Where the power is steep, next to the outside's pressure, no more can flow than there is.
        return s, after - np.minimum(lost, np.where(before > empty, 0.5 * inside, 0.0))


class _Leak(Effect):
    """What the forms share.

    A leak takes gain from the regulator and makes it faster, so that margins without it are the narrower.
    """

    NAME = "leak"
    STAGE = "regulator"
    HAPPENS = "Air is lost"
    BOUND = "kept"
    LOSES = True

    def borrowed(self, asked: ExcitationHints) -> str | None:
        """Along one ramp what is lost and a gain that falls are the same."""
        if asked.ramp:
            return "the command is one ramp, along which a gain that falls does the same; record holds"
        return None


@dataclass(frozen=True)
class LaminarLeak(_Leak):
    """Air is lost in proportion to the gauge pressure: dP/dt falls by rate P, with `rate` in 1/s."""

    FORM = "in proportion to the pressure"

    rate: Number = parameter("1/s", "rate of the loss", 0.0, 5.0, 0.0, (0.01, 0.05, 0.2))

    def sampled(self, wrist: Any, dt: float) -> SampledLaminarLeak:
        return SampledLaminarLeak(-np.expm1(-np.asarray(self.rate, float) * dt))


@remembers(lost=("kPa", "pressure that the air lost so far would have given"))
class Lost(NamedTuple):
    """What the air lost so far would have given [kPa]."""

    lost: Number


class SampledSag(NamedTuple):
    """Share of the gauge pressure that is lost in one sample."""

    share: Number

    def target(self, s: Lost, target: Number, around: Around) -> tuple[Lost, Number]:
        return s, target - s.lost

    def supply(self, s: Lost, before: Number, after: Number) -> tuple[Lost, Number]:
        return Lost(s.lost + self.share * before), after


@dataclass(frozen=True)
class SealedLeak(_Leak):
    """A closed volume, such as that of a syringe, loses air that nothing replaces: what is commanded falls by
    rate P, with `rate` in 1/s, and rises below the pressure of the outside."""

    FORM = "out of a closed volume"
    LOSES = False
    SILENT = True

    rate: Number = parameter("1/s", "rate of the loss", 0.0, 1.0, 0.0, (0.001, 0.01))

    def sampled(self, wrist: Any, dt: float) -> SampledSag:
        return SampledSag(-np.expm1(-np.asarray(self.rate, float) * dt))

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Lost:
        return Lost(0.0)

    def no_bound(self, wrist: Any) -> str | None:
        return "the pressure sags for as long as it stands"


@dataclass(frozen=True)
class PowerLeak(_Leak):
    """Air is lost with a power of the gauge pressure, `flow` [kPa/s] at half the range of the pressure."""

    FORM = "with a power of the pressure"

    flow: Number = parameter("kPa/s", "loss at half the range", 0.0, 200.0, 0.0, (1.0, 5.0))
    exponent: Number = parameter("1", "exponent of the gauge pressure", 0.2, 3.0, 0.5, (0.3, 0.6, 2.0))

    def redundant(self, wrist: Any) -> bool:
        """What is lost alike at all pressures is an offset of the pressure."""
        return float(self.exponent) < LEAST_EXPONENT

    def sampled(self, wrist: Any, dt: float) -> SampledPowerLeak:
        return SampledPowerLeak(self.flow * dt, wrist.rig.half_range, self.exponent)
