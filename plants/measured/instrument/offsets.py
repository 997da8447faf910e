"""Angles that are counted from another zero in each recording, where recordings start anywhere.

Under one pressure, as at rest, a rig starts at one angle, but for what its joint remembers and for a sensor
that is zeroed anew.  What it remembers is forgotten once the pressure has crossed its range; an offset stays.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.begin import rows_before_move
from plants.measured.campaigns.campaign import Campaign
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.blocks import judged_blocks, lower
from plants.measured.fitting.noise import noise_floor, resolution
from plants.measured.guess.regressors import Regressors, left_by, smooth_pressure
from plants.measured.guess.rough_models import (
    JOINT_LAGS,
    ROWS,
    extent,
    first_order,
    lagged,
    median_step,
    recorded,
)  # fmt: skip

Array = NDArray[np.float64]
FIRST, STILL, RESTS = 3, 0.005, 1.0
"""Rows whose mean is where a recording begins: so many at least, or all of the first second [s] in which
the command has moved by no more than a share of its range."""

TOGETHER = 0.02
"""Share of the range of the pressure within which recordings begin at one pressure."""

CROSSED = 0.6
"""Share of that range that the pressure has to cross until what was before is forgotten."""

FEW = 50
"""Rows that a recording needs."""

FEWEST = 200
"""Rows past the first strokes that are needed."""

OTHER = 3.0
"""Times a reading, of many that are tried, that may not do better than the reading."""

REFINED = 0.005
"""Time constants of the joint [s] are looked for to about this."""

LOUD, STEPS = 4.0, 1.0
"""First angles are offset if they differ by more than these times their standard error and the resolution of
the angle."""

REGRESSED, PRECISE = 0.004, 0.001
"""Shares of the range of the angle: by how much first angles have to be off that a regression has told, and
how large their standard error may be.  The regression is no model of the joint: with a larger one it was off
by up to 2 % on soft actuators drawn at random, else by 0.1 to 0.4 %."""


def offsets_between(campaign: Campaign) -> dict[str, float]:
    """Offset of the angle [deg] of each recording, by name, about their median; empty where there are none
    for certain.

    The offset of a recording is read off its first rows, that of one held out as well.  Readings are taken
    for offsets only if a regression of the angle on the pressure, in what follows the first stroke of each
    recording that may be fitted on, leaves less with them taken off, for certain over blocks
    (`blocks.lower`); of all of them together, else of one after the other.  Where those that may be fitted on
    agree, one that is held out may still have been zeroed anew: its reading is put to the test beside theirs.
    """
    runs, held_out = (
        [r for r in recordings if r.pressure is not None and r.angle is not None]
        for recordings in _with_a_pressure(campaign.fit, campaign.validate)
    )
    if not runs or len(runs) + len(held_out) < 2 or any(len(r.time) < FEW for r in (*runs, *held_out)):
        return {}
    low, high = extent(list(map(_pressure, runs)))
    if high == low:
        return {}
    readings = _readings(runs, held_out)
    own = readings[: len(runs)]
    none = np.zeros(len(runs))
    if _offset(runs, none, own):
        return dict(zip((r.name for r in (*runs, *held_out)), map(float, readings), strict=True))
    found = none.copy()
    for i, alone in enumerate(np.diag(own) if len(runs) > 2 else ()):
        if _offset(runs, found, alone, len(runs)):
            found[i] = own[i]
    known, others = np.append(found, 0.0), map(float, readings[len(runs) :])
    apart = {
        r.name: v
        for r, v in zip(held_out, others, strict=True)
        if _offset([*runs, r], known, np.append(none, v), len(held_out))
    }
    return {r.name: float(v) for r, v in zip(runs, found, strict=True) if v} | apart


def _with_a_pressure(
    fit: Sequence[Recording], validate: Sequence[Recording]
) -> tuple[Sequence[Recording], Sequence[Recording]]:
    """Recordings, of which none may have a pressure: then, in its place, what the lag and the dead time make
    of the command with which the angle follows it best; the unit does not matter here."""
    with_angle = recorded(fit, "angle")
    if not with_angle or any(r.pressure is not None for r in (*fit, *validate)):
        return fit, validate
    follows = first_order(with_angle)

    def with_one(r: Recording) -> Recording:
        return replace(r, pressure=lagged(r.command, median_step(r), follows.tau, follows.delay))

    return list(map(with_one, fit)), list(map(with_one, validate))


def _offset(runs: Sequence[Recording], known: Array, readings: Array, tests: int = 1) -> bool:
    """Whether readings [deg] of recordings are offsets beside those that are known, (recordings,) both;
    tests: how many of them are made."""
    return float(np.ptp(readings)) > max(map(_told, runs)) and _persist(runs, known, readings, tests)


def _persist(runs: Sequence[Recording], known: Array, offsets: Array, tests: int) -> bool:
    """Whether a regression of the angle on the pressure leaves less after the first strokes with offsets
    taken off beside those that are known, (recordings,) both, for certain over blocks."""
    sample = _Rows(runs)
    if len(sample.number) < FEWEST:
        return False
    angles = sample.angles - known[sample.number]

    def left(lag: float) -> tuple[Array, Array]:
        columns = sample.columns(lag)
        return left_by(columns, angles), left_by(columns, angles - offsets[sample.number])

    as_logged, without = left(_lag(lambda lag: float(np.mean(left(lag)[0] ** 2))))
    # What is left is linear in the offsets: of many tried one that should be far larger is there by chance.
    more = as_logged + OTHER * (without - as_logged)
    if tests > 1 and float(without @ without) >= float(more @ more):
        return False
    return lower(as_logged, without, np.unique(sample.blocks, return_inverse=True)[1], tests)


class _Rows:
    """Rows of recordings that follow their first strokes, thinned: their angles [deg], the number of the
    recording of each, and blocks of time, (rows,) all."""

    def __init__(self, runs: Sequence[Recording]) -> None:
        kept = [_past_first_stroke(runs, r) for r in runs]
        thin = max(1, sum(map(np.size, kept)) // ROWS)
        self._runs, self._rows = runs, [own[::thin] for own in kept]
        self.number = np.repeat(np.arange(len(runs)), list(map(len, self._rows)))
        self.angles = np.concatenate([_angle(r)[own] for r, own in zip(runs, self._rows, strict=True)])
        first = np.cumsum([0, *(len(r.time) for r in runs[:-1])])
        self.blocks = judged_blocks([r.time for r in runs])[np.concatenate([*map(np.add, self._rows, first)])]

    def columns(self, lag: float) -> Array:
        """Regressors with a lag of the joint [s], (rows, n)."""
        of = Regressors.of(self._runs, lag)
        return np.concatenate([of.over(r)[own] for r, own in zip(self._runs, self._rows, strict=True)])


def _lag(error: Callable[[float], float]) -> float:
    """The time constant of the joint [s] at which an error is least: the best of some, refined between its
    neighbours, since a lag that is a little off leaves more than an offset does."""
    from scipy.optimize import minimize_scalar

    k = int(np.argmin([error(lag) for lag in JOINT_LAGS]))
    bounds = JOINT_LAGS[max(k - 1, 0)], JOINT_LAGS[min(k + 1, len(JOINT_LAGS) - 1)]
    found = minimize_scalar(error, bounds=bounds, method="bounded", options={"xatol": REFINED})
    return float(found.x)


def _past_first_stroke(runs: Sequence[Recording], r: Recording) -> NDArray[np.intp]:
    """Rows in which the angle was measured after the pressure has crossed its range."""
    span = float(np.ptp(extent([smooth_pressure(other) for other in runs])))
    pressure = smooth_pressure(r)
    crossed = np.maximum.accumulate(pressure) - np.minimum.accumulate(pressure)
    return np.flatnonzero((crossed >= CROSSED * span) & r.shown("angle_deg") & r.fresh("pressure_kPa"))


def _readings(runs: Sequence[Recording], held_out: Sequence[Recording]) -> Array:
    """What recordings say of their offsets [deg], about the median of those that may be fitted on: their
    first angles, or, where the sensor shows none then, what a regression finds."""
    recordings = [*runs, *held_out]
    first = _first_angles(recordings)
    shown = list(map(_first_shown, recordings))
    known = [i for i in range(len(runs)) if shown[i]]
    others = known or [0]
    middle = float(np.median(first[others]))
    for i, r in enumerate(recordings):
        if shown[i] or i in others:
            continue
        first[i], error = _regressed([recordings[k] for k in others], first[others], r)
        if error > PRECISE * float(np.ptp(_angle(r))):
            first[i] = middle
        elif known:  # it would have been read if it were within the range
            first[i] = _beyond(first[i], r)
    return first - float(np.median(first[: len(runs)]))


def _beyond(angle: float, r: Recording) -> float:
    """An angle [deg], or the end of the sensor's range at which a recording begins, where it lies within."""
    low, high = r.ranges["angle_deg"]
    return min(angle, low) if _angle(r)[0] <= low else max(angle, high)


