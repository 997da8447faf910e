"""A first guess of a rig from its log alone: where a fit starts when no parameter set is given.

The regulator is guessed as a delay and a first-order lag from the command to the pressure, the loop as plays
of the pressure whose weights are found by least squares, none negative (Lawson & Hanson, Solving Least
Squares Problems, 1974): both are linear but for two numbers, which are tried on a grid.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from plants.hysteresis import LAWS, HysteresisLaw
from plants.measured.campaign import Campaign
from plants.measured.recording import Recording
from plants.parameters.quantities import Guessed, Parameter, ParameterSet, declared_kinds
from plants.rig import Rig, built_in_rig

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

BENT = 0.7
"""Share of the error that is left by a line that ends there, below which it is taken to end."""

PLAYS = 4
REACHES = (0.02, 0.04, 0.07, 0.12, 0.2, 0.3, 0.45)
"""Largest thresholds of the plays that are tried, as shares of the range of the pressure."""

JOINT_LAGS = (0.0, 0.03, 0.1, 0.3)
"""Time constants of the joint that are tried [s]."""

UNSEEN = 100.0
"""Range of the pressure [kPa] where none was logged, so that its unit is nobody's."""

LOOP_TIMES = (0.002, 0.02)
"""Sample times of the model [s]: a share of the regulator's time constant within these, never above the
log's."""

OF_LAG = 1.0 / 30.0
"""That share."""


@dataclass(frozen=True)
class Lagged:
    """Output = gain * (lag of time constant `tau` [s] of the input, `delay` [s] late) + offset; rms: what it
    leaves.  most: input above which the output rises no more, infinite where there is none."""

    gain: float
    offset: float
    tau: float
    delay: float
    rms: float
    most: float = np.inf


@dataclass(frozen=True)
class LoopGuess:
    """Slopes just after a reversal and of the outer branches [deg/kPa], weights of the plays, the largest
    threshold [kPa], pressure of zero angle [kPa], lag of the joint [s]; rms: what it leaves [deg]."""

    inner: float
    weights: tuple[float, ...]
    reach: float
    rest: float
    lag: float
    rms: float

    @property
    def outer(self) -> float:
        """Slope of the outer branches."""
        return self.inner + sum(self.weights)

    @property
    def width(self) -> float:
        """Half the width of the loop [deg]."""
        n = len(self.weights)
        return sum(w * self.reach * (i + 1) / n for i, w in enumerate(self.weights))


def guessed_rig(campaign: Campaign) -> Rig:
    """The rig that a log shows: its motion, its ranges, its sample times; a step of a third of its range.

    Limits and shares of uncertainty are those of the built-in rig; the total variation goes with the range.
    """
    base, recordings = built_in_rig(), (*campaign.fit, *campaign.validate)
    low, high = _range([r.command for r in recordings])
    pressures = [r.pressure for r in recordings if r.pressure is not None]
    least, most = _range(pressures) if pressures else (0.0, UNSEEN)
    angles = [r.angle for r in recordings if r.angle is not None]
    step = _rounded(np.ptp(_range(angles)) / 3.0) if angles else base.task.step
    middle = 0.5 * (least + most)
    task = replace(base.task, step=step, reaction=(middle, middle + 0.25 * (most - least)))
    per_volt = (high - low) / (base.command_range[1] - base.command_range[0])
    limits = {n: v * per_volt if n == "total_variation_V" else v for n, v in base.limits.items()}
    return replace(
        base, name=campaign.axis, title=f"Rig of {campaign.name}", motions=(campaign.axis,),
        command_range=(low, high), pressure_range=(least, most), task=task, limits=limits,
        sample_time=_loop_time(campaign.sample_time, _followed(campaign.fit).tau),
        log_time=campaign.sample_time,
    )  # fmt: skip


