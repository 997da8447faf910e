"""Cross coupling: the other motion's pressure moves this angle."""

from dataclasses import dataclass
from typing import Any, NamedTuple

from plants.effects.effect import Around, Effect, Nothing, Number, parameter

REST = 100.0
"""Pressure of the other motion [kPa] that moves nothing."""


class SampledCoupling(NamedTuple):
    """Linear [deg/kPa] and quadratic [deg/kPa^2] coefficient."""

    gain: Number
    quadratic: Number

    def static(
        self, s: Nothing, before: Number, after: Number, around: Around
    ) -> tuple[Nothing, Number, Number]:
        x = around.other_pressure - REST
        shift = x * (self.gain + self.quadratic * x)
        return s, before + shift, after + shift


@dataclass(frozen=True)
class Coupling(Effect):
    """The static angle shifts by `gain` [deg/kPa] times the other pressure's distance from 100 kPa."""

    NAME = "cross-coupling"
    FORM = "shift of the angle"
    STAGE = "wrist"

    gain: Number = parameter("deg/kPa", "shift per kPa of the other motion", -0.5, 0.5, 0.0, (-0.02, 0.02))

    def sampled(self, wrist: Any, dt: float) -> SampledCoupling:
        return SampledCoupling(self.gain, 0.0)


@dataclass(frozen=True)
class QuadraticCoupling(Effect):
    """As `Coupling`, with a quadratic part, in deg at 100 kPa from rest."""

    NAME = "cross-coupling"
    FORM = "shift of the angle, quadratic"
    STAGE = "wrist"

    gain: Number = parameter("deg/kPa", "shift per kPa of the other motion", -0.5, 0.5, 0.0, (-0.02, 0.02))
    quadratic: Number = parameter(
        "deg", "quadratic shift at 100 kPa from rest", -20.0, 20.0, 0.0, (-1.0, 1.0)
    )

    def sampled(self, wrist: Any, dt: float) -> SampledCoupling:
        return SampledCoupling(self.gain, self.quadratic / 1e4)


class Offset(NamedTuple):
    """What the other motion added to the pressure in the last sample [kPa]."""

    pressure: Number


class SampledPressureCoupling(NamedTuple):
    """kPa per kPa of the other motion."""

    gain: Number

    def drive(
        self, s: Offset, before: Number, after: Number, around: Around
    ) -> tuple[Offset, Number, Number]:
        offset = self.gain * (around.other_pressure - REST)
        return Offset(offset), before + s.pressure, after + offset


@dataclass(frozen=True)
class PressureCoupling(Effect):
    """The other pressure adds to this one before the loop, so that it works the hysteresis too."""

    NAME = "cross-coupling"
    FORM = "offset of the pressure"
    STAGE = "wrist"

    gain: Number = parameter("1", "pressure added per kPa of the other motion", -0.8, 0.8, 0.0, (0.08, -0.08))

    def sampled(self, wrist: Any, dt: float) -> SampledPressureCoupling:
        return SampledPressureCoupling(self.gain)

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Offset:
        return Offset(0.0)
