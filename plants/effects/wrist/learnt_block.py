"""What was learnt of a residual that no effect explains: a smooth map, added to the angle of the loop.

Cubic B-splines of the pressure (de Boor, A Practical Guide to Splines, 1978) in three parts: one of the
pressure alone, one that takes the sign of the direction in which it last moved, and one times the distance
from a pressure that follows slowly.  Outside the pressures that it was learnt on, each spline fades to
nothing.

It is no effect of the library, which has causes: a trace tries it only where it is asked to.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Linear, Number, parameter
from plants.hysteresis.law import SIDES
from plants.hysteresis.play import kept
from plants.meanings import remembers


@remembers(
    direction=("1", "direction in which the pressure last moved, from -1 to 1"),
    slow=("kPa", "pressure that follows slowly"),
    before=("deg", "what was added to the angle before the sample"),
    after=("deg", "what is added to the angle"),
)
class LearntMemory(NamedTuple):
    """Direction of the last motion, -1 to 1, the pressure that follows slowly [kPa], and what is added to the
    angle [deg] before the sample and after it."""

    direction: Number
    slow: Number
    before: Number
    after: Number


class SampledLearntBlock(NamedTuple):
    """Coefficients [deg] of the three parts; the first knot and half the range of the knots [kPa]; rest
    pressure [kPa] and the static part there [deg]; 1 / the way of a turn [1/kPa], share of the way that the
    slow pressure goes in a sample, 1 / half the range of the pressure [1/kPa]."""

    static_part: tuple[Number, ...]
    turning: tuple[Number, ...]
    slow: tuple[Number, ...]
    first: Number
    half: Number
    rest_pressure: Number
    at_rest: Number
    per_turn: Number
    share: Number
    per_range: Number

    @property
    def watches(self) -> bool:
        """It leaves the pressure that drives the loop as it is."""
        return True

    def drive(
        self, s: LearntMemory, before: Number, after: Number, around: Around
    ) -> tuple[LearntMemory, Number, Number]:
        direction = kept(s.direction + (after - before) * self.per_turn, -1.0, 1.0)
        slow = s.slow + self.share * (after - s.slow)
        added = self.added(after, direction, (after - slow) * self.per_range)
        return LearntMemory(direction, slow, s.after, added), before, after

    def static(
        self, s: LearntMemory, before: Number, after: Number, around: Around
    ) -> tuple[LearntMemory, Number, Number]:
        return s, before + s.before, after + s.after

    def added(self, pressure: Number, direction: Number, ahead: Number) -> Number:
        """What is added [deg] at a pressure, of which `ahead` is the distance from the slow one in half the
        range; at rest at the rest pressure nothing."""
        at = (pressure - self.first) / self.half
        moving = direction * curve(self.turning, at) + ahead * curve(self.slow, at)
        return self.still(pressure) + moving

    def still(self, pressure: Number) -> Number:
        """The static part [deg] at a pressure [kPa]."""
        wide = 0.5 * _per_knot(self.static_part)  # of two knots: a bump of one would be one of the splines
        away = spline((pressure - self.rest_pressure) / self.half * wide) / spline(0.0)
        return curve(self.static_part, (pressure - self.first) / self.half) - self.at_rest * away


def curve(coefficients: tuple[Number, ...], at: Number) -> Number:
    """The sum of splines at knots from 0 to 2."""
    place = at * _per_knot(coefficients)
    if isinstance(place, float | np.ndarray):  # all splines at once: searches for a rest ask often
        knots = np.arange(len(coefficients)).reshape(-1, *(1 for _ in np.shape(place)))
        return sum(c * one for c, one in zip(coefficients, spline(place - knots), strict=True))
    return sum(c * spline(place - k) for k, c in enumerate(coefficients))


def _per_knot(coefficients: tuple[Number, ...]) -> float:
    """Knots in half the range."""
    return 0.5 * (len(coefficients) - 1.0)


def spline(u: Number) -> Number:
    """The cubic B-spline of knots a unit apart, about 0: 2/3 there, nothing beyond 2.

    >>> round(float(spline(0.0)), 4), round(float(spline(-1.0)), 4), float(spline(2.0))
    (0.6667, 0.1667, 0.0)
    """
    far, near = np.maximum(2.0 - np.abs(u), 0.0), np.maximum(1.0 - np.abs(u), 0.0)
    return (far * far * far - 4.0 * near * near * near) * (1.0 / 6.0)


def _coefficient(meaning: str) -> Any:
    return parameter("deg", meaning, -20.0, 20.0, 0.0)


_STATIC = "coefficient of a spline of the pressure"
_TURNING = "coefficient of a spline that takes the sign of the direction"
_SLOW = "coefficient of a spline times the distance from the slow pressure, in half the range"


@dataclass(frozen=True)
class LearntBlock(Effect):
    """Splines at knots from `low` to `high` [kPa], between which it was learnt.

    >>> LearntBlock().values["learnt.static3"]
    0.0
    """

    NAME = "learnt"
    FORM = "splines of pressure, direction and slow pressure"
    STAGE = "wrist"
    HAPPENS = "The angle differs as was learnt from the recordings, without a known cause"
    LEARNT = True
    FROM_REST = True

    low: Number = parameter("kPa", "lower end of the pressures that it was learnt on", -1e4, 1e4, 0.0)
    high: Number = parameter("kPa", "upper end of the pressures that it was learnt on", -1e4, 1e4, 200.0)
    turn: Number = parameter("kPa", "way of the pressure in which the direction turns", 0.5, 200.0, 20.0)
    memory: Number = parameter("s", "time constant of the slow pressure", 0.02, 100.0, 2.0)
    static1: Number = _coefficient(_STATIC)
    static2: Number = _coefficient(_STATIC)
    static3: Number = _coefficient(_STATIC)
    static4: Number = _coefficient(_STATIC)
    static5: Number = _coefficient(_STATIC)
    static6: Number = _coefficient(_STATIC)
    static7: Number = _coefficient(_STATIC)
    static8: Number = _coefficient(_STATIC)
    static9: Number = _coefficient(_STATIC)
    turning1: Number = _coefficient(_TURNING)
    turning2: Number = _coefficient(_TURNING)
    turning3: Number = _coefficient(_TURNING)
    turning4: Number = _coefficient(_TURNING)
    turning5: Number = _coefficient(_TURNING)
    slow1: Number = _coefficient(_SLOW)
    slow2: Number = _coefficient(_SLOW)
    slow3: Number = _coefficient(_SLOW)
    slow4: Number = _coefficient(_SLOW)
    slow5: Number = _coefficient(_SLOW)

    @property
    def parts(self) -> tuple[tuple[Number, ...], ...]:
        """Coefficients [deg] of the static, the turning and the slow part."""
        return (
            (self.static1, self.static2, self.static3, self.static4, self.static5, self.static6, self.static7,
             self.static8, self.static9),
            (self.turning1, self.turning2, self.turning3, self.turning4, self.turning5),
            (self.slow1, self.slow2, self.slow3, self.slow4, self.slow5),
        )  # fmt: skip

    def sampled(self, wrist: Any, dt: float) -> SampledLearntBlock:
        share = -np.expm1(-dt / np.asarray(self.memory, float))
        return self._with(wrist, share)

    def _with(self, wrist: Any, share: Number) -> SampledLearntBlock:
        (static, turning, slow), rest = self.parts, wrist.hysteresis.rest_pressure
        half = 0.5 * (self.high - self.low)
        at_rest = curve(static, (rest - self.low) / half)
        return SampledLearntBlock(
            static, turning, slow, self.low, half, rest, at_rest, 1.0 / self.turn, share,
            1.0 / wrist.rig.half_range,
        )  # fmt: skip

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> LearntMemory:
        added = self.beside(wrist, pressure)
        return LearntMemory(0.0 * pressure, pressure, added, added)

    def beside(self, wrist: Any, pressure: Number) -> Number:
        return self._with(wrist, 0.0).still(pressure)

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        """Slopes between the least and the largest that any direction and any distance from the slow pressure
        within the range of the command make, turning or not."""
        block, p = self._with(wrist, 0.0), np.linspace(*reach, 2001)
        step, span = p[1] - p[0], float(np.ptp(wrist.reach)) / wrist.rig.half_range
        static = np.gradient(block.still(p), step)
        turning = block.added(p, 1.0, 0.0) - block.still(p)
        slow = block.added(p, 0.0, 1.0) - block.still(p)
        swing = np.abs(np.gradient(turning, step)) + span * np.abs(np.gradient(slow, step))
        engaged, moved = turning / float(self.turn), slow / wrist.rig.half_range
        least = float(np.min(static - swing + np.minimum(engaged, 0.0) + np.minimum(moved, 0.0)))
        most = float(np.max(static + swing + np.maximum(engaged, 0.0) + np.maximum(moved, 0.0)))
        return Linear(added=dict.fromkeys(SIDES, (least, most)))
