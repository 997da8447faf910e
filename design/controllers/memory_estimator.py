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
from typing import NamedTuple

import numpy as np

from design.controllers.controller import remembers
from design.controllers.double_pole import double_pole
from plants import hysteresis, lag
from plants.hysteresis import Hysteresis, Memory
from plants.wrist import SAMPLE_TIME, Number, Wrist

NEAR_ANGLE = 0.3
"""Angle [deg] from 0 up to which a wrist at rest may be virgin: some times a sensor's noise.  Assumed."""

NEAR_PRESSURE = 1.5
"""Pressure [kPa] from that of rest up to which a wrist at rest may be virgin.  Assumed."""


def memory_at_rest(angle: Number, pressure: Number, p: Hysteresis) -> Memory:
    """The memory of a loop that rests at a measured angle [deg] and pressure [kPa].

    What noise has put outside the loop is projected onto it: the angle moves to the nearest line.

    >>> loop = Hysteresis(a1=0.36, w1=6.0, a2=0.36, w2=6.0, s=0.08)
    >>> [float(x) for x in memory_at_rest(0.1, 100.4, loop)]      # as good as never moved
    [0.0, 1.0]
    >>> [float(x) for x in memory_at_rest(11.9, 150.0, loop)]     # below line 1, by noise
    [12.0, 0.0]
    """
    near = np.where(np.abs(angle) < NEAR_ANGLE, 1.0, 0.0)
    virgin = near * np.where(np.abs(pressure - p.rest_pressure) < NEAR_PRESSURE, 1.0, 0.0)
    low, high = hysteresis.line1(pressure, p), hysteresis.line2(pressure, p)
    return Memory(np.where(virgin > 0.5, 0.0, np.minimum(np.maximum(angle, low), high)), virgin)


def pressure_at_rest(angle: Number, pressure: Number, p: Hysteresis) -> Number:
    """The pressure [kPa] nearest to the one measured at which the loop can rest at the angle [deg]: the other
    projection onto the loop, for one who trusts the angle more."""
    low, high = hysteresis.line2_pressure(angle, p), hysteresis.line1_pressure(angle, p)
    return np.minimum(np.maximum(pressure, low), high)


@dataclass(frozen=True)
class MemoryObserver:
    """The observer's idea of the loop, a1, w1, a2, w2, s, rest_pressure as in a wrist, and of the lag, Tw
    [s]; bandwidth [rad/s] of its correction; doubt [deg].

    Floats or arrays of lanes.  Raises ValueError for a setting that is not finite, for a bandwidth that is
    negative, and for a Tw or a doubt that is not positive.
    """

    a1: Number
    w1: Number
    a2: Number
    w2: Number
    s: Number
    rest_pressure: Number
    Tw: Number
    bandwidth: Number = 15.0
    doubt: Number = 0.5

    def __post_init__(self) -> None:
        if not all(np.isfinite(np.asarray(v, float)).all() for v in vars(self).values()):
            raise ValueError("settings of a memory observer must be finite")
        if np.any(np.asarray(self.bandwidth) < 0.0):
            raise ValueError("bandwidth must not be negative")
        if np.any(np.asarray(self.Tw) <= 0.0) or np.any(np.asarray(self.doubt) <= 0.0):
            raise ValueError("Tw and doubt must be positive")

    @classmethod
    def of(cls, wrist: Wrist, bandwidth: Number = 15.0, doubt: Number = 0.5) -> "MemoryObserver":
        """The observer that believes what a wrist declares; its effects take no part."""
        return cls(**vars(wrist.hysteresis), Tw=wrist.Tw, bandwidth=bandwidth, doubt=doubt)

    def sampled(self, dt: float = SAMPLE_TIME) -> "SampledObserver":
        """Coefficients for a sample time `dt` [s]."""
        c = lag.sampled(self.Tw, dt)
        # Both poles of the error at exp(-b dt), as those of the observer in `controllers.lqi`; at b = 0 none.
        pole = np.exp(-np.asarray(self.bandwidth, float) * dt)
        corrects = np.where(np.asarray(self.bandwidth) > 0.0, 1.0, 0.0)
        correct_y, correct_h = (corrects * gain for gain in double_pole(c.keep, pole))
        return SampledObserver(
            self.a1, self.w1, self.a2, self.w2, self.s, self.rest_pressure, c,
            correct_h, correct_y, self.doubt,
        )  # fmt: skip


@remembers(
    angle=("deg", "angle as observed"),
    pressure=("kPa", "pressure of the sample before"),
)
class ObserverState(NamedTuple):
    """What the observer believes: the loop's memory, the angle [deg]; and the pressure seen last [kPa]."""

    memory: Memory
    angle: Number
    pressure: Number


class SampledObserver(NamedTuple):
    """Coefficients of the observer for one sample time."""

    a1: Number
    w1: Number
    a2: Number
    w2: Number
    s: Number
    rest_pressure: Number
    lag: lag.SampledLag
    correct_h: Number
    correct_y: Number
    doubt: Number

    @property
    def loop(self) -> Hysteresis:
        """The parameters of the hysteresis."""
        return Hysteresis(self.a1, self.w1, self.a2, self.w2, self.s, self.rest_pressure)


def init(angle: Number, pressure: Number, c: SampledObserver) -> ObserverState:
    """The observer of a wrist that rests at a measured angle [deg] and pressure [kPa]."""
    return ObserverState(memory_at_rest(angle, pressure, c.loop), angle, pressure)


def step(s: ObserverState, angle: Number, pressure: Number, c: SampledObserver) -> ObserverState:
    """The observer one sample later, at which `angle` [deg] and `pressure` [kPa] are measured.

    >>> observer = MemoryObserver.of(Wrist.flexion()).sampled()
    >>> after = step(init(0.0, 100.0, observer), 0.0, 101.0, observer)
    >>> float(after.memory.h), float(after.memory.virgin)       # in the dead zone
    (0.0, 1.0)
    """
    loop = c.loop
    ahead = hysteresis.step(s.memory, s.pressure, pressure, loop)
    predicted = lag.step(s.angle, s.memory.h, ahead.h, c.lag)
    off = angle - predicted
    virgin = np.where(np.abs(off) > c.doubt, 0.0, ahead.virgin)
    corrected = ahead.h + (1.0 - virgin) * c.correct_h * off
    low, high = hysteresis.line1(pressure, loop), hysteresis.line2(pressure, loop)
    memory = Memory(np.minimum(np.maximum(corrected, low), high), virgin)
    return ObserverState(memory, predicted + c.correct_y * off, pressure)
