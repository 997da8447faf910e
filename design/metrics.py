"""How a step response is judged, computed while it is simulated.

Definitions as in Astrom & Hagglund, Advanced PID Control (2006), and, where both
apply, as ``control.step_info`` computes them: times are those of samples, and
the response is normalised to run from 0 at the start to 1 at the reference.
"""

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np

from plants.wrist import SAMPLE_TIME

Number = Any
SETTLING_BAND = 0.02
"""Half-width of the settling band, as a share of the step."""


class Tally(NamedTuple):
    """Running sums and marks of one response."""

    iae: Number
    ise: Number
    itae: Number
    variation: Number
    command: Number  # of the sample before [V]
    peak: Number  # highest normalised response so far
    below10: Number  # samples before the response first reached 10 %
    below90: Number
    outside: Number  # samples up to and with the last one outside the settling band
    error: Number  # of the last sample [deg]


class Yardstick(NamedTuple):
    """What a response is measured against: the reference [deg], the angle it starts from, 1 / step."""

    reference: Number
    start: Number
    per_step: Number
    dt: Number


def yardstick(start: Number, reference: Number, dt: float = SAMPLE_TIME) -> Yardstick:
    """Measure of a step from `start` to `reference` [deg]; the two must differ."""
    return Yardstick(reference, start, 1.0 / (np.asarray(reference, float) - start), dt)


def begin(command: Number) -> Tally:
    """Tally before the first sample; `command` [V] is what was held until then."""
    return Tally(0.0, 0.0, 0.0, 0.0, command, 0.0, 0.0, 0.0, 0.0, 0.0)


def update(t: Tally, sample: Number, angle: Number, command: Number, c: Yardstick) -> Tally:
    """Tally with one more sample: its index, the angle [deg] and the command [V] given for it."""
    error = c.reference - angle
    size = np.abs(error) * c.dt
    peak = np.maximum(t.peak, (angle - c.start) * c.per_step)
    far = np.abs(error * c.per_step) >= SETTLING_BAND
    return Tally(
        t.iae + size,
        t.ise + size * np.abs(error),
        t.itae + size * (sample * c.dt),
        t.variation + np.abs(command - t.command),
        command,
        peak,
        t.below10 + np.where(peak < 0.1, 1.0, 0.0),
        t.below90 + np.where(peak < 0.9, 1.0, 0.0),
        np.where(far, sample + 1.0, t.outside),
        error,
    )


@dataclass(frozen=True)
class Metrics:
    """Judgement of one response, or of many: every field a float or an array of lanes.

    rise_time_s (10 to 90 %) and settling_time_s (2 %) are infinite where the
    response does not get there; overshoot_percent is relative to the step.
    """

    rise_time_s: Number
    settling_time_s: Number
    overshoot_percent: Number
    steady_state_error_deg: Number
    iae_deg_s: Number
    ise_deg2_s: Number
    itae_deg_s2: Number
    total_variation_V: Number

    def __getitem__(self, lanes: Any) -> "Metrics":
        """The metrics of some lanes."""
        return Metrics(*(getattr(self, f.name)[lanes] for f in fields(self)))

    def reshape(self, *shape: int) -> "Metrics":
        """The same metrics, the lanes arranged in another shape."""
        return Metrics(*(np.reshape(getattr(self, f.name), shape) for f in fields(self)))


def finish(t: Tally, samples: int, dt: float = SAMPLE_TIME) -> Metrics:
    """Metrics of a response of a number of samples, `dt` [s] apart."""
    t = Tally(*(np.asarray(x, float) for x in t))
    return Metrics(
        rise_time_s=np.where(t.below90 < samples, (t.below90 - t.below10) * dt, np.inf),
        settling_time_s=np.where(t.outside < samples, t.outside * dt, np.inf),
        overshoot_percent=np.maximum(t.peak - 1.0, 0.0) * 100.0,
        steady_state_error_deg=np.abs(t.error),
        iae_deg_s=t.iae,
        ise_deg2_s=t.ise,
        itae_deg_s2=t.itae,
        total_variation_V=t.variation,
    )


UNITS = {
    "rise_time_s": "s", "settling_time_s": "s", "overshoot_percent": "%", "steady_state_error_deg": "deg",
    "iae_deg_s": "deg s", "ise_deg2_s": "deg² s", "itae_deg_s2": "deg s²", "total_variation_V": "V",
}  # fmt: skip
"""Unit of each metric, for tables."""
