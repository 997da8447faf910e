"""Channels out of step: an angle that is logged late beside the pressure, or a pressure beside the angle.

A joint answers the pressure with a lag, or swings; neither is a delay.  The static angle of a first guess of
the loop is sent through lags, pairs of lags and swinging joints, and through a lag with a delay.  Only where
the delay leaves much less than any of the others is it one.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.campaign import Campaign
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.noise import in_steps
from plants.measured.guess.rough_models import ROWS, lagged, loop_guess, static_guess

Array = NDArray[np.float64]
LONGEST = 0.6
"""Largest delay between channels that is looked for [s]."""

TRIED = 24
"""Delays that are tried on either side."""

LAGS = (0.0, 0.02, 0.04, 0.07, 0.12, 0.2, 0.35, 0.6)
"""Time constants of the joint that are tried [s]."""

SWINGS = tuple(product((2.0, 4.0, 7.0, 12.0, 20.0), (0.2, 0.4, 0.7)))
"""Natural frequencies [rad/s] and damping ratios of a swinging joint that are tried."""

OVER = 0.3
"""Angles are compared by what they change within so many seconds: of their timing rather than of the loop's
curve, which a guess does not know."""

WHOLE = 0.05
"""Rows by which a delay may differ from whole ones and be taken for them."""

SURE = 0.8
"""Share of the error of the best joint without a delay below which what a delay leaves makes it one."""


def delay_between(campaign: Campaign) -> float:
    """By how much the angle is logged later than the pressure [s], negative where it is the pressure; 0 where
    a lag of the joint does nearly as well, where one of them was not logged, and where it is less than the
    time between renewals of a channel, in which nobody knows when a step was."""
    runs = [r for r in campaign.fit if r.pressure is not None and r.angle is not None]
    if not runs or sum(len(r.time) for r in runs) < 200:
        return 0.0
    dt = float(np.median(np.diff(runs[0].time)))
    step = max(dt, LONGEST / TRIED)
    delays = [k * step for k in range(-TRIED, TRIED + 1) if abs(k * step) <= LONGEST]
    ends, over = round(LONGEST / dt) + 1, max(1, round(OVER / dt))
    if any(len(r.time) < 4 * ends for r in runs):
        return 0.0
    angles = [r.angle for r in runs if r.angle is not None]
    drives = [r.pressure for r in runs if r.pressure is not None]
    best = 0.0
    # The guess of the loop hangs on the delay, so that both are found in turn.
    for _ in range(2):
        static = static_guess(loop_guess(runs, [_moved(d, dt, best) for d in drives]).loop, drives)
        plain = min(_left(joint, angles, ends, over) for joint in _joints(static, dt))
        slow = [[lagged(h, dt, tau, 0.0) for h in static] for tau in LAGS]
        found = [min(_left([_moved(h, dt, d) for h in s], angles, ends, over) for s in slow) for d in delays]
        k = int(np.argmin(found))
        if found[k] > SURE * plain:
            return 0.0
        best = delays[k] + step * _lowest(found[max(k - 1, 0) : k + 2])
    return best if abs(best) > max(map(_renewal, runs)) else 0.0


def _renewal(recording: Recording) -> float:
    """The longest time between renewals of a channel that is held [s], 0 where none is."""
    held = [np.diff(recording.time[fresh]) for fresh in recording.renewed.values() if fresh.sum() > 1]
    return max((float(np.median(gaps)) for gaps in held), default=0.0)


def _joints(static: Sequence[Array], dt: float) -> Iterable[list[Array]]:
    """What joints without a delay make of a static angle."""
    from scipy.signal import cont2discrete, lfilter, lfilter_zi

    for tau in LAGS:
        once = [lagged(h, dt, tau, 0.0) for h in static]
        yield once
        for other in LAGS[1:]:
            if tau and other <= tau:
                yield [lagged(h, dt, other, 0.0) for h in once]
    for frequency, damping in SWINGS:
        system = ([frequency**2], [1.0, 2.0 * damping * frequency, frequency**2])
        b, a, _ = cont2discrete(system, dt, "foh")
        zi = lfilter_zi(b.ravel(), a)
        yield [lfilter(b.ravel(), a, h, zi=zi * h[0])[0] for h in static]


def _moved(x: Array, dt: float, delay: float) -> Array:
    """A series later by a delay [s], earlier where it is negative, its ends held."""
    at = np.arange(len(x)) - delay / dt
    moved: Array = np.interp(at, np.arange(len(x)), x)
    return moved


def _left(found: Sequence[Array], angles: Sequence[Array], ends: int, over: int) -> float:
    """What a straight line of it leaves of the angles, without the ends that a delay makes up."""
    thin = slice(ends, -ends, max(1, sum(map(len, angles)) // ROWS))
    x, y = (np.concatenate([(v[over:] - v[:-over])[thin] for v in series]) for series in (found, angles))
    if np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return float(np.std(y))
    return float(np.std(y) * np.sqrt(max(1.0 - np.corrcoef(x, y)[0, 1] ** 2, 0.0)))


def _lowest(three: Sequence[float]) -> float:
    """Where a parabola through values at -1, 0 and 1 is lowest; 0 where there are fewer."""
    if len(three) < 3:
        return 0.0
    low, middle, high = three
    bend = low - 2.0 * middle + high
    return 0.5 * (low - high) / bend if bend > 0.0 else 0.0


def in_step(recording: Recording, channel: str, delay: float) -> Recording:
    """A recording whose channel was logged late by a delay [s], with its values at the times when they were;
    rows at the end, whose values were never written, are left out.

    Between two rows the value is a mean of both, and its neighbour shares one of them: then every other row
    counts, since noise that is alike from row to row looks like less of it."""
    field = {"angle_deg": "angle", "pressure_kPa": "pressure"}[channel]
    values = getattr(recording, field)
    if values is None or delay <= 0.0 or recording.time[-1] - recording.time[0] < 2.0 * delay:
        return recording
    moved: Any = in_steps(np.interp(recording.time + delay, recording.time, values), values)
    rows = delay / float(np.median(np.diff(recording.time)))
    renewed = recording.renewed
    if abs(rows - round(rows)) > WHOLE and not recording.held(channel):
        renewed = {**renewed, channel: recording.fresh(channel) & (np.arange(len(values)) % 2 == 0)}
    found = replace(recording, **{field: moved}, renewed=renewed)
    return found.until(float(recording.time[-1] - delay) + 1e-9)
