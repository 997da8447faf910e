"""Loop shape: minor loops that one play and straight lines cannot make.

Beside the loop act further plays of the pressure, a Prandtl-Ishlinskii sum (Kuhnen, European J. Control 9
(2003) 407), or a play that engages smoothly, by Bouc-Wen's law (Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249).
After a reversal they engage one after the other, so that the way back is curved and a small loop is narrower
than a large one.  Or the transit between the lines is itself curved, as laws of Duhem's class are (Brokate &
Sprekels, Hysteresis and Phase Transitions, 1996).
"""

from abc import abstractmethod
from dataclasses import dataclass
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Linear, Nothing, Number, parameter
from plants.effects.hints import ExcitationHints
from plants.hysteresis.law import SIDES
from plants.hysteresis.play import kept
from plants.meanings import remembers

FLAT = 1e-6
"""Least slope of a branch [deg/kPa] and least gap between two [deg]; flatter and narrower ones count as
these."""


@remembers(
    behind=("kPa", "how far a play is behind its input"),
    before=("deg", "what the plays added to the angle before the sample"),
    after=("deg", "what the plays add to the angle"),
)
class Beside(NamedTuple):
    """How far each play is behind its input [kPa], and what the plays add to the
    angle [deg] before the sample and after it."""

    behind: tuple[Number, ...]
    before: Number
    after: Number


class SampledPlays(NamedTuple):
    """Weights [deg/kPa] and thresholds [kPa] of the plays, and the pressure [kPa] at which they are 0."""

    weights: tuple[Number, ...]
    thresholds: tuple[Number, ...]
    rest_pressure: Number

    @property
    def watches(self) -> bool:
        """It leaves the pressure that drives the loop as it is."""
        return True

    def drive(
        self, s: Beside, before: Number, after: Number, around: Around
    ) -> tuple[Beside, Number, Number]:
        behind = tuple(
            kept(z + after - before, -r, r) for z, r in zip(s.behind, self.thresholds, strict=True)
        )
        x = after - self.rest_pressure
        added = sum(w * (x - z) for w, z in zip(self.weights, behind, strict=True))
        return Beside(behind, s.after, added), before, after

    def static(
        self, s: Beside, before: Number, after: Number, around: Around
    ) -> tuple[Beside, Number, Number]:
        return s, before + s.before, after + s.after


class SampledSmooth(NamedTuple):
    """Weight [deg/kPa], threshold [kPa] and exponent of a play that engages smoothly, and the pressure [kPa]
    at which it is 0."""

    weight: Number
    threshold: Number
    exponent: Number
    rest_pressure: Number

    @property
    def watches(self) -> bool:
        """It leaves the pressure that drives the loop as it is."""
        return True

    def drive(
        self, s: Beside, before: Number, after: Number, around: Around
    ) -> tuple[Beside, Number, Number]:
        (z,), move = s.behind, after - before
        first = move * self._share(z, move)
        second = move * self._share(z + first, move)  # Heun's method
        z = kept(z + 0.5 * (first + second), -self.threshold, self.threshold)
        return Beside((z,), s.after, self.weight * (after - self.rest_pressure - z)), before, after

    def static(
        self, s: Beside, before: Number, after: Number, around: Around
    ) -> tuple[Beside, Number, Number]:
        return s, before + s.before, after + s.after

    def _share(self, z: Number, move: Number) -> Number:
        """Share of a move of the pressure by which the play falls further behind; all, on the way back."""
        engaged = np.minimum(np.maximum(np.abs(z) / self.threshold, 1e-9), 1.0) ** self.exponent
        return np.where(z * move > 0.0, 1.0 - engaged, 1.0)


class SampledTransit(NamedTuple):
    """Share of the slope of the line ahead with which the transit meets it, and the power of the way gone
    with which it becomes as steep."""

    share: Number
    power: Number

    def steepen(self, s: Nothing, h: Number, before: Number, after: Number, loop: Any) -> Number:
        first = self._factor(h, before, after - before, loop)
        second = self._factor(h + first * loop.flattest * (after - before), after, after - before, loop)
        return 0.5 * (first + second)  # Heun's method

    def _factor(self, h: Number, pressure: Number, move: Number, loop: Any) -> Number:
        low, high = loop.ascending(pressure), loop.descending(pressure)
        up, down = loop.steepness
        gone = np.where(move > 0.0, high - h, h - low) / np.maximum(high - low, FLAT)
        way = np.minimum(np.maximum(gone, 1e-9), 1.0) ** self.power
        flat = np.maximum(loop.flattest, FLAT)
        return 1.0 + self.share * way * (np.where(move > 0.0, up, down) - flat) / flat


