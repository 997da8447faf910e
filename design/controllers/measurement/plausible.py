"""Samples that no plant can have made are refused before a law sees them.

A reading is believed where it lies within the range of its sensor and no further from the last one that was
believed than

    jump + rate (time since then),

jump being for noise.  What is allowed grows until a reading is believed, so that a value that was believed
wrongly, or a sensor that was put back elsewhere, costs at most `RECOVERY`: after that any reading within the
range is believed.  A reading that is not a number is never believed.
"""

from dataclasses import dataclass, replace
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from design.controllers.controller import remembers
from plants.errors import InputError
from plants.wrist import Wrist

Number = Any

RECOVERY = 0.5
"""Time [s] after which any reading within the range is believed."""

JUMP = 0.05
"""Share of what the plant can show by which two readings may differ whatever the time: noise, quanta."""

FASTER = 4.0
"""How many times faster than the model's fastest motion a reading may move: the model may be wrong."""

UNSEEN = 1e9
"""Samples since the last reading that was believed, where there was none."""


@dataclass(frozen=True)
class Channel:
    """What a sensor can show: low and high, the ends of its range; jump, in the same unit; rate, in the
    unit per second.  Raises InputError for a range or a rate that is none."""

    low: float
    high: float
    jump: float
    rate: float

    def __post_init__(self) -> None:
        if not (isfinite(self.low) and isfinite(self.high) and self.low < self.high):
            raise InputError(f"sensor range {self.low:g} to {self.high:g}: give two numbers, the lower first")
        if not (self.jump > 0.0 and self.rate > 0.0):
            raise InputError("jump and rate of a sensor must be positive")

    @classmethod
    def around(cls, low: float, high: float, fastest: float) -> "Channel":
        """The channel of a plant that shows values from low to high and moves so fast at most [unit/s]: as
        much again is left on either side, for loads, drifts and offsets."""
        width = high - low
        return cls(
            low - width, high + width, JUMP * width, max(FASTER * fastest, 3.0 * width / RECOVERY)
        )  # fmt: skip

    def sampled(self, dt: float) -> "Channel":
        """The same with the rate per sample, of a sample time `dt` [s]."""
        return replace(self, rate=self.rate * dt)

    def holds(self, value: Number) -> Number:
        """1 where a value lies in the range, else 0; also for what is not a number.

        >>> channel = Channel.around(0.0, 200.0, 1800.0)
        >>> [float(channel.holds(x)) for x in (250.0, 1e9, float("nan"))]
        [1.0, 0.0, 0.0]
        """
        return np.where(value >= self.low, 1.0, 0.0) * np.where(value <= self.high, 1.0, 0.0)


@remembers(
    value=("", "last reading that was believed"),
    age=("", "samples since the last reading that was believed"),
)
class LastBelieved(NamedTuple):
    """The last reading of a sensor that was believed, and how many samples ago that was."""

    value: Number
    age: Number = UNSEEN


def believed(s: LastBelieved, value: Number, of: Channel) -> tuple[LastBelieved, Number]:
    """What is remembered after a reading, one sample after the one before, and whether it is believed (1)
    or not (0); `of` as `Channel.sampled` gives it.

    >>> channel = Channel.around(0.0, 200.0, 1800.0).sampled(0.001)
    >>> s, _ = believed(LastBelieved(100.0), 100.0, channel)
    >>> s, good = believed(s, 110.0, channel)
    >>> s, spike = believed(s, 160.0, channel)
    >>> float(good), float(spike), float(s.value), float(s.age)
    (1.0, 0.0, 110.0, 1.0)
    """
    age = s.age + 1.0
    near = np.where(np.abs(value - s.value) <= of.jump + of.rate * age, 1.0, 0.0)
    good = of.holds(value) * near
    return LastBelieved(np.where(good > 0.5, value, s.value), np.where(good > 0.5, 0.0, age)), good


@dataclass(frozen=True)
class SensorLimits:
    """What the sensors of a rig can show, angle [deg] and pressure [kPa], and where it rests: the start
    that is taken where none can be believed."""

    angle: Channel
    pressure: Channel
    rest_angle: float
    rest_pressure: float

    @classmethod
    def of(cls, wrist: Wrist) -> "SensorLimits":
        """Those of a wrist's rig: its range of pressure, the angles that its loop reaches with them.

        >>> limits = SensorLimits.of(Wrist.flexion())
        >>> limits.pressure.low, limits.pressure.high
        (-200.0, 400.0)
        """
        loop, air = wrist.hysteresis, wrist.regulator
        low, high = wrist.rig.pressure_range
        least, most = (float(x) for x in loop.reachable(low, high))
        return cls(
            Channel.around(least, most, (most - least) / float(wrist.Tw)),
            Channel.around(low, high, (high - low) * float(max(air.k_fast, air.k_slow))),
            float(loop.initial().h),
            float(loop.rest_pressure),
        )

    def start(self, pressure: float, angle: float) -> tuple[float, float, bool]:
        """Pressure [kPa] and angle [deg] to start from, and whether they are those that were given: where
        one cannot be believed the plant is taken to rest.

        >>> SensorLimits.of(Wrist.flexion()).start(float("nan"), 3.0)
        (100.0, 0.0, False)
        """
        if bool(self.pressure.holds(pressure)) and bool(self.angle.holds(angle)):
            return pressure, angle, True
        return self.rest_pressure, self.rest_angle, False

    @property
    def settings(self) -> dict[str, float]:
        """All of it by name."""
        of = {"angle": self.angle, "pressure": self.pressure}
        return {f"{name} {n}": v for name, channel in of.items() for n, v in vars(channel).items()}
