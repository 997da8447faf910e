"""What a plant leaves, as a disturbance of its loop: bounded, coloured, and any part of it at any time.

What a good model leaves hangs on where the wrist is and how it came there: it stands still where the wrist
does, and an integrator takes it away.  So it is drawn as a function of the way that the static angle has
gone: a sum of sines, weighted as first-order noise of the residual's correlation length has its power, of
the residual's rms and within its largest.  It counts from where the run begins, where the loop has long
taken it away, so that a wrist rests as it does without.  The residual is that of a free run from the
command, in which what is left of the pressure is contained.  What moves by itself while the wrist rests
(wander, slips) is not drawn: no gains hold an angle closer than that.

It is no effect of the library, which has causes: no trace tries it.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Number, parameter
from plants.meanings import remembers
from plants.parameters.remainder import RemainderSize

MULTIPLES = np.array([0.31, 0.83, 1.93, 4.27])
"""Wave numbers of the sines times the correlation length; no two have a small common multiple."""

WEIGHTS = np.sqrt(MULTIPLES / (1.0 + MULTIPLES**2))
"""Amplitudes: roots of the power that first-order noise has about these wave numbers, log-spaced."""

PEAK_OVER_RMS = float(WEIGHTS.sum() / np.sqrt(0.5 * (WEIGHTS**2).sum()))
"""Peak of the sum of sines over its rms."""

STEEPNESS = float((WEIGHTS * MULTIPLES).sum() / WEIGHTS.sum())
"""Largest slope of the sum of sines times its correlation length over its peak: all waves rise together."""

LASTS = 60.0
"""Length, in correlation lengths, of what `shift` chooses from."""

SHOWS = 0.5
"""A residual below this share of the sensor's noise is hidden in it, and left out."""


@remembers(
    sines=("", "sine of a wave"),
    cosines=("", "cosine of a wave"),
    began=("", "sum of the waves at the start"),
)
class Phasors(NamedTuple):
    """Sines and cosines of the waves, and their sum [1] where the run began."""

    sines: tuple[Number, ...]
    cosines: tuple[Number, ...]
    began: Number


class SampledColouredRemainder(NamedTuple):
    """Peak [deg] and half the wave numbers [1/deg]."""

    peak: Number
    halves: tuple[Number, ...]

    def static(
        self, s: Phasors, before: Number, after: Number, around: Around
    ) -> tuple[Phasors, Number, Number]:
        way = np.abs(after - before)
        sines, cosines = [], []
        for a, b, half in zip(s.sines, s.cosines, self.halves, strict=True):
            # A rotation without sine and cosine, exact in length (Cayley), by 2 atan of the half.
            t = half * way
            norm = 1.0 / (1.0 + t * t)
            cosine, sine = (1.0 - t * t) * norm, 2.0 * t * norm
            sines.append(a * cosine + b * sine)
            cosines.append(b * cosine - a * sine)
        turned = Phasors(tuple(sines), tuple(cosines), s.began)
        return turned, before + self._value(s), after + self._value(turned)

    def _value(self, s: Phasors) -> Number:
        return self.peak * (_sum(s.sines) - s.began)


def _sum(sines: Any) -> Number:
    """The sum of the waves, within -1 to 1."""
    share = WEIGHTS / WEIGHTS.sum()
    return sum(float(a) * x for a, x in zip(share, sines, strict=True))


@dataclass(frozen=True)
class ColouredRemainder(Effect):
    """A residual that stays within `peak` [deg] and forgets within a way of `length` [deg] of the static
    angle; shift [1], 0 to 1: which part of it a run meets.

    >>> ColouredRemainder(0.3, 5.0, 0.2).values["remainder.peak"]
    0.3
    """

    NAME = "remainder"
    FORM = "sum of sines along the way"
    STAGE = "wrist"
    HAPPENS = "The angle differs for no cause that is known"
    SILENT = True

    peak: Number = parameter("deg", "largest shift of the angle", 0.0, 60.0, 0.0)
    length: Number = parameter("deg", "correlation length, of the way of the static angle", 0.01, 1e4, 5.0)
    shift: Number = parameter("1", "which part of it a run meets", 0.0, 1.0, 0.5)

    @classmethod
    def of(cls, left: RemainderSize | None) -> "ColouredRemainder | None":
        """The disturbance that stands for what a plant leaves of the angle; None where that is hidden in the
        noise."""
        if left is None or left.rms <= SHOWS * left.noise:
            return None
        return cls(min(left.largest, PEAK_OVER_RMS * left.rms), left.correlation_way)

    @property
    def steepest(self) -> Number:
        """Largest share by which the residual changes the slope of a branch: as a function of the way of the
        static angle it adds, in any move, at most this share of the move.

        >>> round(ColouredRemainder(0.3, 5.0).steepest, 3)
        0.102
        """
        return STEEPNESS * self.peak / self.length

    def sampled(self, wrist: Any, dt: float) -> SampledColouredRemainder:
        return SampledColouredRemainder(self.peak, tuple(0.5 * m / self.length for m in MULTIPLES))

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Phasors:
        where = [m * self.shift * LASTS for m in MULTIPLES]
        sines = tuple(np.sin(x) for x in where)
        return Phasors(sines, tuple(np.cos(x) for x in where), _sum(sines))
