"""Electro-pneumatic regulator: command voltage to pressure.

The paper's "variable P control model" (section 3): the regulator is an
integrating plant under a proportional controller whose gain varies,

    dP/dt = k(e) e,   e = gain v - P,
    k(e)  = k_slow + (k_fast - k_slow) e^2 / (e^2 + e0^2).

The paper names the model but its text lost the law by which the gain varies;
this form is assumed.  With ``k_slow == k_fast`` it is the first-order lag of
the same section.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

Number = Any  # a float, an array of lanes, or a CasADi symbol


@dataclass(frozen=True)
class Regulator:
    """Physical parameters of the regulator.

    gain [kPa/V], k_fast and k_slow [1/s] (rate far from and near to the
    commanded pressure), e0 [kPa] (the error at which the rate is half-way).
    """

    gain: Number
    k_fast: Number
    k_slow: Number
    e0: Number

    @classmethod
    def lag(cls, gain: Number, time_constant: Number) -> "Regulator":
        """First-order lag of the paper: the same rate at every error.

        >>> Regulator.lag(49.4, 0.111).k_slow == Regulator.lag(49.4, 0.111).k_fast
        True
        """
        return cls(gain, 1.0 / time_constant, 1.0 / time_constant, 1.0)


class SampledRegulator(NamedTuple):
    """Coefficients of the regulator for one sample time; all but two without unit."""

    gain: Number  # kPa/V
    alpha_slow: Number  # share of the error removed in one sample at the slow rate
    alpha_rise: Number  # what the fast rate adds to it
    z_rise: Number  # (k_fast - k_slow) dt
    z_centre: Number  # k_slow dt - z_rise / 2
    e0_squared: Number  # kPa^2


def sampled(p: Regulator, dt: float) -> SampledRegulator:
    """Coefficients for a sample time `dt` [s]."""
    alpha_slow, alpha_fast = -np.expm1(-p.k_slow * dt), -np.expm1(-p.k_fast * dt)
    z_slow, z_rise = p.k_slow * dt, (p.k_fast - p.k_slow) * dt
    return SampledRegulator(
        p.gain, alpha_slow, alpha_fast - alpha_slow, z_rise, z_slow - z_rise / 2, p.e0 * p.e0
    )


def step(pressure: Number, command: Number, c: SampledRegulator) -> Number:
    """Pressure [kPa] one sample later, the command [V] held in between.

    Exact where the rate does not vary (the first-order lag under a zero-order
    hold), second order in the sample time where it does.
    """
    error = c.gain * command - pressure
    return pressure + share(error, c) * error


def share(error: Number, c: SampledRegulator) -> Number:
    """Share of the error [kPa] that is removed in one sample.

    The last term is what the Taylor series keeps of the rate changing within the sample.
    """
    squared = error * error
    w = squared / (squared + c.e0_squared)
    return c.alpha_slow + w * (c.alpha_rise - (1.0 - w) * c.z_rise * (c.z_centre + w * c.z_rise))
