"""Inverse of the regulator: the command that gives a pressure.

That of the hysteresis, the pressure that gives an angle, is the law's own: `plants.hysteresis.law`.
All functions are NumPy ufuncs of floats, lanes or symbols, as the laws are.
"""

from typing import Any

import numpy as np

from plants.actuator.regulator import SampledRegulator, share

Number = Any

HALLEY_STEPS, NEWTON_STEPS = 3, 4
"""Of `error_for`: at 1 ms to rounding for every regulator within the bounds of its parameters whose rates are
up to a thousand times apart; to 2e-5 of the error up to the ten thousand times that the bounds allow."""


def error_for(change: Number, c: SampledRegulator) -> Number:
    """Error gain v - P [kPa] that the regulator needs for a change of pressure [kPa] in one sample.

    Solves ``share(e, c) e = change``.  The rate grows with the size of the error, so there is one solution;
    since k(e) e >= k_fast e - (k_fast - k_slow) e0 / 2, it lies at most e0 / 2 beyond that of the fast rate,
    which is where the iteration starts.  But for the rate's change within the sample the equation is a cubic:
    Halley's method brings it close to the root of that, Newton's to that of the whole.

    >>> from plants.actuator.regulator import Regulator, sampled
    >>> c = sampled(Regulator(49.4, 9.0, 0.55, 9.0), 0.001)
    >>> round(float(error_for(0.5, c)), 6), round(float(share(error_for(0.5, c), c) * error_for(0.5, c)), 12)
    (57.110748, 0.5)
    """
    size = np.abs(change)
    half = 0.5 * np.sqrt(c.e0_squared)
    error = np.minimum(size / (c.alpha_slow + c.alpha_rise) + half, size / c.alpha_slow)
    fast, slow = c.alpha_slow + c.alpha_rise, c.alpha_slow * c.e0_squared
    for _ in range(HALLEY_STEPS):  # of (fast e - size) e^2 + slow e - size e0^2
        value = ((fast * error - size) * error + slow) * error - size * c.e0_squared
        slope = (3.0 * fast * error - 2.0 * size) * error + slow
        bend = 6.0 * fast * error - 2.0 * size
        error = error - 2.0 * value * slope / (2.0 * slope * slope - value * bend)
    for _ in range(NEWTON_STEPS):
        squared = error * error
        w = squared / (squared + c.e0_squared)
        by_w = c.alpha_rise - c.z_rise * ((1.0 - 2.0 * w) * c.z_centre + (2.0 - 3.0 * w) * w * c.z_rise)
        of_error = share(error, c)
        error = error - (of_error * error - size) / (of_error + 2.0 * w * (1.0 - w) * by_w)
    return np.where(change < 0.0, -error, error)


def command_for(before: Number, after: Number, c: SampledRegulator) -> Number:
    """Command [V] that takes the regulator from one pressure to another [kPa] in one sample; not bounded."""
    return (before + error_for(after - before, c)) / c.gain