def guessed_set(
    campaign: Campaign, law: str = "four-segment", rig: Rig | None = None, wide: float = 8.0
) -> ParameterSet:
    """Starting values and bounds of the declared parameters, from the recordings to fit on.

    law: name of the hysteresis law; rig: whose motion it is, `guessed_rig` where not given; wide: factor by
    which bounds lie around a guess.  All provenance is `Guessed`.  Raises KeyError for an unknown law.
    """
    rig = guessed_rig(campaign) if rig is None else rig
    kind, logged = LAWS[law], [r for r in campaign.fit if r.pressure is not None]
    low, high = rig.pressure_range
    seen = _followed(campaign.fit)
    if logged:
        gain = seen.gain
        drives = [r.pressure for r in campaign.fit if r.pressure is not None]
    else:
        gain = (high - low) / (rig.command_range[1] - rig.command_range[0])
        drives = [lagged(gain * r.command, _dt(r), seen.tau, seen.delay) for r in campaign.fit]
    rate = 1.0 / max(seen.tau, 1e-3)
    span = high - low
    values = {"gain": gain, "k_fast": rate, "k_slow": rate, "e0": 0.2 * span}
    # Where the pressure ends below what is commanded, the declared regulator is best with a smaller gain.
    share = (
        (high - low) / (abs(gain) * (rig.command_range[1] - rig.command_range[0]))
        if np.isfinite(seen.most)
        else 1.0
    )
    ends = (0.5 * min(share, 1.0) * gain, 2.0 * gain)
    bounds = {
        "gain": (min(ends), max(ends)),
        "k_fast": (rate / wide, rate * wide), "k_slow": (rate / wide**2, rate * wide),
        "e0": (1e-3 * span, 2.0 * span),
    }  # fmt: skip
    if campaign.stage == "wrist":
        runs = [r for r in campaign.fit if r.pressure is not None] if logged else list(campaign.fit)
        loop = loop_guess(runs, drives)
        if campaign.start == "rest":
            rest = float(np.median([np.median(d[:3]) for d in drives]))
            loop = replace(loop, rest=rest)
        own, around = _of_law(kind, loop, rig, runs)
        values |= own
        bounds |= around
    else:
        own = kind.guess(0.1, 0.02, 0.05 * span, low, span)
        values |= own | {"Tw": 0.1}
        bounds |= {n: (min(0.0, v), max(2.0 * v, 1.0)) for n, v in own.items()} | {"Tw": (0.005, 5.0)}
    why = Guessed(f"{campaign.name} (sha256 {campaign.checksum[:12]})")
    kinds = declared_kinds(kind, values)
    parameters = {}
    for name, known in kinds.items():
        value, (least, most) = float(values[name]), bounds[name]
        parameters[name] = Parameter(value, known.unit, min(least, value), max(most, value), why)
    return ParameterSet(campaign.axis, f"{campaign.axis}, guessed from its log", parameters, (), rig)


def _followed(recordings: Sequence[Recording]) -> Lagged:
    """How the pressure follows the command, or the angle where no pressure was logged."""
    field = "pressure" if any(r.pressure is not None for r in recordings) else "angle"
    return first_order(recorded(recordings, field))


