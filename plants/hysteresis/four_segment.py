"""Hysteresis of the paper's wrist: pressure to static angle, four straight segments with memory.

Section 5 of the paper.  With x = P - rest_pressure:

    line 1   h = a1 x - w1   (right-hand, ascending; the wrist moves in the plus direction)
    line 2   h = a2 x + w2   (left-hand, descending; the wrist moves in the minus direction)
    transit  slope s, between the two lines
    virgin   h = 0 from rest until a line is met (the initial curve, the dead zone of section 5.1)

Inside the loop the angle follows the transit slope and no line is ever
overstepped, which is all the memory there is: the angle itself, and whether
the wrist has left the virgin curve.  It is a generalised play in z = h - s x.

The exact inverse.  A monotone move from the memory (h, virgin) at the pressure P goes along the transit
until it meets a line,

    up     H(P') = max(h + s (P' - P), line1(P')),
    down   H(P') = min(h + s (P' - P), line2(P')),      s = 0 on the virgin curve,

and both rise with P', so that the pressure of an angle r is where the first of the two gets there:
the transit's pressure of r, kept between those at which line 2 and line 1 have r.  Where many
pressures give r (r = h on the virgin curve, or on a transit without slope) the smallest move is
taken: to stay.  Kuhnen, European J. Control 9 (2003), inverts play operators likewise, by
memory; the general theory is Krasnosel'skii & Pokrovskii, Systems with Hysteresis (1989).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.hysteresis.law import REST_PRESSURE, Bend, HysteresisLaw, Role, Side, Start
from plants.hysteresis.play import kept
from plants.hysteresis.rough_loop import RoughLoop
from plants.meanings import remembers
from plants.parameters.spec import Kind
from plants.rig import built_in_rig

Number = Any

LEVEL = 1e-30
"""A transit less steep than this [deg/kPa] counts as one without slope, so that no quotient overflows."""


@remembers(
    h=("deg", "static angle: the memory of the loop"),
    virgin=("", "1 before the wrist has met a line of its loop, 0 afterwards"),
)
class Memory(NamedTuple):
    """State of the loop: static angle h [deg]; virgin is 1.0 before a line was met, else 0.0."""

    h: Number
    virgin: Number


@dataclass(frozen=True)
class FourSegment(HysteresisLaw):
    """Parameters of the loop: slopes a1, a2, s [deg/kPa], half widths w1, w2 [deg],
    rest_pressure [kPa].

    >>> loop = FourSegment(a1=0.36, w1=6.0, a2=0.36, w2=6.0, s=0.08)
    >>> up = loop.step(loop.initial(), 100.0, 150.0)      # dead zone, then line 1
    >>> float(up.h), float(up.virgin)
    (12.0, 0.0)
    >>> float(loop.step(up, 150.0, 140.0).h)              # reversal: transit
    11.2
    """

    NAME = "four-segment"
    DEAD_ZONE = True
    MONOTONE = True

    a1: Number
    w1: Number
    a2: Number
    w2: Number
    s: Number
    rest_pressure: Number = built_in_rig().rest_pressure

    @classmethod
    def kinds(cls, names: Iterable[str] = ()) -> dict[str, Kind]:
        """The six parameters.

        One of the offsets may be negative, where angle 0 lies outside the loop; see `problem`.
        """
        return {
            "a1": Kind("deg/kPa", "slope of line 1 (plus direction)", 0.01, 5.0),
            "w1": Kind("deg", "offset of line 1 below the origin", -60.0, 60.0),
            "a2": Kind("deg/kPa", "slope of line 2 (minus direction)", 0.01, 5.0),
            "w2": Kind("deg", "offset of line 2 above the origin", -60.0, 60.0),
            "s": Kind("deg/kPa", "slope of the transit between the lines", 0.0, 5.0),
            "rest_pressure": REST_PRESSURE,
        }

    @classmethod
    def roles(cls, names: Iterable[str]) -> dict[Role, tuple[str, ...]]:
        """The slopes of the lines, that of the transit, the offsets."""
        return {"outer": ("a1", "a2"), "inner": ("s",), "width": ("w1", "w2")}

    @classmethod
    def guess(cls, loop: RoughLoop) -> dict[str, float]:
        """Parallel lines."""
        a, w = loop.outer, loop.width
        return {"a1": a, "w1": w, "a2": a, "w2": w, "s": loop.inner, "rest_pressure": loop.rest}

    def problem(self, low: float, high: float) -> str | None:
        """Why the four segments make no loop between two pressures [kPa], or None if they do.

        >>> FourSegment(a1=0.05, w1=6.0, a2=0.36, w2=6.0, s=0.08).problem(0.0, 200.0)
        'transit slope s = 0.08 is not below a1 = 0.05, so the loop runs backwards'
        """
        for line, slope in (("a1", self.a1), ("a2", self.a2)):
            if not self.s < slope:
                words = f"transit slope s = {self.s:g} is not below {line} = {slope:g}"
                return f"{words}, so the loop runs backwards"
        for pressure in (low, high):
            gap = (self.a2 - self.a1) * (pressure - self.rest_pressure) + self.w1 + self.w2
            if not gap > 0:
                return f"line 1 lies above line 2 at {pressure:g} kPa, so the loop runs backwards"
        return None

    def kept_apart(self, low: float, high: float) -> dict[str, tuple[float, float]]:
        """Lines of nearly one slope, so far apart that they cannot cross, and a transit below both.

        >>> crossed = FourSegment(a1=0.6, w1=6.0, a2=0.3, w2=6.0, s=0.4)
        >>> {n: (round(a, 2), round(b, 2)) for n, (a, b) in crossed.kept_apart(0.0, 200.0).items()}
        {'a1': (0.43, 0.46), 'a2': (0.43, 0.46), 'w1': (1.5, 24.0), 'w2': (1.5, 24.0), 's': (0.0, 0.43)}
        """
        slope = 0.5 * (self.a1 + self.a2)
        reach = max(abs(low - self.rest_pressure), abs(high - self.rest_pressure))
        width = max(0.5 * (self.w1 + self.w2), 0.02 * slope * reach)
        apart = min(0.25 * width / reach, 0.5 * slope)
        lines, offsets = (slope - apart, slope + apart), (0.25 * width, 4.0 * width)
        return {"a1": lines, "a2": lines, "w1": offsets, "w2": offsets, "s": (0.0, 0.99 * (slope - apart))}

    def initial(self) -> Memory:
        """At 0 on the virgin curve."""
        return Memory(0.0, 1.0)

    def step(self, memory: Memory, before: Number, after: Number, bend: Bend | None = None) -> Memory:
        """Along the transit, and kept between the lines."""
        low, high, slope = self.ascending(after), self.descending(after), self.s
        if bend is not None:
            low, high, slope = low + bend.low, high + bend.high, slope * bend.slope
        inside = memory.h + slope * (1.0 - memory.virgin) * (after - before)
        h = kept(inside, low, high)
        return Memory(h, np.where(h == inside, memory.virgin, 0.0))

    def ascending(self, pressure: Number) -> Number:
        """Line 1."""
        return self.a1 * (pressure - self.rest_pressure) - self.w1

    def descending(self, pressure: Number) -> Number:
        """Line 2."""
        return self.a2 * (pressure - self.rest_pressure) + self.w2

    def ascending_pressure(self, angle: Number) -> Number:
        """Of line 1."""
        return self.rest_pressure + (angle + self.w1) / self.a1

    def descending_pressure(self, angle: Number) -> Number:
        """Of line 2."""
        return self.rest_pressure + (angle - self.w2) / self.a2

    def rise(self, pressure: Number) -> tuple[Number, Number]:
        """The lines without their offsets."""
        x = pressure - self.rest_pressure
        return self.a1 * x, self.a2 * x

    def halves(self, pressure: Number) -> tuple[Number, Number]:
        """The offsets, the same at every pressure."""
        return self.w1, self.w2

    @property
    def steepness(self) -> tuple[Number, Number]:
        """Those of the lines."""
        return self.a1, self.a2

    @property
    def flattest(self) -> Number:
        """That of the transit."""
        return self.s

    def first_slope(self, memory: Memory) -> Number:
        """That of the transit; 0 on the virgin curve."""
        return self.s * (1.0 - memory.virgin)

    def resting(
        self, start: Start, angle: Number, pressure: Number, low: Number = 0.0, high: Number = 0.0
    ) -> Memory:
        """The angle is all there is to remember."""
        return Memory(angle, float(start == "virgin"))

    def recalled(self, angle: Number, pressure: Number) -> Memory:
        """The angle, kept between the lines."""
        return Memory(kept(angle, self.ascending(pressure), self.descending(pressure)), 0.0)

    def doubted(self, memory: Memory, doubt: Number) -> Memory:
        """Off the virgin curve where it is doubted."""
        return memory._replace(virgin=np.where(doubt, 0.0, memory.virgin))

    def moved(self, memory: Memory, shift: Number, pressure: Number) -> Memory:
        """The angle moved and kept between the lines; on the virgin curve it stays."""
        corrected = memory.h + (1.0 - memory.virgin) * shift
        return Memory(kept(corrected, self.ascending(pressure), self.descending(pressure)), memory.virgin)

    def pressure_for(self, memory: Memory, before: Number, angle: Number) -> Number:
        """Exact to rounding for every memory that a loop without a `problem` can have.

        >>> loop = FourSegment(a1=0.36, w1=6.0, a2=0.36, w2=6.0, s=0.08)
        >>> float(loop.pressure_for(Memory(0.0, 1.0), 100.0, 12.0))    # through the dead zone, to line 1
        150.0
        >>> float(loop.pressure_for(Memory(12.0, 0.0), 150.0, 11.2))   # reversal: the transit
        140.0
        >>> float(loop.pressure_for(Memory(0.0, 1.0), 103.0, 0.0))     # of many pressures, to stay
        103.0
        """
        low, high = self.descending_pressure(angle), self.ascending_pressure(angle)
        slope = self.first_slope(memory)
        slopes = slope > LEVEL
        inside = before + (angle - memory.h) / np.where(slopes, slope, 1.0)
        transit = np.minimum(np.maximum(inside, low), high)
        straight = np.where(angle > memory.h, high, low)
        return np.where(angle == memory.h, before, np.where(slopes, transit, straight))

    def corner_pressure(self, memory: Memory, before: Number, up: Number) -> Number:
        """Pressure [kPa] at which the transit from the memory at `before` [kPa] meets line 1 (`up` true) or
        line 2: where a move in that direction leaves it."""
        slope = self.first_slope(memory)
        a, w = np.where(up, self.a1, self.a2), np.where(up, -self.w1, self.w2)
        return before + (memory.h - a * (before - self.rest_pressure) - w) / (a - slope)

    def turn(self, memory: Memory, before: Number, end: Number, up: Number) -> tuple[Number, Number]:
        """Where the transit meets a line."""
        met = self.corner_pressure(memory, before, up)
        corner = np.where(up, np.minimum(met, end), np.maximum(met, end))
        return corner, memory.h + self.first_slope(memory) * (corner - before)

    def branches(
        self, low: float, high: float, within: tuple[float, float] | None = None
    ) -> dict[str, float]:
        """The transit and the two lines; the virgin curve has slope 0 and is left once, for good."""
        return {"transit": self.s, "line1": self.a1, "line2": self.a2}

    def straight(self) -> bool:
        """They are."""
        return True

    def sides(self, branch: str) -> tuple[Side, ...]:
        """One each."""
        of: dict[str, Side] = {"transit": "inner", "line1": "ascending", "line2": "descending"}
        return (of[branch],)
