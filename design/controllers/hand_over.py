"""A PI that takes over from a command by hand without a jump, at any error, and has a rate limit.

By hand the command is what is given, within range and rate, and the integral follows it: it is the one with
which the law would command the same at the error of now (tracking; Astrom & Hagglund, Advanced PID Control,
2006, 3.5).  The first automatic command is the last one by hand.  The rate limit is a range about the last
command, so that the integrator stands still at it as it does at the ends of the range.
"""

from dataclasses import dataclass, field
from math import inf
from typing import Any, NamedTuple

import numpy as np

from design.controllers.controller import Measured, remembers
from design.controllers.pi import PI, PIState
from plants.kernel import pytrees
from plants.wrist import SAMPLE_TIME

Number = Any


@dataclass(frozen=True)
class HandOver:
    """Settings: a `PI`, or one with two degrees of freedom; rate [V/s], none where infinite.

    Raises ValueError for a rate that is not positive.
    """

    pi: PI
    rate: Number = field(default=inf)

    def __post_init__(self) -> None:
        if not np.all(np.asarray(self.rate) > 0.0):
            raise ValueError("the rate limit must be positive")

    @property
    def gain(self) -> Number:
        """What the PI knows of the regulator [kPa/V]."""
        return self.pi.gain

    @property
    def low(self) -> Number:
        """Least command [V]."""
        return self.pi.low

    @property
    def high(self) -> Number:
        """Largest command [V]."""
        return self.pi.high

    @property
    def settings(self) -> dict[str, Number]:
        """Those of the PI, and the rate limit where there is one."""
        return {**vars(self.pi), **({"rate limit": self.rate} if np.isfinite(self.rate) else {})}

    def sampled(self, dt: float = SAMPLE_TIME) -> "SampledHandOver":
        """Coefficients for a sample time `dt` [s]."""
        return SampledHandOver(self.pi.sampled(dt), np.minimum(self.rate * dt, self.high - self.low))

    def holding(self, pressure: Number, seen: Measured | None = None) -> "HandOverState":
        """The state in which it holds a pressure [kPa], automatically, while the error is zero."""
        held = self.pi.holding(pressure, seen)
        return HandOverState(held, np.minimum(np.maximum(self.pi.command(held), self.low), self.high), 0.0)

    def command(self, state: "HandOverState") -> Number:
        """The command [V] that a state gives while the error is zero."""
        return self.pi.command(state.automatic)


class SampledHandOver(NamedTuple):
    """Coefficients of the PI for one sample time, and the largest change of the command in it [V]."""

    pi: Any
    change: Number

    def act(self, state: "HandOverState", seen: Measured) -> tuple["HandOverState", Number]:
        """The law, automatic."""
        return step(state, seen, 0.0, 0.0, self)


@remembers(
    given=("V", "last command, to which the integral is set when it takes over"),
    manual=("", "1 where the last command was by hand, else 0"),
)
class HandOverState(NamedTuple):
    """What it remembers: the state of the PI, the last command [V], and whether that was by hand (1) or not
    (0)."""

    automatic: PIState | Any
    given: Number
    manual: Number


def step(
    s: HandOverState, seen: Measured, manual: Number, wanted: Number, c: SampledHandOver
) -> tuple[HandOverState, Number]:
    """State after, and command [V] of, one sample; manual: 1 where the command is to be `wanted` [V], else 0.

    >>> c = HandOver(PI(Kp=3.1, Ki=10.4), rate=20.0).sampled()
    >>> seen = Measured(15.0, 0.0, 100.0)
    >>> by_hand, last = step(HandOverState(PIState(0.0), 2.0, 0.0), seen, 1.0, 3.0, c)
    >>> _, first = step(by_hand, seen, 0.0, 0.0, c)
    >>> float(last), float(first)
    (2.02, 2.02)
    """
    low, high = np.maximum(c.pi.low, s.given - c.change), np.minimum(c.pi.high, s.given + c.change)
    by_hand, was = np.where(manual > 0.5, 1.0, 0.0), np.where(s.manual > 0.5, 1.0, 0.0)
    follows = c.pi.following(s.automatic, seen, s.given)
    tracks = np.maximum(by_hand, was) > 0.5
    before = pytrees.like(
        follows,
        [
            np.where(tracks, new, old)
            for new, old in zip(pytrees.leaves(follows), pytrees.leaves(s.automatic), strict=True)
        ],
    )
    after, automatic = c.pi._replace(low=low, high=high).act(before, seen)
    told = np.minimum(np.maximum(wanted, low), high)
    # On taking over exactly the last one: the sum that the integral was set by may round.
    command = np.where(by_hand > 0.5, told, np.where(was > 0.5, s.given, automatic))
    return HandOverState(after, command, by_hand), command
