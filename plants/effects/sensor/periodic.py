"""Periodic disturbance: a sinusoid of one frequency on the measured angle (compressor, tremor)."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plants.effects.effect import Around, Effect, Nothing, Number, parameter
from plants.effects.hints import ExcitationHints, TrialHints


class SampledHum(NamedTuple):
    """Angular frequency [rad/s]; sine and cosine parts of the first and second harmonic [deg]."""

    omega: Number
    sine: Number
    cosine: Number
    sine2: Number
    cosine2: Number

    def sensor(self, s: Nothing, angle: Number, around: Around) -> Number:
        phase = self.omega * around.time
        sine, cosine = np.sin(phase), np.cos(phase)
        first = self.sine * sine + self.cosine * cosine
        # Double angles: sin 2a = 2 sin a cos a, cos 2a = 1 - 2 sin^2 a.
        second = self.sine2 * 2.0 * sine * cosine + self.cosine2 * (1.0 - 2.0 * sine * sine)
        return angle + first + second


def _part(name: str, trial: float) -> Any:
    return parameter("deg", f"{name}, phase 0 at time_s = 0", -20.0, 20.0, 0.0, (0.0, trial) if trial else ())


_FREQUENCY = parameter("Hz", "frequency of the sinusoid", 0.05, 100.0, 1.0, (1.0,), 0.002)


SLOWEST = 2.0
"""Periods that the longest recording must hold: less cannot be told from drift."""


class _Humming(Effect):
    """What the forms share."""

    frequency: Number

    NAME = "periodic-disturbance"
    STAGE = "sensor"
    HAPPENS = "The measured angle contains a sinusoid"
    FROM_REMAINDER = True
    BOUND = "kept"

    @classmethod
    def trials_on(cls, log: TrialHints) -> list[dict[str, float]]:
        """The lines of the residual's spectrum."""
        first, noise = next(cls.trials(log.rig)), log.noise
        return [
            {**first, "frequency": f, "sine": a * noise, "cosine": b * noise}
            for f, a, b in log.spectral_lines()
        ]

    def borrowed(self, asked: ExcitationHints) -> str | None:
        """A sinusoid at a multiple of the only sine that was asked, or too slow to come round twice."""
        order = asked.harmonic(float(self.frequency))
        if order is not None:
            return (
                f"what was found at {float(self.frequency):.3g} Hz is {order} times the frequency of the "
                "command, a sine; record steps, or a sine of another frequency"
            )
        if float(self.frequency) * asked.longest < SLOWEST:
            period = 1.0 / float(self.frequency)
            return f"a period of {period:.3g} s comes round less than twice; record for longer"
        return None


@dataclass(frozen=True)
class Hum(_Humming):
    """One sinusoid, its amplitude and phase given by a sine and a cosine part [deg]."""

    FORM = "sinusoid"

    frequency: Number = _FREQUENCY
    sine: Number = _part("sine part", 0.2)
    cosine: Number = _part("cosine part", 0.2)

    def sampled(self, wrist: Any, dt: float) -> SampledHum:
        return SampledHum(2.0 * np.pi * self.frequency, self.sine, self.cosine, 0.0, 0.0)


@dataclass(frozen=True)
class HarmonicHum(_Humming):
    """A sinusoid and its second harmonic."""

    FORM = "sinusoid with a second harmonic"

    frequency: Number = _FREQUENCY
    sine: Number = _part("sine part", 0.2)
    cosine: Number = _part("cosine part", 0.2)
    sine2: Number = _part("sine part of the second harmonic", 0.0)
    cosine2: Number = _part("cosine part of the second harmonic", 0.0)

    def sampled(self, wrist: Any, dt: float) -> SampledHum:
        return SampledHum(2.0 * np.pi * self.frequency, self.sine, self.cosine, self.sine2, self.cosine2)