class _Shape(Effect):
    """What the forms share."""

    NAME = "loop-shape"
    STAGE = "wrist"
    HAPPENS = "Minor loops have a shape that straight lines cannot make"
    FROM_REST = True

    def no_bound(self, wrist: Any) -> str | None:
        return "plays beside the loop and curved transits are no part of the bound's envelope"

    def borrowed(self, asked: ExcitationHints) -> str | None:
        """The same loop again and again shows its branches alone."""
        if asked.minor_loops:
            return None
        return "the command makes few minor loops, so that it may be the branches; record nested minor loops"


class _Plays(_Shape):
    """Plays beside the loop; at rest each is in the middle of its gap."""

    @property
    @abstractmethod
    def weights(self) -> tuple[Number, ...]:
        """Weights of the plays [deg/kPa]."""

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Beside:
        added = self.beside(wrist, pressure)
        return Beside((0.0 * pressure,) * len(self.weights), added, added)

    def beside(self, wrist: Any, pressure: Number) -> Number:
        return sum(self.weights) * (pressure - wrist.hysteresis.rest_pressure)

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        """Between none of the plays engaged and all of them, which they do one after the other."""
        engaged = [0.0, *accumulate(float(w) for w in self.weights)]
        return Linear(added=dict.fromkeys(SIDES, (min(engaged), max(engaged))))


def _weight(trials: tuple[float, ...]) -> Any:
    return parameter("deg/kPa", "weight of a play beside the loop", -0.3, 1.0, 0.0, trials)


_REACH = parameter("kPa", "largest threshold of the plays", 1.0, 150.0, 30.0, (6.0, 12.0, 24.0, 48.0))


@dataclass(frozen=True)
class OneMorePlay(_Plays):
    """One play beside the loop."""

    FORM = "one more play"

    weight: Number = _weight((-0.03, 0.05))
    reach: Number = _REACH

    @property
    def weights(self) -> tuple[Number, ...]:
        return (self.weight,)

    def sampled(self, wrist: Any, dt: float) -> SampledPlays:
        return SampledPlays((self.weight,), (self.reach,), wrist.hysteresis.rest_pressure)


@dataclass(frozen=True)
class SmoothLoop(_Plays):
    """One play that engages the more, the further it is behind: Bouc-Wen's law."""

    FORM = "smooth loop"

    weight: Number = _weight((-0.03, 0.05))
    reach: Number = parameter(
        "kPa", "largest distance of the play from its input", 1.0, 150.0, 20.0, (8.0, 16.0, 32.0)
    )
    exponent: Number = parameter("1", "how suddenly it engages", 0.3, 8.0, 1.0, (1.0, 2.0))

    @property
    def weights(self) -> tuple[Number, ...]:
        return (self.weight,)

    def sampled(self, wrist: Any, dt: float) -> SampledSmooth:
        return SampledSmooth(self.weight, self.reach, self.exponent, wrist.hysteresis.rest_pressure)


@dataclass(frozen=True)
class SeveralPlays(_Plays):
    """Three plays beside the loop, with thresholds at a quarter, a half and all of `reach` [kPa]."""

    FORM = "several plays"

    first: Number = _weight((-0.02, 0.02))
    second: Number = _weight((-0.02, 0.02))
    third: Number = _weight((0.03,))
    reach: Number = _REACH

    @property
    def weights(self) -> tuple[Number, ...]:
        return (self.first, self.second, self.third)

    def sampled(self, wrist: Any, dt: float) -> SampledPlays:
        thresholds = (self.reach / 4.0, self.reach / 2.0, self.reach)
        return SampledPlays(self.weights, thresholds, wrist.hysteresis.rest_pressure)


@dataclass(frozen=True)
class CurvedTransit(_Shape):
    """The transit between the lines is curved: it comes nearer to the slope of the line that it leads to."""

    FORM = "curved transits"

    share: Number = parameter(
        "1", "share of the line's slope with which the transit meets it", 0.0, 1.0, 0.0, (0.5, 1.0)
    )
    power: Number = parameter(
        "1", "power of the way gone with which it becomes steeper", 0.3, 8.0, 1.5, (1.0, 2.0)
    )

    def sampled(self, wrist: Any, dt: float) -> SampledTransit:
        return SampledTransit(self.share, self.power)

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        loop = wrist.hysteresis
        flat = max(float(loop.flattest), FLAT)
        steepest = 1.0 + float(self.share) * (max(map(float, loop.steepness)) - flat) / flat
        return Linear(slopes={SIDES[-1]: (1.0, steepest)})
