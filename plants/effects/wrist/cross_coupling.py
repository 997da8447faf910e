"""Cross coupling: the other motion's pressure moves this angle."""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from plants.effects.effect import Around, Effect, Nothing, Number, parameter
from plants.meanings import remembers


class SampledCoupling(NamedTuple):
    """Linear [deg/kPa] and quadratic [deg/kPa^2] coefficient."""

    gain: Number
    quadratic: Number

    def static(
        self, s: Nothing, before: Number, after: Number, around: Around
    ) -> tuple[Nothing, Number, Number]:
        x = around.other_pressure
        shift = x * (self.gain + self.quadratic * x)
        return s, before + shift, after + shift


class _Coupled(Effect):
    """What the forms share."""

    NAME = "cross-coupling"
    STAGE = "wrist"
    HAPPENS = "The other motion moves this angle"
    LOG: ClassVar = {"other_pressure_kPa": "the other motion's pressure"}
    BOUND = "kept"


@dataclass(frozen=True)
class Coupling(_Coupled):
    """The static angle shifts by `gain` [deg/kPa] times the other pressure's distance from rest."""

    FORM = "shift of the angle"

    gain: Number = parameter("deg/kPa", "shift per kPa of the other motion", -0.5, 0.5, 0.0, (-0.02, 0.02))

    def sampled(self, wrist: Any, dt: float) -> SampledCoupling:
        return SampledCoupling(self.gain, 0.0)


@dataclass(frozen=True)
class QuadraticCoupling(_Coupled):
    """As `Coupling`, with a quadratic part, in deg at half the range of the pressure from rest."""

    FORM = "shift of the angle, quadratic"

    gain: Number = parameter("deg/kPa", "shift per kPa of the other motion", -0.5, 0.5, 0.0, (-0.02, 0.02))
    quadratic: Number = parameter(
        "deg", "quadratic shift at half the range from rest", -20.0, 20.0, 0.0, (-1.0, 1.0)
    )

    def sampled(self, wrist: Any, dt: float) -> SampledCoupling:
        return SampledCoupling(self.gain, self.quadratic / wrist.rig.half_range**2)


@remembers(pressure=("kPa", "what the other motion added to the pressure"))
class Offset(NamedTuple):
    """What the other motion added to the pressure in the last sample [kPa]."""

    pressure: Number


class SampledPressureCoupling(NamedTuple):
    """kPa per kPa of the other motion."""

    gain: Number

    def drive(
        self, s: Offset, before: Number, after: Number, around: Around
    ) -> tuple[Offset, Number, Number]:
        offset = self.gain * around.other_pressure
        return Offset(offset), before + s.pressure, after + offset


@dataclass(frozen=True)
class PressureCoupling(_Coupled):
    """The other pressure adds to this one before the loop, so that it works the hysteresis too."""

    FORM = "offset of the pressure"

    gain: Number = parameter("1", "pressure added per kPa of the other motion", -0.8, 0.8, 0.0, (0.08, -0.08))

    def sampled(self, wrist: Any, dt: float) -> SampledPressureCoupling:
        return SampledPressureCoupling(self.gain)

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Offset:
        return Offset(0.0)
