"""Branch curvature: the branches of the loop are curved, not straight."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Linear, Nothing, Number, parameter
from plants.hysteresis import SIDES

OUTER = SIDES[:2]
"""Branches of the loop, outer ones.  Coefficients of the polynomials count in full at half the range of the
pressure from rest."""


STRAIGHT = 1.2
"""Half ranges from rest beyond which a smooth curve bends the lines no further."""


def _from_rest(wrist: Any, reach: tuple[float, float]) -> Any:
    """Pressures from rest, in units of half the range, (201,), where slopes are looked at."""
    return (np.linspace(*reach, 201) - wrist.hysteresis.rest_pressure) / wrist.rig.half_range


def _least_and_largest(slope: Any) -> tuple[float, float]:
    return float(np.min(slope)), float(np.max(slope))


class SampledWarp(NamedTuple):
    """Rest pressure and half the range [kPa]; quadratic and cubic coefficient of the pressure that acts."""

    rest_pressure: Number
    span: Number
    quadratic: Number
    cubic: Number

    def drive(
        self, s: Nothing, before: Number, after: Number, around: Around
    ) -> tuple[Nothing, Number, Number]:
        return s, self._warped(before), self._warped(after)

    def _warped(self, pressure: Number) -> Number:
        x = (pressure - self.rest_pressure) * (1.0 / self.span)
        return pressure + self.span * x * x * (self.quadratic + self.cubic * x)


class _Curved(Effect):
    """What the forms share; whether the lines stay at least as steep as the transit is looked at by who
    makes a bound."""

    NAME = "branch-curvature"
    STAGE = "wrist"
    HAPPENS = "The branches of the loop are curved"
    BOUND = "kept"
    FROM_REST = True


@dataclass(frozen=True)
class Polynomial(_Curved):
    """The pressure acts through a cubic: x (1 + quadratic x + cubic x^2), x = (P - rest) / half the range.

    One curve for both branches and the transit.
    """

    FORM = "cubic of the pressure"

    quadratic: Number = parameter("1", "share of the quadratic term", -0.45, 1.0, 0.0, (0.0, -0.1, 0.1))
    cubic: Number = parameter("1", "share of the cubic term", -0.33, 2.0, 0.0, (-0.15, 0.15))

    def sampled(self, wrist: Any, dt: float) -> SampledWarp:
        return SampledWarp(wrist.hysteresis.rest_pressure, wrist.rig.half_range, self.quadratic, self.cubic)

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        x = _from_rest(wrist, reach)
        slope = _least_and_largest(1.0 + x * (2.0 * self.quadratic + 3.0 * self.cubic * x))
        return Linear(slopes=dict.fromkeys(SIDES, slope))


class SampledSaturation(NamedTuple):
    """Rest pressure [kPa]; the pressure from rest [kPa] at which the response saturates, inverted."""

    rest_pressure: Number
    per_range: Number

    def drive(
        self, s: Nothing, before: Number, after: Number, around: Around
    ) -> tuple[Nothing, Number, Number]:
        return s, self._warped(before), self._warped(after)

    def _warped(self, pressure: Number) -> Number:
        x = pressure - self.rest_pressure
        return self.rest_pressure + np.tanh(x * self.per_range) / self.per_range


@dataclass(frozen=True)
class Saturation(_Curved):
    """The pressure acts through a hyperbolic tangent that saturates at `range` [kPa] from rest."""

    FORM = "saturation"

    # Null: at 1e6 kPa the tangent is straight to 1e-9 of the range, far below rounding of a log.
    range: Number = parameter("kPa", "pressure at which the response saturates", 40.0, 1e6, 1e6, (150.0,))

    def sampled(self, wrist: Any, dt: float) -> SampledSaturation:
        return SampledSaturation(wrist.hysteresis.rest_pressure, 1.0 / np.asarray(self.range, float))

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        slope = _least_and_largest(
            1.0 - np.tanh(_from_rest(wrist, reach) * wrist.rig.half_range / self.range) ** 2
        )
        return Linear(slopes=dict.fromkeys(SIDES, slope))


class SampledBow(NamedTuple):
    """Rest pressure and half the range [kPa]; quadratic and cubic of line 1 and of line 2 [deg]."""

    rest_pressure: Number
    span: Number
    bow1: Number
    bow2: Number
    cubic: Number

    def bend(
        self, s: Nothing, before: Number, after: Number, loop: Any, around: Around
    ) -> tuple[Nothing, Number, Number, Number]:
        x = (after - self.rest_pressure) * (1.0 / self.span)
        square, cube = x * x, self.cubic * x * x * x
        return s, self.bow1 * square + cube, self.bow2 * square + cube, 1.0


@dataclass(frozen=True)
class Bow(_Curved):
    """Each line has a bow of its own, and both the same cubic; the transit stays straight.

    All in deg at half the range from rest.
    """

    FORM = "bow of each line"

    bow1: Number = parameter("deg", "quadratic term of line 1", -15.0, 15.0, 0.0, (-2.0, 2.0))
    bow2: Number = parameter("deg", "quadratic term of line 2", -15.0, 15.0, 0.0, (-2.0, 2.0))
    cubic: Number = parameter("deg", "cubic term of both lines", -20.0, 40.0, 0.0, (0.0,))

    def sampled(self, wrist: Any, dt: float) -> SampledBow:
        return SampledBow(
            wrist.hysteresis.rest_pressure, wrist.rig.half_range, self.bow1, self.bow2, self.cubic
        )

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        x, added = _from_rest(wrist, reach), {}
        for side, bow in zip(OUTER, (self.bow1, self.bow2), strict=True):
            bend = x * (2.0 * bow + 3.0 * self.cubic * x) / wrist.rig.half_range  # deg/kPa
            added[side] = _least_and_largest(bend)
        return Linear(added=added)


class SampledCurve(NamedTuple):
    """Rest pressure and half the range [kPa]; shares of the Chebyshev polynomials of degree 2 to 7."""

    rest_pressure: Number
    span: Number
    shares: tuple[Number, ...]

    def bend(
        self, s: Nothing, before: Number, after: Number, loop: Any, around: Around
    ) -> tuple[Nothing, Number, Number, Number]:
        x = (after - self.rest_pressure) * (1.0 / self.span)
        x = np.minimum(np.maximum(x, -STRAIGHT), STRAIGHT)
        lower, here, curve = 1.0, x, 0.0
        for degree, share in enumerate(self.shares, start=2):
            lower, here = here, 2.0 * x * here - lower
            # Minus its value at rest, so that a wrist at rest stays at 0.
            curve = curve + share * (here - np.cos(degree * np.pi / 2.0))
        up, down = loop.steepness
        return s, up * self.span * curve, down * self.span * curve, 1.0


@dataclass(frozen=True)
class SmoothCurve(_Curved):
    """Both lines follow one smooth curve, the transit stays straight.

    Chebyshev polynomials T2 to T7 of (P - rest) / half the range, as shares of the line's
    rise over that; beyond 1.2 times half the range from rest the bend stays what it is there.
    """

    FORM = "smooth curve of the lines"

    t2: Number = parameter("1", "share of T2", -0.5, 0.5, 0.0, (0.0, 0.05))
    t3: Number = parameter("1", "share of T3", -0.5, 0.5, 0.0, (-0.05, 0.05))
    t4: Number = parameter("1", "share of T4", -0.3, 0.3, 0.0)
    t5: Number = parameter("1", "share of T5", -0.3, 0.3, 0.0, (0.0, 0.02))
    t6: Number = parameter("1", "share of T6", -0.2, 0.2, 0.0)
    t7: Number = parameter("1", "share of T7", -0.2, 0.2, 0.0)

    def sampled(self, wrist: Any, dt: float) -> SampledCurve:
        shares = (self.t2, self.t3, self.t4, self.t5, self.t6, self.t7)
        return SampledCurve(wrist.hysteresis.rest_pressure, wrist.rig.half_range, shares)

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        shares = [0.0, 0.0, self.t2, self.t3, self.t4, self.t5, self.t6, self.t7]
        x = _from_rest(wrist, reach)
        bend = np.polynomial.Chebyshev(shares).deriv()(np.clip(x, -STRAIGHT, STRAIGHT))
        straight = np.abs(x) > STRAIGHT  # there the slope is that of the lines; at its edge both are
        found = 0.0 * bend if straight.all() else np.append(bend, np.zeros(np.count_nonzero(straight)))
        return Linear(slopes=dict.fromkeys(OUTER, _least_and_largest(1.0 + found)))