def _of_law(
    law: type[HysteresisLaw], loop: LoopGuess, rig: Rig, runs: Sequence[Recording]
) -> tuple[dict[str, float], dict[str, tuple[float, float]]]:
    """Values and bounds of the parameters of a law and of the joint."""
    span = rig.pressure_range[1] - rig.pressure_range[0]
    stroke = float(np.ptp(_range([r.angle for r in runs if r.angle is not None])))
    slope = stroke / span
    gap = loop.width / max(loop.outer - loop.inner, 1e-9)
    values = law.guess(loop.outer, loop.inner, gap, loop.rest, span) | {"Tw": max(loop.lag, 0.02)}
    plays = [n for n in values if n[:1] == "v" and n != "v0"]
    if len(plays) == len(loop.weights):
        values |= dict(zip(plays, (max(w, 1e-3 * slope) for w in loop.weights), strict=True))
        values["reach"] = loop.reach
    bounds = {}
    for name, kind in declared_kinds(law, values).items():
        if name not in values:
            continue
        match kind.unit:
            case "deg/kPa":
                bounds[name] = (0.0 if kind.low == 0.0 else 0.02 * slope, 8.0 * slope)
            case "deg":
                bounds[name] = (0.02 * stroke if name == "span" else -stroke, 2.0 * stroke)
            case "kPa" if name == "rest_pressure":
                bounds[name] = (loop.rest - span, loop.rest + span)
            case "kPa":
                bounds[name] = (1e-3 * span, span)
            case _:
                bounds[name] = (kind.low, kind.high)
    return values, bounds


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
    low, high = _range([x for x, _, _ in runs])
    if high == low:
        return min((_decay(runs, float(tau)) for tau in lags), key=lambda f: f.rms)
    delays = np.unique(np.round(np.linspace(0.0, min(LONGEST_DELAY, 0.05 * longest), DELAYS) / dt) * dt)
    line = _late_line(runs, delays, lags)
    ended = [_late_line(runs, (line.delay,), lags[::2], low + s * (high - low)) for s in REACHED]
    least = min(ended, key=lambda f: f.rms)
    return _late_line(runs, delays, lags, least.most) if least.rms < BENT * line.rms else line


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
) -> Lagged:
    """The best of some delays and lags, the input taken to be `most` where it is above."""
    found, y = [], np.concatenate([v for _, v, _ in runs])
    middle = float(np.mean(y))
    about = y - middle
    for delay, tau in product(delays, lags):
        shaped = np.concatenate([lagged(np.minimum(x, most), h, tau, delay) for x, _, h in runs])
        if np.ptp(shaped) == 0.0:
            continue
        mean, power = float(np.mean(shaped)), float(np.var(shaped))
        gain = float(np.mean(shaped * about)) / power
        rms = max(float(np.mean(about**2)) - gain**2 * power, 0.0) ** 0.5
        found.append(Lagged(gain, middle - gain * mean, float(tau), float(delay), rms, most))
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
    from scipy.signal import savgol_filter

    smooth = [savgol_filter(d, 9, 2) if len(d) > 9 else d for d in drives]
    span = float(np.ptp(_range(smooth)))
    thresholds = np.array([reach * span * (i + 1) / PLAYS for reach in REACHES for i in range(PLAYS)])
    played = [np.column_stack([d, plays(d, thresholds)]) for d in smooth]
    y = np.concatenate([r.angle for r in runs if r.angle is not None])
    thin = slice(None, None, max(1, len(y) // ROWS))
    best: LoopGuess | None = None
    for tau in JOINT_LAGS:
        columns = np.concatenate([lagged(p, _dt(r), tau, 0.0) for p, r in zip(played, runs, strict=True)])
        for k, reach in enumerate(REACHES):
            own = columns[thin][:, [0, *range(1 + PLAYS * k, 1 + PLAYS * (k + 1))]]
            ones = np.ones((len(own), 1))
            weights, left = nnls(np.hstack([own, ones, -ones]), y[thin])
            outer = float(weights[: PLAYS + 1].sum())
            if outer <= 0.0:
                continue
            offset = float(weights[-2] - weights[-1])
            found = LoopGuess(
                float(weights[0]), tuple(map(float, weights[1 : PLAYS + 1])), reach * span, -offset / outer,
                tau,
                float(left / np.sqrt(len(own))),
            )  # fmt: skip
            best = found if best is None or found.rms < best.rms else best
    # An angle that does not rise with the pressure at all: a loop as flat as can be, for the fit to find out.
    return best or LoopGuess(0.0, (1e-3,) * PLAYS, 0.1 * span, float(smooth[0][0]), 0.1, float(np.std(y)))


def plays(x: Array, thresholds: Array, start: float = 0.0) -> Array:
    """Plays of a series (n,) with thresholds (m,), shape (n, m), from where the series is ahead of them by a
    share `start` (-1 to 1) of each threshold."""
    found = np.empty((len(x), len(thresholds)))
    now = x[0] - start * thresholds
    for i, value in enumerate(x):
        now = np.minimum(np.maximum(now, value - thresholds), value + thresholds)
        found[i] = now
    return found


def static_guess(loop: LoopGuess, drives: Sequence[Array]) -> list[Array]:
    """The static angle [deg] of a guessed loop under pressures [kPa], but for a constant."""
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


def _dt(r: Recording) -> float:
    return float(np.median(np.diff(r.time)))


def _range(series: Sequence[Array]) -> tuple[float, float]:
    return min(float(s.min()) for s in series), max(float(s.max()) for s in series)


def _rounded(value: float) -> float:
    """To two digits."""
    return float(f"{value:.2g}")


def _loop_time(log: float, tau: float) -> float:
    """A whole part of the log's sample time [s], short against the regulator's time constant [s]."""
    least, most = LOOP_TIMES
    target = min(max(tau * OF_LAG, least), most, log)
    return log / max(1, round(log / target))
