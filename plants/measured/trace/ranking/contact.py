"""Contact with a stop: how far the drive goes on while the joint stays at an angle.

A joint that turns where its loop is flat stays at its largest angle as well.  Against a stop the pressure
goes on rising after the joint has come there.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.noise import noise_floor

Array = NDArray[np.float64]

NEAR = 3.0
"""Times the noise within which an angle is at a stop."""

CLEAR = (10.0, 0.02)
"""Times the noise, and share of its range, by which a channel has clearly gone back."""

STAYS = 1 / 3
"""Share of the rows, from the joint's coming until the drive has gone back, at which a joint that stays is at
the stop: a hum takes what is measured off it half of the time; one that swings past is there for a moment."""


def pressed_beyond(recordings: Sequence[Recording], angle: float, way: float) -> float:
    """By how much the drive goes on, at most, from where the joint comes to an angle [deg] and stays there or
    beyond, as a share of the drive's range; the pressure is the drive, or the command where it was not
    logged.  way: 1 for a largest angle, -1 for a least one.

    A joint comes to its stop after a step of the drive, which is then beyond already: what counts in a
    recording is the least drive at which it comes there.

    >>> t = np.arange(400) / 100
    >>> volts = 2.0 - 2.0 * np.cos(np.pi * t)
    >>> free, stopped = (Recording("a", t, volts, angle=np.minimum(10.0 * volts, top)) for top in (50, 30))
    >>> round(pressed_beyond([free], 39.0, 1.0), 3), round(pressed_beyond([stopped], 30.0, 1.0), 3)
    (0.024, 0.245)
    """
    seen = [
        (r.angle, way * (r.command if r.pressure is None else r.pressure))
        for r in recordings
        if r.angle is not None
    ]
    whole = float(np.ptp(np.concatenate([drive for _, drive in seen]))) if seen else 0.0
    return max(_pressed(own, drive, angle, way) for own, drive in seen) / whole if whole else 0.0


def _pressed(measured: Array, drive: Array, angle: float, way: float) -> float:
    beyond, noise = way * (measured - angle), noise_floor(measured)
    there = beyond >= -NEAR * noise
    at, left = np.flatnonzero(there), np.flatnonzero(beyond < -_clear(measured))
    back, coming, farthest = _clear(drive), np.inf, -np.inf
    since = 0
    while (k := int(np.searchsorted(at, since))) < len(at):
        i = int(at[k])
        gone = np.flatnonzero(drive[i:] < drive[i] - back)
        visit = slice(i, i + int(gone[0]) if len(gone) else None)
        if np.mean(there[visit]) >= STAYS:
            coming, farthest = min(coming, float(drive[i])), max(farthest, float(drive[visit].max()))
        # It comes anew once it has left.
        k = int(np.searchsorted(left, i))
        since = int(left[k]) if k < len(left) else len(drive)
    return max(0.0, farthest - coming)


def _clear(channel: Array) -> float:
    return max(CLEAR[0] * noise_floor(channel), CLEAR[1] * float(np.ptp(channel)))
