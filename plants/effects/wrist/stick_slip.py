"""Stick-slip: the joint sticks until its spring is off by a breakaway, then slides.

All friction is in degrees of the joint's own spring: the joint moves by Tw y' = h - y - friction, where
h is the static angle, or with inertia^2 y'' on the left where it has a mass, which one that breaks away at
once has not.  Friction of Stribeck's kind holds against more than it takes once sliding (Armstrong-Helouvry,
Dupont & Canudas de Wit, Automatica 30 (1994) 1083); where asperities bend before they give way the joint
creeps along with its load while it sticks (presliding: Dahl, 1968; LuGre, Canudas de Wit et al., IEEE Trans.
Autom. Control 40 (1995) 419), and where they give way one after the other it remembers where it turned round
(Maxwell slip: Iwan, J. Appl. Mech. 33 (1966) 893; Al-Bender, Lampaert & Swevers, IEEE Trans. Autom. Control
50 (2005) 1883).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants import lag
from plants.effects.effect import Effect, Number, parameter
from plants.effects.hints import TrialHints
from plants.hysteresis.play import kept
from plants.meanings import remembers

LEVEL = 1e-12
"""A pull that grows by less than this [deg] in a sample does not grow."""

SHARES = (0.01, 0.03, 0.1)
"""Breakaways to try, as shares of the range of the angle."""

TURNS = 2
"""How often the equation of the implicit midpoint rule is solved again for the speed of the joint."""


@remembers(slides=("", "1 where the joint slides, 0 where it sticks"))
class Contact(NamedTuple):
    """Whether the joint slides (1) or sticks (0)."""

    slides: Number


class SampledStickSlip(NamedTuple):
    """Breakaway, friction while sliding, and what pulls when the joint sticks again [deg]; the lag of a joint
    that slides."""

    breakaway: Number
    sliding: Number
    residue: Number
    lag: lag.SampledLag

    def joint(
        self, s: Contact, angle: Number, before: Number, after: Number, pressure: Number
    ) -> tuple[Contact, Number]:
        first, off = np.abs(before - angle), after - angle
        pull, side = np.abs(off), np.where(off < 0.0, -1.0, 1.0)
        slid = s.slides > 0.5
        # When in the sample it breaks away; where in the sample it sticks again.
        late = kept((self.breakaway - first) / np.maximum(pull - first, LEVEL), 0.0, 1.0)
        friction = side * self.sliding
        way = lag.step(angle, before - friction, after - friction, self.lag) - angle
        to = angle + np.where(slid, 1.0, 1.0 - late) * way
        left = np.abs(after - to)
        ends = np.where(pull < self.residue, angle, after - side * self.residue)
        sticks = np.where(np.minimum(pull, left) < self.residue, 1.0, 0.0)
        moves = np.where(slid, 1.0, np.where(pull >= self.breakaway, 1.0, 0.0))
        moved = np.where(sticks > 0.5, ends, to)
        return Contact(moves * (1.0 - sticks)), np.where(moves > 0.5, moved, angle)


@remembers(pull=("deg", "pull of the bristles"), speed=("deg/s", "speed of the joint"))
class Bristles(NamedTuple):
    """Pull of the bristles [deg] and speed of the joint [deg/s]."""

    pull: Number
    speed: Number


class SampledBristles(NamedTuple):
    """Breakaway and friction while sliding [deg]; speed [deg/s] at which the one becomes the other, inverted;
    stiffness of the bristles over the joint's; half a step [s]."""

    breakaway: Number
    sliding: Number
    per_speed: Number
    stiffness: Number
    half: Number

    def friction(self, s: Bristles, angle: Number, free: Number, share: Number) -> tuple[Bristles, Number]:
        pull, speed = s
        bends, give = self.stiffness * self.half, 1.0
        for _ in range(TURNS):
            give = 1.0 + bends * np.abs(speed) / self._most(speed)
            speed = (free - angle - share * pull / give) / (2.0 * self.half + share * bends / give)
        middle = (pull + bends * speed) / give
        return Bristles(2.0 * middle - pull, speed), middle

    def _most(self, speed: Number) -> Number:
        """Friction [deg] of a joint that slides at a speed [deg/s]."""
        x = np.minimum(np.abs(speed) * self.per_speed, 30.0)
        return self.sliding + (self.breakaway - self.sliding) * np.exp(-x * x)


SPRINGS = 6
"""Of Maxwell slip: what slips is smooth enough, and the state small."""


@remembers(pulls=("deg", "pull of a spring of the friction, that which slips first the first"))
class Springs(NamedTuple):
    """Pulls of the springs [deg]."""

    pulls: tuple[Number, ...]


class SampledSprings(NamedTuple):
    """Pull [deg] at which each spring slips; stiffness of each over the joint's."""

    most: tuple[Number, ...]
    stiffness: Number

    def friction(self, s: Springs, angle: Number, free: Number, share: Number) -> tuple[Springs, Number]:
        # Newton's method on what holds in the middle of the sample: piecewise linear, it ends within a turn
        # of finding which springs slip.
        moved = free - share * sum(s.pulls)
        for _ in range(1 + TURNS):
            middle = self._pulled(s.pulls, 0.5 * (moved - angle))
            sticks = sum(np.where(np.abs(p) < m, 1.0, 0.0) for p, m in zip(middle, self.most, strict=True))
            off = moved - free + share * sum(middle)
            moved = moved - off / (1.0 + 0.5 * share * self.stiffness * sticks)
        held = sum(self._pulled(s.pulls, 0.5 * (moved - angle)))
        return Springs(self._pulled(s.pulls, free - share * held - angle)), held

    def _pulled(self, pulls: tuple[Number, ...], move: Number) -> tuple[Number, ...]:
        """The pulls [deg] after the joint has moved [deg]."""
        by = self.stiffness * move
        return tuple(kept(p + by, -m, m) for p, m in zip(pulls, self.most, strict=True))


