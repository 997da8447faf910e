"""Modified Prandtl-Ishlinskii hysteresis: a sum of plays, seen through a monotone output curve.

With x = P - rest_pressure, n plays p_i of thresholds r_i = reach i / n and weights v_i >= 0,

    u = v0 x + sum_i v_i p_i,        p_i+ = min(max(p_i, x - r_i), x + r_i),        h = C(u),

where C is a superposition of one-sided dead zones: piecewise linear and rising, C(0) = 0, and of slope 1 for
u - centre between -span and span, c1 and c2 beyond span and 2 span, b1 and b2 below -span and -2 span.  It
makes the loop curved and lets it be narrow at one end.  The centre is that of what a rig reaches, so that a
rig that bends to one side only has all five pieces there.  The law that most of the literature on pneumatic
muscles and piezo stages uses (Kuhnen, European J. Control 9 (2003) 407, doi 10.3166/ejc.9.407-418).

Four straight segments with equal slopes are the special case of one play and a straight curve: s = v0,
a = v0 + v1, w = v1 reach.  Only the initial curve differs: here it has the slope v0, there it has none.

The inverse is exact, and in closed form: that of the curve, then that of the `sum_of_plays`.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from plants.hysteresis.law import REST_PRESSURE, Bend, HysteresisLaw, Role, Side, Start
from plants.hysteresis.output_curve import OutputCurve
from plants.hysteresis.play import kept, play
from plants.hysteresis.rough_loop import RoughLoop
from plants.hysteresis.sum_of_plays import LEVEL, inputs_for, summed
from plants.meanings import remembers
from plants.parameters.spec import Kind
from plants.rig import built_in_rig

Number = Any

PLAYS = 4
"""Plays of a set that does not say how many."""

LEAST_SPAN, LEAST_WEIGHT = 0.5, 1e-3
"""Of a guess: span of the curve [deg], and weight of a play over that of all, so that a fit has a start."""

CURVE = ("centre", "span", "b2", "b1", "c1", "c2")

REVERSED = "after a reversal"
"""The branch on which no play is engaged."""


@remembers(
    h=("deg", "static angle"),
    plays=("kPa", "value of a play of the loop's memory, the smallest threshold first"),
)
class PlayMemory(NamedTuple):
    """State of the loop: static angle h [deg], and the plays [kPa], the smallest threshold first."""

    h: Number
    plays: tuple[Number, ...]


@dataclass(frozen=True)
class PrandtlIshlinskii(HysteresisLaw):
    """Parameters: weights v0 and v = (v1, ... vn) [deg/kPa] of the plays, largest threshold `reach` [kPa],
    centre and span of the curve [deg] and its slopes relative to the middle, rest_pressure [kPa].

    >>> loop = PrandtlIshlinskii(0.08, (0.28,), 20.0)     # four segments of slopes 0.36 and 0.08
    >>> up = loop.step(loop.initial(), 100.0, 150.0)
    >>> round(float(up.h), 9), round(float(loop.step(up, 150.0, 140.0).h), 9)
    (12.4, 11.6)
    """

    NAME = "prandtl-ishlinskii"
    SHIFTS = True
    MONOTONE = True
    NEUTRAL = MappingProxyType({"b2": 1.0, "c2": 1.0, "b1": 1.0, "c1": 1.0})

    v0: Number
    v: tuple[Number, ...]
    reach: Number
    span: Number = 20.0
    b2: Number = 1.0
    b1: Number = 1.0
    c1: Number = 1.0
    c2: Number = 1.0
    rest_pressure: Number = built_in_rig().rest_pressure
    centre: Number = 0.0

    @classmethod
    def kinds(cls, names: Iterable[str] = ()) -> dict[str, Kind]:
        """One weight more than there are plays: as many as `names` has, `PLAYS` where it has none."""
        given = [n for n in names if n[:1] == "v" and n[1:].isdigit() and n != "v0"]
        n = len(given) or PLAYS
        slope = "relative slope of the output curve "
        return {
            "v0": Kind("deg/kPa", "weight of the pressure itself: slope after a reversal", 0.0, 5.0),
            **{f"v{i}": Kind("deg/kPa", f"weight of play {i} of {n}", 0.0, 5.0) for i in range(1, n + 1)},
            "reach": Kind("kPa", "threshold of the largest play: half the loop's width", 0.1, 1000.0),
            "centre": Kind("deg", "sum of the plays in the middle of the output curve", -60.0, 60.0),
            "span": Kind("deg", "distance from there at which the curve bends", LEAST_SPAN, 1000.0),
            "b2": Kind("1", f"{slope}more than 2 span below the centre", 0.05, 20.0),
            "b1": Kind("1", f"{slope}from 2 span to span below it", 0.05, 20.0),
            "c1": Kind("1", f"{slope}from span to 2 span above it", 0.05, 20.0),
            "c2": Kind("1", f"{slope}more than 2 span above it", 0.05, 20.0),
            "rest_pressure": REST_PRESSURE,
        }

    @property
    def values(self) -> dict[str, Number]:
        """The weights as v0, v1, ... vn."""
        own = {f"v{i}": v for i, v in enumerate(self.v, start=1)}
        rest = {n: getattr(self, n) for n in ("reach", *CURVE, "rest_pressure")}
        return {"v0": self.v0, **own, **rest}

    @classmethod
    def from_values(cls, values: Mapping[str, Number]) -> "PrandtlIshlinskii":
        """With as many plays as `values` has weights."""
        names = [n for n in cls.kinds(values) if n[0] == "v" and n != "v0"]
        rest = {n: values[n] for n in ("reach", *CURVE, "rest_pressure")}
        return cls(values["v0"], tuple(values[n] for n in names), **rest)

    @classmethod
    def roles(cls, names: Iterable[str]) -> dict[Role, tuple[str, ...]]:
        """The weights of the plays, that of the pressure itself, the thresholds."""
        weights = tuple(n for n in cls.kinds(names) if n[0] == "v" and n != "v0")
        return {"outer": weights, "inner": ("v0",), "width": ("reach",)}

    @classmethod
    def guess(cls, loop: RoughLoop) -> dict[str, float]:
        """The plays, none without a weight, and the curve, its pieces equally long where it is straight."""
        curve = loop.curve or loop.straight(LEAST_SPAN)
        outer, zero = curve.slope * loop.outer, curve.zero
        least = LEAST_WEIGHT * outer
        plays = {f"v{i}": max(curve.slope * w, least) for i, w in enumerate(loop.weights, start=1)}
        about = curve.about._replace(span=max(curve.about.span, LEAST_SPAN))
        return {
            "v0": curve.slope * loop.inner, **plays, "reach": loop.reach, "centre": curve.centre - zero,
            **about._asdict(), "rest_pressure": zero / outer,
        }  # fmt: skip

    def problem(self, low: float, high: float) -> str | None:
        """Nothing is wrong with plays whose weights are not negative, of which one at least acts."""
        if min(self.v0, *self.v) < 0.0:
            return "a weight of a play is negative, so the loop runs backwards"
        return None if sum(self.v) > 0.0 and self.reach > 0.0 else "no play has a weight, so there is no loop"

    def counted_from(self, angle: float) -> "PrandtlIshlinskii":
        """Plays and curve stay where they are; the pressure that holds the angle is counted from.

        >>> loop = PrandtlIshlinskii(0.1, (0.2,), 15.0, span=4.0, c1=0.5)
        >>> moved = loop.counted_from(9.0)
        >>> round(float(moved.ascending(160.0) + 9.0 - loop.ascending(160.0)), 12)
        0.0
        """
        total = self.uncurved(angle)
        by = total / np.maximum(self._outer, LEVEL)
        return replace(self, centre=self.centre - total, rest_pressure=self.rest_pressure + by)

    @property
    def thresholds(self) -> tuple[Number, ...]:
        """Of the plays [kPa], equally spaced."""
        n = len(self.v)
        return tuple(self.reach * (i / n) for i in range(1, n + 1))

    @property
    def _about(self) -> OutputCurve:
        """The output curve about its centre."""
        return OutputCurve(self.span, self.b2, self.b1, self.c1, self.c2)

    def curve(self, u: Number) -> Number:
        """The output curve C: what the sum of plays u [deg] is seen as [deg]."""
        return self._about.value(u - self.centre) - self._about.value(-self.centre)

    def uncurved(self, angle: Number) -> Number:
        """The inverse of the output curve, in closed form."""
        return self.centre + self._about.inverse(angle + self._about.value(-self.centre))

    def initial(self) -> PlayMemory:
        """All plays at 0."""
        return PlayMemory(0.0, (0.0,) * len(self.v))

    def unmoved(self, angle: Number) -> PlayMemory:
        """All plays in the middle of their gaps: the law is the same counted from any angle."""
        if not np.any(angle):
            return self.initial()
        return PlayMemory(angle, (self.uncurved(angle) / np.maximum(self._outer, LEVEL),) * len(self.v))

    def step(self, memory: PlayMemory, before: Number, after: Number, bend: Bend | None = None) -> PlayMemory:
        """Every play by itself.  A bend shifts the angle by what it does to the two outer branches, in
        proportion to where between them it lies; the slope between them follows."""
        x = after - self.rest_pressure
        plays = tuple(play(p, x, r) for p, r in zip(memory.plays, self.thresholds, strict=True))
        h = self.curve(summed(x, self.v0, self.v, plays))
        if bend is not None:
            low, high = self.ascending(after), self.descending(after)
            share = (h - low) / np.maximum(high - low, LEVEL)
            h = h + (1.0 - share) * bend.low + share * bend.high
        return PlayMemory(h, plays)

    @property
    def _outer(self) -> Number:
        return self.v0 + sum(self.v)

    @property
    def _width(self) -> Number:
        """Half width of the loop before the curve [deg]."""
        return sum(v * r for v, r in zip(self.v, self.thresholds, strict=True))

    def ascending(self, pressure: Number) -> Number:
        """All plays carried along by rising pressure."""
        return self.curve(self._outer * (pressure - self.rest_pressure) - self._width)

    def descending(self, pressure: Number) -> Number:
        """All plays carried along by falling pressure."""
        return self.curve(self._outer * (pressure - self.rest_pressure) + self._width)

    def ascending_pressure(self, angle: Number) -> Number:
        """In closed form."""
        return self.rest_pressure + (self.uncurved(angle) + self._width) / self._outer

    def descending_pressure(self, angle: Number) -> Number:
        """In closed form."""
        return self.rest_pressure + (self.uncurved(angle) - self._width) / self._outer

    @property
    def steepness(self) -> tuple[Number, Number]:
        """With every play engaged, in the middle of the curve."""
        return self._outer, self._outer

    @property
    def flattest(self) -> Number:
        """With no play engaged, in the middle of the curve."""
        return self.v0

    def _spread(self, angle: Number, share: Number, pressure: Number) -> PlayMemory:
        """Plays at a share (-1 ascending, 1 descending) of their thresholds from the pressure [kPa]."""
        x = pressure - self.rest_pressure
        return PlayMemory(angle, tuple(x + share * r for r in self.thresholds))

    def resting(
        self, start: Start, angle: Number, pressure: Number, low: Number = 0.0, high: Number = 0.0
    ) -> PlayMemory:
        """Every play at the same share of its threshold: what a demagnetising motion leaves."""
        if start == "virgin":
            return self.initial()
        if start != "inside":
            return self._spread(angle, -1.0 if start == "line1" else 1.0, pressure)
        least, most = self.ascending(pressure) + low, self.descending(pressure) + high
        up, down = self.ascending(pressure), self.descending(pressure)
        straight = up + (angle - least) / np.maximum(most - least, LEVEL) * (down - up)
        return self.recalled(straight, pressure)._replace(h=angle)

    def recalled(self, angle: Number, pressure: Number) -> PlayMemory:
        """Every play at the same share of its threshold."""
        inside = kept(angle, self.ascending(pressure), self.descending(pressure))
        x = pressure - self.rest_pressure
        share = (self.uncurved(inside) - self._outer * x) / np.maximum(self._width, LEVEL)
        return self._spread(inside, kept(share, -1.0, 1.0), pressure)

    def moved(self, memory: PlayMemory, shift: Number, pressure: Number) -> PlayMemory:
        """All plays moved alike, each as far as its gap allows."""
        x = pressure - self.rest_pressure
        aim = self.uncurved(memory.h + shift) - self.uncurved(memory.h)
        by = aim / np.maximum(sum(self.v), LEVEL)
        plays = tuple(play(p + by, x, r) for p, r in zip(memory.plays, self.thresholds, strict=True))
        return PlayMemory(self.curve(summed(x, self.v0, self.v, plays)), plays)

    def pressure_for(self, memory: PlayMemory, before: Number, angle: Number) -> Number:
        """The first of the pieces to get there on the way up, or on the way down.

        >>> loop = PrandtlIshlinskii(0.05, (0.1, 0.1), 20.0, span=5.0, c1=2.0)
        >>> up = loop.step(loop.initial(), 100.0, 150.0)
        >>> round(float(loop.step(up, 150.0, loop.pressure_for(up, 150.0, 3.0)).h), 12)
        3.0
        """
        total = self.uncurved(angle)
        x_up, x_down = inputs_for(total, self.v0, self.v, memory.plays, self.thresholds)
        up, down = self.rest_pressure + x_up, self.rest_pressure + x_down
        # By rounding alone a piece without a slope may lead the other way.
        moved = np.where(angle > memory.h, np.maximum(up, before), np.minimum(down, before))
        return np.where(angle == memory.h, before, moved)

    def turn(self, memory: PlayMemory, before: Number, end: Number, up: Number) -> tuple[Number, Number]:
        """Half-way: the slope grows play by play."""
        middle = 0.5 * (before + end)
        return middle, self.step(memory, before, middle).h

    def straight(self) -> bool:
        """Where the output curve is."""
        return all(float(m) == 1.0 for m in (self.b2, self.b1, self.c1, self.c2))

    def branches(
        self, low: float, high: float, within: tuple[float, float] | None = None
    ) -> dict[str, float]:
        """With no play engaged and with all of them, on the flattest and on the steepest piece of the curve
        that these pressures reach; what some of the plays make lies between, and so needs no name.  A law
        with a curve has all three names, even where its pieces there have one slope."""
        outer, width = float(self._outer), float(self._width)

        def plays(pressure: float, side: float) -> float:
            return outer * (pressure - float(self.rest_pressure)) + side * width

        ends = [plays(p, side) for p in (low, high) for side in (-1.0, 1.0)]
        if within is not None:
            # The plays go no further down than on the descending branch at the least pressure, and no
            # further up than on the ascending one at the largest.
            least, most = sorted((plays(within[0], 1.0), plays(within[1], -1.0)))
            ends = [min(max(u, least), most) for u in ends]
        c = float(self.centre)
        reached = self._about.slopes_between(min(ends) - c, max(ends) - c)
        first = float(self.v0) * min(reached)
        least, most = outer * min(reached), outer * max(reached)
        if len(set(self._about.slopes)) == 1:
            return {REVERSED: first, "outer branch": most}
        return {REVERSED: first, "outer branch, flattest": least, "outer branch, steepest": most}

    def sides(self, branch: str) -> tuple[Side, ...]:
        """Between the outer branches, or on them."""
        return ("inner",) if branch == REVERSED else ("ascending", "descending")
