"""End stop: the joint meets a mechanical stop, hard or with a little give."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Nothing, Number, parameter
from plants.effects.hints import ExcitationHints, TrialHints

PRESSED = 0.02
"""Share of its range by which the pressure has to go on at a stop to tell it from the end of a curve."""


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


class SampledSpringStop(NamedTuple):
    """Stops [deg], and what is left of a compression after one sample of the spring's push."""

    low: Number
    high: Number
    left: Number

    def stop(self, s: Nothing, angle: Number) -> Number:
        inside = np.minimum(np.maximum(angle, self.low), self.high)
        return inside + self.left * (angle - inside)


class SampledPadStop(NamedTuple):
    """Stops [deg], and four times the pad's push in one sample [1/deg]."""

    low: Number
    high: Number
    push4: Number

    def stop(self, s: Nothing, angle: Number) -> Number:
        inside = np.minimum(np.maximum(angle, self.low), self.high)
        # Implicit step: x + push x^2 = over.
        over = angle - inside
        x = 2.0 * np.abs(over) / (1.0 + np.sqrt(1.0 + self.push4 * np.abs(over)))
        return inside + np.where(over < 0.0, -x, x)


def _pull(wrist: Any, dt: float) -> Number:
    """Share of the way to its static angle that the joint goes in one sample."""
    return -np.expm1(-dt / np.asarray(wrist.Tw, float))


# Pairs of trials that leave one side free find a stop on either side.
_LOW = parameter("deg", "lower stop", -90.0, 0.0, -90.0, (-90.0, -26.0, -21.0, -16.0, -11.0))
_HIGH = parameter("deg", "upper stop", 0.0, 90.0, 90.0, (90.0, 26.0, 21.0, 16.0, 11.0))
_GIVE = parameter("1", "give: slope beyond the stop over the slope before", 0.0, 0.6, 0.0, (0.1,))


@dataclass(frozen=True)
class _Stop(Effect):
    """What the forms share: stops at `low` and `high` [deg]."""

    NAME = "end-stop"
    STAGE = "wrist"
    HAPPENS = "The joint meets a stop"
    STOPS = True
    BOUND = "kept"

    low: Number = _LOW
    high: Number = _HIGH

    @classmethod
    def trials_on(cls, log: TrialHints) -> Iterator[dict[str, float]]:
        """Stops at shares of the angles that were reached, on either side or both."""
        low, high = log.quantiles(0.002, 0.998)
        shares = (1.0, 0.9, 0.75, 0.6)
        kinds, least = cls.kinds(), log.rig.scaled(1.0, "deg")
        lows = [log.rig.scaled(kinds["low"].low, "deg"), *(s * min(low, -least) for s in shares)]
        highs = [log.rig.scaled(kinds["high"].high, "deg"), *(s * max(high, least) for s in shares)]
        # A joint that goes to one side may rest against a stop at the end where it starts.
        lows += [min(low, 0.0)] if -low < least < high else []
        highs += [max(high, 0.0)] if high < least < -low else []
        rest = {n: v for n, v in next(cls.trials(log.rig)).items() if n not in ("low", "high")}
        for a, b in list(product(lows, highs))[1:]:
            yield {**rest, "low": float(a), "high": float(b)}

    def borrowed(self, asked: ExcitationHints) -> str | None:
        """A stop that nothing is pressed against is the end of a curve as well."""
        ends = ((float(self.low), -1.0), (float(self.high), 1.0))
        if max(asked.pressed_beyond(*end) for end in ends) >= PRESSED:
            return None
        return (
            f"nowhere does the pressure go on by {100 * PRESSED:.0f} % of its range while the joint stays at "
            "a stop, so that it may be the end of a curve; record with the joint pressed against the stop"
        )

    def counted_from(self, angle: Number) -> "_Stop":
        return replace(self, low=self.low - angle, high=self.high - angle)

    def obstacle(self, pressure: float, angle: float) -> str | None:
        beyond = float(np.clip(angle, self.low, self.high))
        if beyond == angle or self._gives():
            return None
        return f"the end stop at {beyond:+.3g} deg"

    def _gives(self) -> bool:
        """Whether the joint can be pressed beyond a stop so that the sensor shows where it is."""
        return False


@dataclass(frozen=True)
class _GivingStop(_Stop):
    """Stops with some `give`."""

    give: Number = _GIVE


@dataclass(frozen=True)
class HardStop(_Stop):
    """The joint cannot pass `low` and `high` [deg]."""

    FORM = "hard"

    def sampled(self, wrist: Any, dt: float) -> SampledJointStop:
        return SampledJointStop(self.low, self.high, 0.0)


@dataclass(frozen=True)
class SpringStop(_GivingStop):
    """The joint meets a spring at `low` and `high` [deg]: in the end it goes on with a share `give` of
    the static angle, and gets there faster than it would without."""

    FORM = "spring at the joint"

    def sampled(self, wrist: Any, dt: float) -> SampledSpringStop:
        # The push lasts a sample, implicitly; exact where the joint comes to rest.
        left = self.give / (self.give + (1.0 - self.give) * _pull(wrist, dt))
        return SampledSpringStop(self.low, self.high, left)

    def _gives(self) -> bool:
        return float(self.give) > 0.0


@dataclass(frozen=True)
class PadStop(_Stop):
    """The joint meets a pad that pushes with the square of its compression, `push` [deg] at 1 deg."""

    FORM = "progressive pad"

    push: Number = parameter("1/deg", "push of the pad at 1 deg of compression", 0.02, 100.0, 1.5)

    def sampled(self, wrist: Any, dt: float) -> SampledPadStop:
        return SampledPadStop(self.low, self.high, 4.0 * self.push * _pull(wrist, dt))

    def _gives(self) -> bool:
        return True


@dataclass(frozen=True)
class GivingStop(_GivingStop):
    """Beyond `low` and `high` [deg] the static angle goes on with a share `give` of its slope."""

    FORM = "with some give"

    def sampled(self, wrist: Any, dt: float) -> SampledStaticStop:
        return SampledStaticStop(self.low, self.high, self.give)

    def _gives(self) -> bool:
        return float(self.give) > 0.0


@dataclass(frozen=True)
class CompliantStop(_GivingStop):
    """The link beyond the stop gives: what is seen goes on with a share `give` of the joint's angle."""

    FORM = "behind a compliant link"

    def sampled(self, wrist: Any, dt: float) -> SampledSeenStop:
        return SampledSeenStop(self.low, self.high, self.give)
