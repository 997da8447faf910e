"""Load step: at some moment the hand picks up a load and the angle shifts."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Nothing, Number, parameter
from plants.effects.hints import ExcitationHints, TrialHints


class SampledLoad(NamedTuple):
    """Shift [deg], change of the slope, moment [s], 1 / duration [1/s], sample time [s]."""

    shift: Number
    slope: Number
    moment: Number
    per_duration: Number
    dt: Number

    def static(
        self, s: Nothing, before: Number, after: Number, around: Around
    ) -> tuple[Nothing, Number, Number]:
        return s, self._loaded(before, around.time), self._loaded(after, around.time + self.dt)

    def _loaded(self, angle: Number, time: Number) -> Number:
        share = np.minimum(np.maximum((time - self.moment) * self.per_duration, 0.0), 1.0)
        return angle + share * (self.shift + self.slope * angle)


_SHIFT = parameter("deg", "shift of the static angle", -30.0, 30.0, 0.0, (1.0,))
_MOMENT = parameter(
    "s", "moment of the shift, time_s of every recording", 0.0, 3600.0, 10.0, (5.0, 10.0, 20.0), 0.3
)  # a log is searched every half second, so that about half of that refines it


class _Loaded(Effect):
    """What the forms share."""

    moment: Number

    NAME = "load-step"
    STAGE = "wrist"
    HAPPENS = "The load on the hand changes"
    FROM_REMAINDER = True
    EVENT = True
    BOUND = "kept"

    @classmethod
    def trials_on(cls, log: TrialHints) -> list[dict[str, float]]:
        """Shifts of three times the noise at the moments at which the residual steps."""
        first, size = next(cls.trials(log.rig)), 3.0 * log.noise
        return [{**first, "moment": moment, "shift": size * sign} for moment, sign in log.steps()]

    def borrowed(self, asked: ExcitationHints) -> str | None:
        """A load that comes as a recording begins shifts all of it."""
        if float(self.moment) < asked.begins:
            return (
                f"a shift at {float(self.moment):.3g} s, within the first {asked.begins:.3g} s of the "
                "recordings, is an offset as well; record with the load picked up later"
            )
        return None


@dataclass(frozen=True)
class LoadStep(_Loaded):
    """The static angle shifts by `shift` [deg] at a `moment` [s], and stays so."""

    FORM = "at once"

    shift: Number = _SHIFT
    moment: Number = _MOMENT

    def sampled(self, wrist: Any, dt: float) -> SampledLoad:
        return SampledLoad(self.shift, 0.0, self.moment, 1.0 / dt, dt)


@dataclass(frozen=True)
class GradualLoad(_Loaded):
    """The load comes within a `duration` [s], and may also change the slope of the loop."""

    FORM = "gradual, with a change of slope"

    shift: Number = _SHIFT
    moment: Number = _MOMENT
    duration: Number = parameter("s", "time that the load takes to come", 0.001, 5.0, 0.1, (0.3,))
    slope: Number = parameter("1", "change of the slope of the loop", -0.5, 0.5, 0.0, (0.0,))

    def sampled(self, wrist: Any, dt: float) -> SampledLoad:
        return SampledLoad(self.shift, self.slope, self.moment, 1.0 / np.asarray(self.duration, float), dt)
