"""Softening: the slope of the branches changes as the actuator is worked.

Rubber softens with its first large strains (Mullins, Rubber Chemistry and
Technology 42 (1969) 339), with work done on it, and as it warms.  The slopes of the
lines go by a factor 1 + depth (1 - exp(-w / scale)), where w is what the form
counts; that of the transit takes a share `transit` of it, and the half widths of
the loop may change along, by `width` in the same way.  Lines turn about where the wrist rests.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Linear, Number, parameter
from plants.meanings import remembers


@remembers(amount=("", "work or largest excursion [kPa], or time [s], that has softened it"))
class Worked(NamedTuple):
    """What has been counted so far: kPa for work and for the largest excursion, s for time."""

    amount: Number


class _Coefficients(NamedTuple):
    depth: Number
    width: Number
    transit: Number
    per_scale: Number
    dt: Number
    unmoved: Any = ()  # angle of the loop [deg] and pressure [kPa] at rest, where they are not the loop's


class _Softening(_Coefficients):
    def _bent(self, amount: Number, after: Number, loop: Any) -> tuple[Worked, Number, Number, Number]:
        share = 1.0 - np.exp(-amount * self.per_scale)
        soft, wide = self.depth * share, self.width * share
        (up, down), (below, above) = loop.rise(after), loop.halves(after)
        if self.unmoved:
            up, down = up - self.unmoved[0], down - self.unmoved[0]
        low, high = soft * up - wide * below, soft * down + wide * above
        return Worked(amount), low, high, 1.0 + self.transit * soft


class SampledByWork(_Softening):
    """Counts the travel of the pressure."""

    def bend(
        self, s: Worked, before: Number, after: Number, loop: Any, around: Around
    ) -> tuple[Worked, Number, Number, Number]:
        return self._bent(s.amount + np.abs(after - before), after, loop)


class SampledByTime(_Softening):
    """Counts time."""

    def bend(
        self, s: Worked, before: Number, after: Number, loop: Any, around: Around
    ) -> tuple[Worked, Number, Number, Number]:
        return self._bent(s.amount + self.dt, after, loop)


class SampledByLargest(_Softening):
    """Counts the largest excursion of the pressure from rest."""

    def bend(
        self, s: Worked, before: Number, after: Number, loop: Any, around: Around
    ) -> tuple[Worked, Number, Number, Number]:
        rest = self.unmoved[1] if self.unmoved else loop.rest_pressure
        return self._bent(np.maximum(s.amount, np.abs(after - rest)), after, loop)


_DEPTH = parameter("1", "change of the slopes in the end, as a share", -0.6, 1.0, 0.0, (-0.1, 0.1))
_WIDTH = parameter("1", "change of the half widths in the end, as a share", -0.9, 2.0, 0.0, (0.0, 0.1))

_TRANSIT = parameter("1", "share of the change that the transit's slope takes part in", -1.0, 3.0, 1.0)


@dataclass(frozen=True)
class _Form(Effect):
    NAME = "softening"
    STAGE = "wrist"
    HAPPENS = "The slopes change as the wrist is worked"

    depth: Number = _DEPTH
    width: Number = _WIDTH
    transit: Number = _TRANSIT

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Worked:
        return Worked(0.0)

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        """Fresh, and fully worked."""
        low, high = sorted((1.0, float(1.0 + self.depth)))
        least, most = sorted((1.0, float(1.0 + self.transit * self.depth)))
        return Linear(slopes={"ascending": (low, high), "descending": (low, high), "inner": (least, most)})

    def _coefficients(self, scale: Number, wrist: Any, dt: float) -> tuple[Any, ...]:
        return self.depth, self.width, self.transit, 1.0 / np.asarray(scale, float), dt, wrist.unmoved


@dataclass(frozen=True)
class SofteningByWork(_Form):
    """Softens with the travel of the pressure, on a `scale` in kPa."""

    FORM = "with the travel of the pressure"

    scale: Number = parameter("kPa", "travel that softens by 63 %", 20.0, 2e4, 800.0, (150.0, 500.0, 2000.0))

    def sampled(self, wrist: Any, dt: float) -> SampledByWork:
        return SampledByWork(*self._coefficients(self.scale, wrist, dt))


@dataclass(frozen=True)
class Warming(_Form):
    """Softens with time, on a `scale` in s."""

    FORM = "with time"

    scale: Number = parameter("s", "time that softens by 63 %", 1.0, 2000.0, 40.0, (10.0, 40.0, 150.0))

    def sampled(self, wrist: Any, dt: float) -> SampledByTime:
        return SampledByTime(*self._coefficients(self.scale, wrist, dt))


@dataclass(frozen=True)
class Mullins(_Form):
    """Softens with the largest excursion of the pressure so far, on a `scale` in kPa."""

    FORM = "with the largest excursion"

    scale: Number = parameter("kPa", "excursion that softens by 63 %", 3.0, 1000.0, 50.0, (20.0, 60.0, 200.0))

    def sampled(self, wrist: Any, dt: float) -> SampledByLargest:
        return SampledByLargest(*self._coefficients(self.scale, wrist, dt))
