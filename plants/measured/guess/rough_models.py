"""Rough models of a log, found in no time: from command to pressure, and from pressure to angle.

The regulator is a delay and a first-order lag from the command to the pressure, the loop plays
of the pressure whose weights are found by least squares, none negative (Lawson & Hanson, Solving Least
Squares Problems, 1974): both are linear but for two numbers, which are tried on a grid.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from plants.hysteresis import RoughLoop
from plants.measured.campaigns.recording import Recording
from plants.measured.guess.output_curve import rough_curve

Array = NDArray[np.float64]
ROWS = 6000
"""Rows of all recordings together that a guess looks at, about."""

LONG = 30_000
"""Rows of all recordings together that a lag is guessed from, at most."""

DELAYS, LAGS = 14, 14
"""Dead times and time constants that are tried."""

LONGEST_DELAY, LONGEST_LAG = 1.5, 8.0
"""Largest of them [s]."""

REACHED = (0.1, 0.15, 0.2, 0.3, 0.45, 0.6, 0.75, 0.9)
"""Shares of the command's range from which on the pressure may rise no more, that are tried."""

LEVEL = (0.03, 0.06, 0.1, 0.15, 0.2, 0.3)
"""Shares of the command's range up to which the pressure may not rise, that are tried."""

BENT = 0.7
"""Share of the error that is left by a line that ends there, below which it is taken to end."""

SMOOTHED = 9
"""Rows over which a measured pressure is smoothed."""

PLAYS = 4
REACHES = (0.02, 0.04, 0.07, 0.12, 0.2, 0.3, 0.45)
"""Largest thresholds of the plays that are tried, as shares of the range of the pressure.  The last one is as
far as a fit may go: strokes turn that play before their ends, and of a wider one the weight would be known
from the ends alone, so that what goes a little further would be far off."""

JOINT_LAGS = (0.0, 0.03, 0.1, 0.3)
"""Time constants of the joint that are tried [s]."""


@dataclass(frozen=True)
class Lagged:
    """Output = gain * (lag of time constant `tau` [s] of the input, `delay` [s] late) + offset; rms: what it
    leaves.  most: input above which the output rises no more, infinite where there is none; least: input up
    to which it does not rise, likewise."""

    gain: float
    offset: float
    tau: float
    delay: float
    rms: float
    most: float = np.inf
    least: float = -np.inf


@dataclass(frozen=True)
class LoopGuess:
    """A loop, the lag of the joint [s] behind it, and what both leave [deg]."""

    loop: RoughLoop
    lag: float
    rms: float


def recorded(recordings: Sequence[Recording], field: str) -> list[tuple[Array, Array, float]]:
    """Command, a measured channel (`pressure` or `angle`) and sample time [s] of recordings that have it."""
    return [
        (r.command, v, float(np.median(np.diff(r.time))))
        for r in recordings
        if (v := getattr(r, field)) is not None
    ]


def first_order(runs: Sequence[tuple[Array, Array, float]]) -> Lagged:
    """The lag, late by a dead time, that takes inputs to outputs with least squares; `runs`: input (n,),
    output (n,) and sample time [s] of each.

    Where the input is one and the same throughout, it is the lag by which outputs come to rest.
    """
    runs = _short(runs)
    longest = min(len(x) * dt for x, _, dt in runs)
    dt = runs[0][2]
    lags = np.geomspace(dt, min(LONGEST_LAG, 0.1 * longest), LAGS)
    low, high = extent([x for x, _, _ in runs])
    if high == low:
        return min((_decay(runs, float(tau)) for tau in lags), key=lambda f: f.rms)
    delays = np.unique(np.round(np.linspace(0.0, min(LONGEST_DELAY, 0.05 * longest), DELAYS) / dt) * dt)
    line = _late_line(runs, delays, lags)
    ended = [_late_line(runs, (line.delay,), lags[::2], low + s * (high - low)) for s in REACHED]
    least = min(ended, key=lambda f: f.rms)
    return _late_line(runs, delays, lags, least.most) if least.rms < BENT * line.rms else line


