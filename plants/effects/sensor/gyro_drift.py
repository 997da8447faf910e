"""Gyro drift: the measured angle drifts with time, for the sensor integrates a rate with a bias."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Nothing, Number, parameter
from plants.effects.hints import ExcitationHints


class SampledDrift(NamedTuple):
    """Rate [deg/s] that lasts, rate that decays at first, and 1 / its time constant [1/s]."""

    rate: Number
    early: Number
    per_time: Number

    def sensor(self, s: Nothing, angle: Number, around: Around) -> Number:
        decayed = (1.0 - np.exp(-around.time * self.per_time)) / self.per_time
        return angle + self.rate * around.time + self.early * decayed


class _Drifting(Effect):
    """What the forms share: the sensor integrates noise too, so that it wanders besides."""

    NAME = "gyro-drift"
    STAGE = "sensor"
    HAPPENS = "The angle sensor drifts"
    WANDERS = True
    BOUND = "kept"

    def borrowed(self, asked: ExcitationHints) -> str | None:
        """In one ramp of the command time and command are the same."""
        if asked.ramp:
            return "the command is one ramp, which goes with time as a drift does; record steps up and down"
        return None


@dataclass(frozen=True)
class Drift(_Drifting):
    """A constant bias of the rate [deg/s]: the angle drifts along a straight line."""

    FORM = "constant rate"

    rate: Number = parameter("deg/s", "drift of the measured angle", -2.0, 2.0, 0.0, (-0.02, 0.02))

    def sampled(self, wrist: Any, dt: float) -> SampledDrift:
        return SampledDrift(self.rate, 0.0, 1.0)


@dataclass(frozen=True)
class WarmingDrift(_Drifting):
    """A bias that changes as the sensor warms up: `rate` in the end, `early` [deg/s] more at first."""

    FORM = "rate that changes while warming up"

    rate: Number = parameter(
        "deg/s", "drift of the measured angle in the end", -2.0, 2.0, 0.0, (-0.02, 0.0, 0.02)
    )
    early: Number = parameter("deg/s", "further drift at first", -5.0, 5.0, 0.0, (-0.04, 0.04))
    time_constant: Number = parameter(
        "s", "time constant of warming up", 1.0, 1000.0, 40.0, (10.0, 40.0, 120.0)
    )

    def sampled(self, wrist: Any, dt: float) -> SampledDrift:
        return SampledDrift(self.rate, self.early, 1.0 / np.asarray(self.time_constant, float))
