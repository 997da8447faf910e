"""End stop: the joint meets a mechanical stop, hard or with a little give."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Nothing, Number, parameter


class _Stops(NamedTuple):
    low: Number
    high: Number
    give: Number


class _SampledStops(_Stops):
    def _stopped(self, angle: Number) -> Number:
        inside = np.minimum(np.maximum(angle, self.low), self.high)
        return inside + self.give * (angle - inside)


class SampledJointStop(_SampledStops):
    """The joint itself stops: it leaves as soon as the static angle comes back."""

    def stop(self, s: Nothing, angle: Number) -> Number:
        return self._stopped(angle)


class SampledStaticStop(_SampledStops):
    """The static angle stops, and the joint comes to it with its lag."""

    def static(
        self, s: Nothing, before: Number, after: Number, around: Around
    ) -> tuple[Nothing, Number, Number]:
        return s, self._stopped(before), self._stopped(after)


class SampledSeenStop(_SampledStops):
    """What is seen stops, while the actuator goes on behind a compliant link."""

    def sensor(self, s: Nothing, angle: Number, around: Around) -> Number:
        return self._stopped(angle)


# Pairs of trials that leave one side free find a stop on either side.
_LOW = parameter("deg", "lower stop", -90.0, 0.0, -90.0, (-90.0, -26.0, -21.0, -16.0, -11.0))
_HIGH = parameter("deg", "upper stop", 0.0, 90.0, 90.0, (90.0, 26.0, 21.0, 16.0, 11.0))
_GIVE = parameter("1", "give: slope beyond the stop over the slope before", 0.0, 0.6, 0.0, (0.1,))


@dataclass(frozen=True)
class HardStop(Effect):
    """The joint cannot pass `low` and `high` [deg]."""

    NAME = "end-stop"
    FORM = "hard"
    STAGE = "wrist"

    low: Number = _LOW
    high: Number = _HIGH

    def sampled(self, wrist: Any, dt: float) -> SampledJointStop:
        return SampledJointStop(self.low, self.high, 0.0)


@dataclass(frozen=True)
class GivingStop(Effect):
    """Beyond `low` and `high` [deg] the static angle goes on with a share `give` of its slope."""

    NAME = "end-stop"
    FORM = "with some give"
    STAGE = "wrist"

    low: Number = _LOW
    high: Number = _HIGH
    give: Number = _GIVE

    def sampled(self, wrist: Any, dt: float) -> SampledStaticStop:
        return SampledStaticStop(self.low, self.high, self.give)


@dataclass(frozen=True)
class CompliantStop(Effect):
    """The link beyond the stop gives: what is seen goes on with a share `give` of the joint's angle."""

    NAME = "end-stop"
    FORM = "behind a compliant link"
    STAGE = "wrist"

    low: Number = _LOW
    high: Number = _HIGH
    give: Number = _GIVE

    def sampled(self, wrist: Any, dt: float) -> SampledSeenStop:
        return SampledSeenStop(self.low, self.high, self.give)