_BREAKAWAY = parameter("deg", "pull at which the joint breaks away", 0.0, 20.0, 0.0, (0.4, 1.0, 2.5))
_SLIDING = parameter("1", "friction while sliding over breakaway", 0.0, 0.98, 0.0, (0.1, 0.5))
_AGAIN = "where the joint sticks again, as a share of the way from sliding to breakaway"
_RESIDUE = parameter("1", _AGAIN, 0.0, 1.0, 0.3, (0.1, 0.4))


class _StickSlip(Effect):
    """What the forms share."""

    NAME = "stick-slip"
    STAGE = "wrist"
    HAPPENS = "The joint sticks, then slides"
    JOINT = True
    RUGGED = True

    breakaway: Number

    def no_bound(self, wrist: Any) -> str | None:
        return "a joint that breaks away earlier may stick nearer"

    def hinders(self, band: float, unit: str) -> str | None:
        if float(self.breakaway) <= band:
            return None
        return (
            f"the joint breaks away {float(self.breakaway):.3g} {unit} from its equilibrium, beyond the band "
            f"of {band:.3g} {unit}, so that integral action makes it slip to and fro"
        )

    @classmethod
    def trials_on(cls, log: TrialHints) -> Iterator[dict[str, float]]:
        """The trials, and breakaways at shares of the range that was reached, for rigs of any size."""
        yield from cls.trials(log.rig)
        low, high = log.quantiles(0.002, 0.998)
        first = next(cls.trials(log.rig))["breakaway"]
        for given in cls.trials(log.rig):
            if given["breakaway"] == first:
                for share in SHARES:
                    yield {**given, "breakaway": share * float(high - low)}

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Any:
        return Contact(0.0)

    def _coefficients(self, wrist: Any, dt: float, again: Number, sliding: Number = 0.0) -> SampledStickSlip:
        friction = sliding * self.breakaway
        residue = friction + again * (self.breakaway - friction)
        return SampledStickSlip(self.breakaway, friction, residue, lag.sampled(wrist.Tw, dt))


@dataclass(frozen=True)
class FreeSlip(_StickSlip):
    """Once it has broken away, the joint slides without friction until it sticks again."""

    FORM = "slides freely"
    MASSLESS = True

    breakaway: Number = _BREAKAWAY
    residue: Number = _RESIDUE

    def sampled(self, wrist: Any, dt: float) -> SampledStickSlip:
        return self._coefficients(wrist, dt, self.residue)


@dataclass(frozen=True)
class RubbingSlip(_StickSlip):
    """The joint slides against friction, which is less than that which it breaks away from."""

    FORM = "slides against friction"
    MASSLESS = True

    breakaway: Number = _BREAKAWAY
    sliding: Number = _SLIDING
    residue: Number = _RESIDUE

    def sampled(self, wrist: Any, dt: float) -> SampledStickSlip:
        return self._coefficients(wrist, dt, self.residue, self.sliding)


@dataclass(frozen=True)
class BristleFriction(_StickSlip):
    """LuGre's law: bristles that bend before the joint slides, with less friction the faster it slides."""

    FORM = "bristles"

    breakaway: Number = _BREAKAWAY
    sliding: Number = parameter("1", "friction of fast sliding over breakaway", 0.02, 1.0, 1.0, (0.5,))
    stribeck: Number = parameter("deg/s", "speed at which it slides easily", 0.1, 100.0, 2.0, (1.0, 4.0))
    stiffness: Number = parameter(
        "1", "stiffness of the bristles over the joint's", 1.0, 300.0, 25.0, (25.0,)
    )

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Bristles:
        return Bristles(0.0 * pressure, 0.0 * pressure)

    def sampled(self, wrist: Any, dt: float) -> SampledBristles:
        most = np.maximum(self.breakaway, LEVEL)
        return SampledBristles(
            most, self.sliding * most, 1.0 / np.asarray(self.stribeck, float), self.stiffness, 0.5 * dt
        )


@dataclass(frozen=True)
class MaxwellSlip(_StickSlip):
    """Springs of one stiffness side by side, each of which slips at a pull of its own, evenly spaced."""

    FORM = "Maxwell slip"

    breakaway: Number = _BREAKAWAY
    stiffness: Number = parameter(
        "1", "stiffness of all springs over the joint's", 0.5, 50.0, 8.0, (4.0, 10.0)
    )

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Springs:
        return Springs((0.0 * pressure,) * SPRINGS)

    def sampled(self, wrist: Any, dt: float) -> SampledSprings:
        most = tuple(self.breakaway * ((2 * i + 1) / SPRINGS**2) for i in range(SPRINGS))
        return SampledSprings(most, self.stiffness / SPRINGS)