def level_below(runs: Sequence[tuple[Array, Array, float]], follows: Lagged) -> Lagged:
    """The best of lags whose output does not rise up to some input, with the dead time of one that does; that
    one where the input never moves."""
    runs = _short(runs)
    low, high = extent([x for x, _, _ in runs])
    if high == low:
        return follows
    lags = follows.tau * np.array([0.5, 0.7, 1.0, 1.4])
    begun = [_late_line(runs, (follows.delay,), lags, np.inf, low + s * (high - low)) for s in LEVEL]
    return min(begun, key=lambda f: f.rms)


def largest_error(runs: Sequence[tuple[Array, Array, float]], follows: Lagged) -> float:
    """How far the output is ever behind what its input asks for, in the unit of the output; 0 where the input
    never moves."""
    behind = 0.0
    for x, _, dt in runs:
        asked = np.clip(x, follows.least, follows.most)
        late = lagged(asked, dt, 0.0, follows.delay)
        reached = lagged(late, dt, follows.tau, 0.0)
        behind = max(behind, float(np.max(np.abs(late[1:] - reached[:-1]))))  # before the output has moved
    return abs(follows.gain) * behind


def _short(runs: Sequence[tuple[Array, Array, float]]) -> Sequence[tuple[Array, Array, float]]:
    """The beginnings of long runs, where the input moves there: enough for a guess."""
    kept = LONG // len(runs)
    short = [(x[:kept], v[:kept], h) for x, v, h in runs]
    return runs if np.ptp(np.concatenate([x for x, _, _ in short])) == 0.0 else short


def _late_line(
    runs: Sequence[tuple[Array, Array, float]],
    delays: Sequence[float] | Array,
    lags: Array,
    most: float = np.inf,
    least: float = -np.inf,
) -> Lagged:
    """The best of some delays and lags, the input taken to be `most` where it is above, `least` below."""
    found, y = [], np.concatenate([v for _, v, _ in runs])
    middle = float(np.mean(y))
    about = y - middle
    for delay, tau in product(delays, lags):
        shaped = np.concatenate([lagged(np.clip(x, least, most), h, tau, delay) for x, _, h in runs])
        if np.ptp(shaped) == 0.0:
            continue
        mean, power = float(np.mean(shaped)), float(np.var(shaped))
        gain = float(np.mean(shaped * about)) / power
        rms = max(float(np.mean(about**2)) - gain**2 * power, 0.0) ** 0.5
        found.append(Lagged(gain, middle - gain * mean, float(tau), float(delay), rms, most, least))
    return min(found, key=lambda f: f.rms)


def _decay(runs: Sequence[tuple[Array, Array, float]], tau: float) -> Lagged:
    """The lag that takes outputs from where they start to where they rest under one and the same input."""
    decays = [np.exp(-h * np.arange(len(v)) / tau) for _, v, h in runs]
    at = np.cumsum([0, *(len(d) for d in decays)])
    columns = np.zeros((at[-1], 1 + len(runs)))
    columns[:, 0] = 1.0
    for i, decay in enumerate(decays):
        columns[at[i] : at[i + 1], 1 + i] = decay
    y = np.concatenate([v for _, v, _ in runs])
    parts = np.linalg.lstsq(columns, y, rcond=None)[0]
    rms = float(np.sqrt(np.mean((y - columns @ parts) ** 2)))
    asked = float(runs[0][0][0])
    gain = float(parts[0]) / asked if asked else 0.0
    return Lagged(gain or 1.0, 0.0, tau, 0.0, rms)


