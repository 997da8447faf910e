"""Creep: after the pressure has settled the angle goes on, slowly, as viscoelastic rubber does.

A share of the static angle follows through one or more slow first-order lags
(standard linear solids in series; Findley, Lai & Onaran, Creep and Relaxation
of Nonlinear Viscoelastic Materials, 1976, chapter 5).  Rubber gives no energy, so
that it creeps on and never back: no gain is negative.  Its creep is often
linear in the logarithm of time, which many lags in decades stand for.
"""

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Linear, Number, parameter
from plants.effects.hints import ExcitationHints
from plants.meanings import remembers


@remembers(angles=("deg", "what has crept"))
class Slow(NamedTuple):
    """What has crept [deg], one entry for each time constant."""

    angles: tuple[Number, ...]


class SampledCreep(NamedTuple):
    """Gain, and share of the way to go in one sample, of each time constant."""

    gains: tuple[Number, ...]
    shares: tuple[Number, ...]

    def static(self, s: Slow, before: Number, after: Number, around: Around) -> tuple[Slow, Number, Number]:
        middle = 0.5 * (before + after)
        crept = tuple(
            a + share * (gain * middle - a)
            for a, gain, share in zip(s.angles, self.gains, self.shares, strict=True)
        )
        return Slow(crept), before + sum(s.angles), after + sum(crept)


def _sampled(gains: tuple[Number, ...], times: tuple[Number, ...], dt: float) -> SampledCreep:
    return SampledCreep(gains, tuple(-np.expm1(-dt / np.asarray(t, float)) for t in times))


@dataclass(frozen=True)
class _Creeping(Effect):
    """What the forms share."""

    NAME = "creep"
    STAGE = "wrist"
    HAPPENS = "The wrist creeps"
    COMMON = True
    BOUND = "kept"

    def no_bound(self, wrist: Any) -> str | None:
        if min(self.sampled(wrist, 1.0).gains) < 0.0:
            return "what creeps backwards undoes a fast move"
        return None

    @property
    def static_gain(self) -> Number:
        return 1.0 + sum(self.rest(None, 0.0, 1.0).angles)

    @property
    @abstractmethod
    def slowest(self) -> Number:
        """The time constant [s] that the longest recording has to hold for creep to be told from a drift."""

    def borrowed(self, asked: ExcitationHints) -> str | None:
        """What creeps for longer than any recording lasts is a drift in all of them."""
        if float(self.slowest) <= asked.longest:
            return None
        return (
            f"a time constant of {float(self.slowest):.3g} s is longer than any recording, in which it is no "
            "more than a drift; record for longer"
        )

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        c = self.sampled(wrist, dt)
        pairs = zip(c.gains, c.shares, strict=True)
        return Linear(static=1.0 + sum(g * p * 0.5 * (z + 1.0) / (z - 1.0 + p) for g, p in pairs))


@dataclass(frozen=True)
class Creep(_Creeping):
    """One time constant: the angle finally moves further by `gain` times the static angle.

    >>> Creep(gain=0.1, time_constant=4.0).kinds()["time_constant"].unit
    's'
    """

    FORM = "one time constant"

    gain: Number = parameter("1", "what creeps, over the static angle", 0.0, 1.0, 0.0, (0.1,))
    time_constant: Number = parameter("s", "time constant", 0.4, 200.0, 5.0, (1.0, 3.0, 10.0, 30.0))

    @property
    def slowest(self) -> Number:
        return self.time_constant

    def sampled(self, wrist: Any, dt: float) -> SampledCreep:
        return _sampled((self.gain,), (self.time_constant,), dt)

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Slow:
        return Slow((self.gain * angle,))


@dataclass(frozen=True)
class TwoTimeCreep(_Creeping):
    """Two time constants, the second `ratio` times the first."""

    FORM = "two time constants"

    gain: Number = parameter("1", "what creeps soon, over the static angle", 0.0, 1.0, 0.0, (0.06,))
    time_constant: Number = parameter("s", "first time constant", 0.2, 40.0, 1.5, (0.6, 2.0))
    gain_late: Number = parameter("1", "what creeps late, over the static angle", 0.0, 1.0, 0.0, (0.06,))
    ratio: Number = parameter("1", "second time constant over the first", 2.0, 100.0, 8.0, (5.0, 15.0))

    @property
    def slowest(self) -> Number:
        return self.time_constant * self.ratio

    def sampled(self, wrist: Any, dt: float) -> SampledCreep:
        times = (self.time_constant, self.time_constant * self.ratio)
        return _sampled((self.gain, self.gain_late), times, dt)

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Slow:
        return Slow((self.gain * angle, self.gain_late * angle))


LOG_RATIO = 4.0
"""Ratio of one time constant to the next where five of them stand for a logarithm."""


@dataclass(frozen=True)
class LogCreep(_Creeping):
    """Creep with the logarithm of time: five equal lags, each `LOG_RATIO` times as slow as the last."""

    FORM = "logarithm of time"

    gain: Number = parameter("1", "what creeps in all, over the static angle", 0.0, 1.5, 0.0, (0.12,))
    first: Number = parameter("s", "first time constant", 0.02, 20.0, 0.2, (0.1, 0.4, 1.5))

    @property
    def slowest(self) -> Number:
        # Of five that share one gain the others still tell how it goes on.
        return self.first * LOG_RATIO**3

    def sampled(self, wrist: Any, dt: float) -> SampledCreep:
        gains = (self.gain / 5.0,) * 5
        return _sampled(gains, tuple(self.first * LOG_RATIO**i for i in range(5)), dt)

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Slow:
        return Slow((self.gain * angle / 5.0,) * 5)
