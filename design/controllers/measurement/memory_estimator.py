"""On which branch the wrist stands: the loop's memory, which no sensor shows, from angle and pressure.

At rest the angle that is measured is the static angle h, and the pressure lies between those of line 2
and line 1 at h: together they are the memory, up to one bit.  Whether a wrist at (0, rest pressure) is
virgin cannot be read from them.  It is taken for virgin there and nowhere else: a wrist that has moved and
whose pressure went back to rest stands away from 0 (the loop's remanence), so that it comes to stand there
by chance alone; and the guess is harmless, since either memory meets a line at the same pressure.

While the wrist moves, the observer carries the loop along with the pressure that is measured, and
corrects it by the angle through the lag, both poles of the error at -bandwidth:

    h' = H(memory, P) + correct_h (y - y'),      y' = lag(y', h') + correct_y (y - y').

Whatever it believed, the error vanishes once the wrist runs along a line (the wiping-out property of
Preisach's memory: Mayergoyz, Mathematical Models of Hysteresis, 1991), because the memory is
kept between the lines; with bandwidth 0 that is all that corrects it.  The belief to be virgin is
given up when the angle leaves what it predicts by more than `doubt`.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from design.controllers.controller import remembers
from design.controllers.double_pole import double_pole
from plants import lag
from plants.dynamics import Number
from plants.hysteresis import HysteresisLaw
from plants.kernel import pytrees
from plants.wrist import SAMPLE_TIME, Wrist

NEAR_ANGLE = 0.3
"""Angle [deg] from 0 up to which a wrist at rest may be virgin: some times a sensor's noise.  Assumed."""

NEAR_PRESSURE = 1.5
"""Pressure [kPa] from that of rest up to which a wrist at rest may be virgin.  Assumed."""


def memory_at_rest(angle: Number, pressure: Number, p: HysteresisLaw) -> Any:
    """The memory of a loop that rests at a measured angle [deg] and pressure [kPa].

    What noise has put outside the loop is projected onto it: the angle moves to the nearest line.

    >>> from plants.hysteresis import FourSegment
    >>> loop = FourSegment(a1=0.36, w1=6.0, a2=0.36, w2=6.0, s=0.08)
    >>> [float(x) for x in memory_at_rest(0.1, 100.4, loop)]      # as good as never moved
    [0.0, 1.0]
    >>> [float(x) for x in memory_at_rest(11.9, 150.0, loop)]     # below line 1, by noise
    [12.0, 0.0]
    """
    near = np.where(np.abs(angle) < NEAR_ANGLE, 1.0, 0.0)
    virgin = near * np.where(np.abs(pressure - p.rest_pressure) < NEAR_PRESSURE, 1.0, 0.0)
    recalled = p.recalled(angle, pressure)
    pairs = zip(pytrees.leaves(p.initial()), pytrees.leaves(recalled), strict=True)
    return pytrees.like(recalled, [np.where(virgin > 0.5, a, b) for a, b in pairs])


def pressure_at_rest(angle: Number, pressure: Number, p: HysteresisLaw) -> Number:
    """The pressure [kPa] nearest to the one measured at which the loop can rest at the angle [deg]: the other
    projection onto the loop, for one who trusts the angle more."""
    low, high = p.descending_pressure(angle), p.ascending_pressure(angle)
    return np.minimum(np.maximum(pressure, low), high)


@dataclass(frozen=True)
class MemoryObserver:
    """The observer's idea of the hysteresis, and of the lag, Tw [s]; bandwidth [rad/s] of its correction;
    doubt [deg].

    Floats or arrays of lanes.  Raises ValueError for a setting that is not finite, for a bandwidth that is
    negative, and for a Tw or a doubt that is not positive.
    """

    hysteresis: HysteresisLaw
    Tw: Number
    bandwidth: Number = 15.0
    doubt: Number = 0.5

    def __post_init__(self) -> None:
        if not all(np.isfinite(np.asarray(v, float)).all() for v in pytrees.leaves(self)):
            raise ValueError("settings of a memory observer must be finite")
        if np.any(np.asarray(self.bandwidth) < 0.0):
            raise ValueError("bandwidth must not be negative")
        if np.any(np.asarray(self.Tw) <= 0.0) or np.any(np.asarray(self.doubt) <= 0.0):
            raise ValueError("Tw and doubt must be positive")

    @classmethod
    def of(cls, wrist: Wrist, bandwidth: Number = 15.0, doubt: Number = 0.5) -> "MemoryObserver":
        """The observer that believes what a wrist declares; its effects take no part."""
        return cls(wrist.hysteresis, wrist.Tw, bandwidth, doubt)

    @property
    def settings(self) -> dict[str, Number]:
        """All settings by name."""
        return {**self.hysteresis.values, "Tw": self.Tw, "bandwidth": self.bandwidth, "doubt": self.doubt}

    def sampled(self, dt: float = SAMPLE_TIME) -> "SampledObserver":
        """Coefficients for a sample time `dt` [s]."""
        c = lag.sampled(self.Tw, dt)
        # Both poles of the error at exp(-b dt), as those of the observer in `controllers.lqi`; at b = 0 none.
        pole = np.exp(-np.asarray(self.bandwidth, float) * dt)
        corrects = np.where(np.asarray(self.bandwidth) > 0.0, 1.0, 0.0)
        correct_y, correct_h = (corrects * gain for gain in double_pole(c.keep, pole))
        return SampledObserver(self.hysteresis, c, correct_h, correct_y, self.doubt)


@remembers(
    angle=("deg", "angle as observed"),
    pressure=("kPa", "pressure of the sample before"),
)
class ObserverState(NamedTuple):
    """What the observer believes: the loop's memory, the angle [deg]; and the pressure seen last [kPa]."""

    memory: Any
    angle: Number
    pressure: Number


class SampledObserver(NamedTuple):
    """Coefficients of the observer for one sample time."""

    hysteresis: HysteresisLaw
    lag: lag.SampledLag
    correct_h: Number
    correct_y: Number
    doubt: Number


def init(angle: Number, pressure: Number, c: SampledObserver) -> ObserverState:
    """The observer of a wrist that rests at a measured angle [deg] and pressure [kPa]."""
    return ObserverState(memory_at_rest(angle, pressure, c.hysteresis), angle, pressure)


def step(s: ObserverState, angle: Number, pressure: Number, c: SampledObserver) -> ObserverState:
    """The observer one sample later, at which `angle` [deg] and `pressure` [kPa] are measured.

    >>> observer = MemoryObserver.of(Wrist.flexion()).sampled()
    >>> after = step(init(0.0, 100.0, observer), 0.0, 101.0, observer)
    >>> float(after.memory.h), float(after.memory.virgin)       # in the dead zone
    (0.0, 1.0)
    """
    loop = c.hysteresis
    ahead = loop.step(s.memory, s.pressure, pressure)
    predicted = lag.step(s.angle, s.memory.h, ahead.h, c.lag)
    off = angle - predicted
    memory = loop.moved(loop.doubted(ahead, np.abs(off) > c.doubt), c.correct_h * off, pressure)
    return ObserverState(memory, predicted + c.correct_y * off, pressure)
