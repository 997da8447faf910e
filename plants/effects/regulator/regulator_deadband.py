"""Regulator dead band: small changes of the command are ignored or followed at a distance, or small commands
have no effect."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Nothing, Number, parameter
from plants.meanings import remembers
from plants.rig import Rig


@remembers(target=("kPa", "commanded pressure that the regulator has taken up"))
class HeldTarget(NamedTuple):
    """The commanded pressure [kPa] that the regulator has taken up."""

    target: Number


class SampledLatch(NamedTuple):
    """Half width [kPa]."""

    width: Number

    def target(self, s: HeldTarget, target: Number, around: Around) -> tuple[HeldTarget, Number]:
        held = np.where(np.abs(target - s.target) > self.width, target, s.target)
        return HeldTarget(held), held


class SampledPlay(NamedTuple):
    """Half width [kPa]."""

    width: Number

    def target(self, s: HeldTarget, target: Number, around: Around) -> tuple[HeldTarget, Number]:
        held = np.minimum(np.maximum(s.target, target - self.width), target + self.width)
        return HeldTarget(held), held


class SampledOverlap(NamedTuple):
    """Half width [kPa]."""

    width: Number

    def valve(self, s: Nothing, pressure: Number, error: Number, around: Around) -> tuple[Number, Number]:
        return np.where(np.abs(error) > self.width, error, 0.0), 1.0


def _width(meaning: str) -> Any:
    return parameter("kPa", meaning, 0.0, 15.0, 0.0, (0.7, 1.5, 3.0, 5.0))


class _DeadBand(Effect):
    """What the forms share."""

    NAME = "regulator-deadband"
    STAGE = "regulator"
    HAPPENS = "The regulator passes over small changes of the command"
    BOUND = "taken away"
    RUGGED = True  # a latch takes a command up or does not, and a play hides in the gain and the slow rate


class _Holding(_DeadBand):
    """Forms that hold a commanded pressure [kPa]."""

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> HeldTarget:
        return HeldTarget(pressure)


@dataclass(frozen=True)
class Latch(_Holding):
    """A change of the commanded pressure is taken up once it exceeds `width` [kPa], then in full."""

    FORM = "latch"
    THRESHOLD = "width"

    width: Number = _width("change of the commanded pressure that is ignored")

    def sampled(self, wrist: Any, dt: float) -> SampledLatch:
        return SampledLatch(self.width)


@dataclass(frozen=True)
class PlayDeadBand(_Holding):
    """The regulator follows the commanded pressure at a distance of `width` [kPa], as with backlash."""

    FORM = "play"

    width: Number = _width("distance at which the commanded pressure is followed")

    def sampled(self, wrist: Any, dt: float) -> SampledPlay:
        return SampledPlay(self.width)


@dataclass(frozen=True)
class ValveOverlap(_DeadBand):
    """The valves stay shut while the pressure is within `width` [kPa] of the commanded one."""

    FORM = "valve overlap"

    width: Number = _width("error of the pressure at which the valves stay shut")

    def sampled(self, wrist: Any, dt: float) -> SampledOverlap:
        return SampledOverlap(self.width)


class SampledFloor(NamedTuple):
    """Least commanded pressure [kPa] that is followed."""

    least: Number

    def target(self, s: Nothing, target: Number, around: Around) -> tuple[Nothing, Number]:
        return s, np.maximum(target, self.least)


@dataclass(frozen=True)
class LeastPressure(_DeadBand):
    """Below a commanded pressure of `least` [kPa] that one is held: a command that is too small to open the
    valve, or that asks for less than the outside has."""

    FORM = "no answer to the smallest commands"
    HAPPENS = "The regulator does not answer to the smallest commands"
    FIRST = True  # it is the command that is too small, not what is left of it behind a lag

    least: Number = parameter("kPa", "least pressure that is held", -500.0, 2000.0, -500.0)

    @classmethod
    def trials(cls, rig: Rig | None = None) -> Iterator[dict[str, float]]:
        """Pressures at the lower end of the rig's range."""
        low, high = cls.pressures(rig)
        for share in (0.0, 0.01, 0.03, 0.1):
            yield {"least": low + share * (high - low)}

    def sampled(self, wrist: Any, dt: float) -> SampledFloor:
        return SampledFloor(self.least)

    def obstacle(self, pressure: float, angle: float) -> str | None:
        if pressure >= float(self.least):
            return None
        return f"a least pressure of {float(self.least):.4g} kPa, where {pressure:.4g} kPa are needed,"
