"""Transient of the wrist: a first-order lag from static to measured angle (section 5.2)."""

from typing import Any, NamedTuple

import numpy as np

Number = Any


class SampledLag(NamedTuple):
    """Coefficients of the lag for one sample time: y+ = keep y + before h + after h+."""

    keep: Number
    before: Number
    after: Number


def sampled(time_constant: Number, dt: float) -> SampledLag:
    """Coefficients for a time constant and a sample time, both in s.

    First-order hold: exact for an input that moves linearly within a sample,
    which the static angle does to a far better degree than it jumps (Franklin,
    Powell & Workman, Digital Control of Dynamic Systems).
    """
    ratio = dt / time_constant
    keep = np.exp(-ratio)
    mean = -np.expm1(-ratio) / ratio  # of the decay, over the sample
    return SampledLag(keep, mean - keep, 1.0 - mean)


def step(angle: Number, before: Number, after: Number, c: SampledLag) -> Number:
    """Angle [deg] one sample later, while the static angle moves from `before` to `after` [deg].

    >>> float(step(5.0, 5.0, 5.0, sampled(0.16, 0.001)))
    5.0
    """
    return c.keep * angle + c.before * before + c.after * after
