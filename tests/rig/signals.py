"""What a rig is given: commands of the five recordings, the other motion's pressure, disturbances, noise."""

from math import exp, pi

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Signal = NDArray[np.float64]

ROW = 0.01  # s, of the log
VOLTS_PER_KPA = 1.0 / 49.4  # by which the operator asks for a pressure
HIGHEST = 197.0  # kPa that 4 V can ask for, rounded down


def _held(pressures: list[float], rows: list[int]) -> Signal:
    """Pressure of each row, given how many rows each is held."""
    return np.repeat(np.array(pressures), rows)


def staircase(rng: np.random.Generator, short: bool = False) -> Signal:
    """Twice around the loop in steps of 50 kPa, each held for 8 s (once, 2 s if short)."""
    once = [100.0, 150.0, HIGHEST, 150.0, 100.0, 50.0, 0.0, 50.0]
    return _held([*once, 100.0] if short else [*once, *once, 100.0], [200] * 9 if short else [800] * 17)


def steps(rng: np.random.Generator, short: bool = False) -> Signal:
    """Random pressures, each held for 0.6 to 4 s."""
    length = 1400 if short else 8200
    pressures, rows = [100.0], [100]
    while sum(rows) < length:
        pressures.append(round(rng.uniform(5.0, 190.0), 1))
        rows.append(int(rng.integers(60, 400)))
    return _held(pressures, rows)[:length]


def small(rng: np.random.Generator, short: bool = False) -> Signal:
    """A random walk of 2 to 9 kPa every 2 s."""
    count = 5 if short else 30
    changes = rng.choice([-1.0, 1.0], count) * rng.uniform(2.0, 9.0, count)
    pressures = np.round(100.0 + np.concatenate([[0.0], np.cumsum(changes)]), 1)
    return np.repeat(np.clip(pressures, 0.0, HIGHEST), 200)


def sine(rng: np.random.Generator, short: bool = False) -> Signal:
    """A sine of rising frequency and falling amplitude (0.05 to 0.65 Hz, 85 to 30 kPa)."""
    length = 12.0 if short else 60.0
    time = np.arange(round(length / ROW) + 1) * ROW
    turns = 0.05 * time + 0.5 * (0.65 - 0.05) / length * time**2
    return 100.0 + 85.0 * (30.0 / 85.0) ** (time / length) * np.sin(2.0 * pi * turns)


def task_reference(short: bool = False) -> Signal:
    """Set-point [deg] at 1 kHz: 15 deg from 1 s on, -5 deg from 13 s (5 s if short) on."""
    time = np.arange(10001 if short else 24001) * 0.001
    return np.where(time < 1.0, 0.0, np.where(time < (5.0 if short else 13.0), 15.0, -5.0))


OPEN_LOOP = {"staircase": staircase, "steps": steps, "small": small, "sine": sine}


def command_of(pressure: Signal) -> Signal:
    """Command [V] of each row as a logger writes it, from the pressure asked for [kPa]."""
    return np.round(np.clip(pressure * VOLTS_PER_KPA, 0.0, 4.0), 4)


def other_pressure(seconds: np.ndarray, rng: np.random.Generator) -> Signal:
    """Pressure [kPa] of the other motion: straight lines between random knots, 5 s apart."""
    knots = np.arange(0.0, seconds[-1] + 10.0, 5.0)
    return np.interp(seconds, knots, rng.uniform(40.0, 170.0, len(knots)))


def noise(spread: float, count: int, correlation_s: float, dt: float, rng: np.random.Generator) -> Signal:
    """Gaussian noise of that spread, white where correlation_s is 0, else of first order."""
    white = rng.normal(0.0, spread, count)
    if correlation_s == 0.0:
        return white
    keep = exp(-dt / correlation_s)
    coloured, _ = lfilter([(1.0 - keep**2) ** 0.5], [1.0, -keep], white, zi=[keep * rng.normal(0.0, spread)])
    return np.asarray(coloured)


def slips(every_s: float, size: float, recovery_s: float, count: int, rng: np.random.Generator) -> Signal:
    """Angle [deg] at 1 kHz that slips at random moments and recovers."""
    angle = np.zeros(count)
    if every_s == 0.0:
        return angle
    moment = rng.exponential(every_s)
    while moment < count * 0.001:
        since = np.arange(count) * 0.001 - moment
        jump = rng.choice([-1.0, 1.0]) * size * rng.uniform(0.5, 1.5)
        angle += np.where(since >= 0.0, jump * np.exp(-np.maximum(since, 0.0) / recovery_s), 0.0)
        moment += rng.exponential(every_s)
    return angle


def bursts(factor: float, every_s: float, count: int, rng: np.random.Generator) -> Signal:
    """What the noise is multiplied with, at 1 kHz."""
    loud = np.ones(count)
    if every_s > 0.0:
        for moment in np.cumsum(rng.exponential(every_s, int(count * 0.003 / every_s) + 5)):
            loud[int(moment * 1000) : int(moment * 1000) + 500] = factor
    return loud
