"""The declared part of a rig: the numbers of its regulator, hysteresis and lag, drawn for each campaign.

The means are the nominal values of the wrist's two motions, written down again here so that
this simulator shares nothing with the model it is used to judge.
"""

from typing import NamedTuple

import numpy as np


class Declared(NamedTuple):
    """Parameters of the declared physics.

    gain [kPa/V], k_fast, k_slow [1/s], e0 [kPa], a1, a2, s [deg/kPa], w1, w2 [deg],
    rest_pressure [kPa], Tw [s].
    """

    gain: float
    k_fast: float
    k_slow: float
    e0: float
    a1: float
    w1: float
    a2: float
    w2: float
    s: float
    rest_pressure: float
    Tw: float


NOMINAL = {
    "flexion": Declared(49.4, 9.0, 0.55, 9.0, 0.36, 6.0, 0.36, 6.0, 0.0803, 100.0, 0.16),
    "deviation": Declared(49.4, 9.0, 0.55, 9.0, 0.285, 3.4, 0.235, 4.0, 0.0557, 100.0, 0.13),
}

SPREAD = 0.15  # of each parameter, either way
GAIN_SPREAD = 0.004  # a regulator is bought calibrated; its rest command must hold about 100 kPa
NARROWEST_LOOP = 3.0  # deg between the lines anywhere in the pressure range, so that they never cross


def loop_width(p: Declared, x: float) -> float:
    """Height [deg] of the hysteresis loop at the pressure difference x [kPa] from rest."""
    return (p.a2 * x + p.w2) - (p.a1 * x - p.w1)


def draw(axis: str, rng: np.random.Generator) -> Declared:
    """A rig of the given motion, "flexion" or "deviation", near its nominal values."""
    nominal = NOMINAL[axis]
    while True:
        factors = rng.uniform(1 - SPREAD, 1 + SPREAD, len(nominal))
        p = Declared(*(value * float(factor) for value, factor in zip(nominal, factors, strict=True)))
        p = p._replace(gain=nominal.gain * (1 + float(rng.uniform(-GAIN_SPREAD, GAIN_SPREAD))))
        p = p._replace(rest_pressure=nominal.rest_pressure)
        wide_enough = min(loop_width(p, -105.0), loop_width(p, 105.0)) > NARROWEST_LOOP
        if wide_enough and min(p.a1, p.a2) > 1.5 * p.s:
            return p
