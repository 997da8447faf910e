"""Hidden effects at the sensor: what is added to the true angle by measuring it."""

from math import exp, pi, sin
from typing import NamedTuple

import numpy as np
from numba import njit

from tests.rig.regulator_effects import sign


class GyroDrift(NamedTuple):
    """Integrated bias of a rate sensor.

    rate [deg/s] at the start; form 1: constant; form 2: dies out with warming_s as the sensor warms up.
    """

    form: int = 0
    rate: float = 0.0
    warming_s: float = 1.0


@njit
def drift(p: GyroDrift, time: float) -> float:
    """Drift [deg] by then."""
    if p.form == 2:
        return p.rate * p.warming_s * (1.0 - exp(-time / p.warming_s))
    return p.rate * time


def draw_drift(form: int, scale: float, rng: np.random.Generator) -> GyroDrift:
    rate = scale * sign(rng) * rng.uniform(0.01, 0.05)
    return GyroDrift(1, rate) if form == 1 else GyroDrift(2, rate, rng.uniform(40.0, 100.0))


class Hum(NamedTuple):
    """A periodic disturbance: amplitude [deg], frequency [Hz], phase [rad] at time zero.

    form 2: with a second harmonic, overtone times the amplitude, at its own phase.
    """

    form: int = 0
    amplitude: float = 0.0
    frequency: float = 0.0
    phase: float = 0.0
    overtone: float = 0.0
    overtone_phase: float = 0.0


@njit
def hum(p: Hum, time: float) -> float:
    """Disturbance [deg] at that time."""
    turn = 2.0 * pi * p.frequency * time
    return p.amplitude * (sin(turn + p.phase) + p.overtone * sin(2.0 * turn + p.overtone_phase))


def draw_hum(form: int, scale: float, rng: np.random.Generator) -> Hum:
    amplitude, frequency = scale * rng.uniform(0.1, 0.5), float(np.exp(rng.uniform(np.log(0.7), np.log(12))))
    phase, second = rng.uniform(0.0, 2.0 * pi, 2)
    # The overtone is small: a trace must name the hum, not find every partial.
    return Hum(form, amplitude, frequency, phase, 0.0 if form == 1 else rng.uniform(0.1, 0.25), second)