def loop_guess(runs: Sequence[Recording], drives: Sequence[Array]) -> LoopGuess:
    """Plays of the pressure that take it to the angle with least squares, weights not negative."""
    from scipy.optimize import nnls

    smooth = list(map(smoothed, drives))
    low, high = extent(smooth)
    span = high - low
    thresholds = np.array([reach * span * (i + 1) / PLAYS for reach in REACHES for i in range(PLAYS)])
    played = [np.column_stack([d, plays(d, thresholds)]) for d in smooth]
    y = np.concatenate([r.angle for r in runs if r.angle is not None])
    thin = slice(None, None, max(1, len(y) // ROWS))
    best: tuple[LoopGuess, Array] | None = None
    for tau in JOINT_LAGS:
        columns = np.concatenate(
            [lagged(p, median_step(r), tau, 0.0) for p, r in zip(played, runs, strict=True)]
        )
        for k, reach in enumerate(REACHES):
            own = columns[thin][:, [0, *range(1 + PLAYS * k, 1 + PLAYS * (k + 1))]]
            ones = np.ones((len(own), 1))
            weights, left = nnls(np.hstack([own, ones, -ones]), y[thin])
            outer = float(weights[: PLAYS + 1].sum())
            if outer <= 0.0:
                continue
            rest = -float(weights[-2] - weights[-1]) / outer
            inner, *others = map(float, weights[: PLAYS + 1])
            loop = RoughLoop(inner, tuple(others), reach * span, rest, low, high)
            found = LoopGuess(loop, tau, float(left / np.sqrt(len(own))))
            if best is None or found.rms < best[0].rms:
                best = found, own @ weights[: PLAYS + 1]
    if best is None:
        # An angle that does not rise with the pressure at all: a loop as flat as can be, for the fit to find.
        flat = RoughLoop(0.0, (1e-3,) * PLAYS, 0.1 * span, float(smooth[0][0]), low, high)
        return LoopGuess(flat, 0.1, float(np.std(y)))
    found, total = best
    return replace(found, loop=replace(found.loop, curve=rough_curve(total, y[thin])))


def smoothed(pressure: Array) -> Array:
    """A measured pressure [kPa] (n,) without most of its noise, which would work the plays."""
    from scipy.signal import savgol_filter

    found: Array = savgol_filter(pressure, SMOOTHED, 2) if len(pressure) > SMOOTHED else pressure
    return found


def plays(x: Array, thresholds: Array, start: float = 0.0) -> Array:
    """Plays of a series (n,) with thresholds (m,), shape (n, m), from where the series is ahead of them by a
    share `start` (-1 to 1) of each threshold."""
    found = np.empty((len(x), len(thresholds)))
    now = x[0] - start * thresholds
    for i, value in enumerate(x):
        now = np.minimum(np.maximum(now, value - thresholds), value + thresholds)
        found[i] = now
    return found


def static_guess(loop: RoughLoop, drives: Sequence[Array]) -> list[Array]:
    """The static angle [deg] of a rough loop, its curve taken for straight, under pressures [kPa], but for a
    constant."""
    n = len(loop.weights)
    thresholds = np.array([loop.reach * (i + 1) / n for i in range(n)])
    return [loop.inner * d + plays(d, thresholds) @ np.array(loop.weights) for d in drives]


def lagged(x: Array, dt: float, tau: float, delay: float) -> Array:
    """A series every `dt` [s], or its columns, through a delay [s] and a first-order lag of time constant
    `tau` [s], from rest at its first value."""
    from scipy.signal import lfilter

    late = round(delay / dt)
    if late:
        x = np.concatenate([np.repeat(x[:1], late, axis=0), x])[: len(x)]
    if tau <= 0.0:
        return x
    keep = np.exp(-dt / tau)
    start = np.asarray(x[:1] * keep, float)
    found: Array = lfilter([1.0 - keep], [1.0, -keep], x, axis=0, zi=start)[0]
    return found


def median_step(r: Recording) -> float:
    """The sample time [s] of a recording."""
    return float(np.median(np.diff(r.time)))


def extent(series: Sequence[Array]) -> tuple[float, float]:
    """Least and largest value of all series."""
    return min(float(s.min()) for s in series), max(float(s.max()) for s in series)