def _regressed(runs: Sequence[Recording], known: Array, other: Recording) -> tuple[float, float]:
    """The offset [deg] of another recording beside those of some, which are known, (recordings,), with which
    a regression of the angle on the pressure leaves least, and its standard error over blocks: infinite where
    too few rows follow the first strokes."""
    sample = _Rows([*runs, other])
    angles = sample.angles - np.append(known, 0.0)[sample.number]
    own = (sample.number == len(runs)).astype(float)[:, None]
    if len(own) < FEWEST or not 0.0 < own.mean() < 1.0:
        return 0.0, np.inf
    lag = _lag(lambda lag: float(np.mean(left_by(np.hstack([sample.columns(lag), own]), angles) ** 2)))
    columns = sample.columns(lag)
    beside, about = left_by(columns, own[:, 0]), left_by(columns, angles)
    power = float(beside @ beside)
    found = float(beside @ about) / power
    blocks = np.unique(sample.blocks, return_inverse=True)[1]
    moves = np.bincount(blocks, beside * (about - found * beside))
    return found, float(np.sqrt(moves @ moves)) / power


def _first_angles(runs: Sequence[Recording]) -> Array:
    """First angles of recordings [deg]; where one begins at another pressure than the others, without what
    the slope of the whole stroke makes of that."""
    rows = [_first_rows(r) for r in runs]
    first, angles = (
        np.array([float(np.mean(of(r)[:n])) for r, n in zip(runs, rows, strict=True)])
        for of in (_pressure, _angle)
    )
    ends = [np.ptp(extent(list(map(of, runs)))) for of in (_angle, _pressure)]
    away = first - float(np.median(first))
    return angles - np.where(np.abs(away) < TOGETHER * ends[1], 0.0, away * ends[0] / ends[1])


def _first_shown(r: Recording) -> int:
    """How many of these rows show the angle: none where the sensor is saturated at first."""
    return int(r.shown("angle_deg")[: _first_rows(r)].sum())


def _first_rows(r: Recording) -> int:
    """How many rows tell where a recording begins."""
    still = rows_before_move(r, STILL * float(np.ptp(r.command)))
    return max(FIRST, min(still, int(np.searchsorted(r.time - r.time[0], RESTS))))


def _told(r: Recording) -> float:
    """Least difference of readings [deg] that is more than noise and steps of the sensor."""
    angle, rows = _angle(r)[r.shown("angle_deg")], _first_shown(r)
    if not rows:
        return REGRESSED * float(np.ptp(_angle(r)))
    return max(LOUD * noise_floor(angle) / float(np.sqrt(rows)), STEPS * resolution(angle))


def _angle(r: Recording) -> Array:
    assert r.angle is not None
    return r.angle


def _pressure(r: Recording) -> Array:
    assert r.pressure is not None
    return r.pressure
