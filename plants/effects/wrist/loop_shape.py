"""Loop shape: minor loops that one play and straight lines cannot make.

Beside the loop act further plays of the pressure, a Prandtl-Ishlinskii sum (Kuhnen, European J. Control 9
(2003) 407): after a reversal they engage one after the other, so that the way back is curved and a small
loop is narrower than the large one.  Their weights are free, so that the sum describes what other laws of
smooth hysteresis (Bouc-Wen, Preisach, Maxwell slip) make of a reversal, whatever their formula.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

from plants.effects.effect import Around, Effect, ExcitationHints, Linear, Number, parameter
from plants.hysteresis.law import SIDES, Side
from plants.hysteresis.play import play

FLAT = 1e-6
"""A branch less steep than this [deg/kPa] counts as one of this slope."""


class Beside(NamedTuple):
    """Plays [kPa], the smallest threshold first, and what they add to the angle [deg]: before the sample and
    after it."""

    plays: tuple[Number, ...]
    before: Number
    after: Number


class SampledPlays(NamedTuple):
    """Weights [deg/kPa] and thresholds [kPa] of the plays, and the pressure [kPa] at which they are 0."""

    weights: tuple[Number, ...]
    thresholds: tuple[Number, ...]
    rest_pressure: Number

    def drive(
        self, s: Beside, before: Number, after: Number, around: Around
    ) -> tuple[Beside, Number, Number]:
        x = after - self.rest_pressure
        plays = tuple(play(p, x, r) for p, r in zip(s.plays, self.thresholds, strict=True))
        return Beside(plays, s.after, self._angle(plays)), before, after

    def static(
        self, s: Beside, before: Number, after: Number, around: Around
    ) -> tuple[Beside, Number, Number]:
        return s, before + s.before, after + s.after

    def _angle(self, plays: tuple[Number, ...]) -> Number:
        return sum(w * p for w, p in zip(self.weights, plays, strict=True))


class _Plays(Effect):
    """What the forms share; at rest each play is in the middle of its gap."""

    NAME = "loop-shape"
    STAGE = "wrist"
    HAPPENS = "Minor loops have a shape that straight lines cannot make"

    def borrowed(self, asked: ExcitationHints) -> str | None:
        """One ramp has no loop, and one sine the same loop again and again: it may be its branches."""
        if asked.ramp or asked.single:
            what = "one ramp" if asked.ramp else "a single sine"
            return f"the command is {what}, which makes no minor loops; record nested minor loops"
        return None

    def sampled(self, wrist: Any, dt: float) -> SampledPlays:
        weights, thresholds = self.plays
        return SampledPlays(weights, thresholds, wrist.hysteresis.rest_pressure)

    @property
    def plays(self) -> tuple[tuple[Number, ...], tuple[Number, ...]]:
        """Weights [deg/kPa] and thresholds [kPa]."""
        raise NotImplementedError

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Beside:
        thresholds = self.plays[1]
        added = self.beside(wrist, pressure)
        return Beside((pressure - wrist.hysteresis.rest_pressure,) * len(thresholds), added, added)

    def beside(self, wrist: Any, pressure: Number) -> Number:
        return sum(self.plays[0]) * (pressure - wrist.hysteresis.rest_pressure)

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        """With none of the plays engaged, and with all of them."""
        more, loop = float(sum(self.plays[0])), wrist.hysteresis
        slopes: dict[Side, float] = dict(zip(SIDES, (*loop.steepness, loop.flattest), strict=True))
        ends = {side: 1.0 + more / max(float(slope), FLAT) for side, slope in slopes.items()}
        return Linear(slopes={side: (min(1.0, end), max(1.0, end)) for side, end in ends.items()})

    def no_bound(self, wrist: Any) -> str | None:
        return "plays beside the loop are no part of the bound's envelope"


def _weight(trials: tuple[float, ...]) -> Any:
    return parameter("deg/kPa", "weight of a play beside the loop", -0.3, 1.0, 0.0, trials)


_REACH = parameter("kPa", "largest threshold of the plays", 1.0, 150.0, 30.0, (6.0, 15.0, 30.0, 60.0))


@dataclass(frozen=True)
class OneMorePlay(_Plays):
    """One play beside the loop."""

    FORM = "one more play"

    weight: Number = _weight((-0.03, 0.05))
    reach: Number = _REACH

    @property
    def plays(self) -> tuple[tuple[Number, ...], tuple[Number, ...]]:
        return (self.weight,), (self.reach,)


@dataclass(frozen=True)
class SeveralPlays(_Plays):
    """Three plays beside the loop, with thresholds at a third, two thirds and all of `reach` [kPa]."""

    FORM = "several plays"

    first: Number = _weight((-0.03, 0.03))
    second: Number = _weight((-0.03, 0.03))
    third: Number = _weight((0.03,))
    reach: Number = _REACH

    @property
    def plays(self) -> tuple[tuple[Number, ...], tuple[Number, ...]]:
        return (self.first, self.second, self.third), (self.reach / 3.0, self.reach / 1.5, self.reach)
