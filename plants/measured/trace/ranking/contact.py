"""Contact with a stop: how far the drive goes on while the joint stays at an angle.

A joint that turns where its loop is flat stays at its largest angle as well.  Against a stop the pressure
goes on rising after the joint has come there.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from plants.measured.noise import noise_floor
from plants.measured.recording import Recording

NEAR = 3.0
"""Times the noise within which an angle is at a stop."""

AWAY = (10.0, 0.02)
"""Times the noise, and share of the angle's range, by which a joint leaves a stop to come to it anew."""

STAYS = 1 / 3
"""Share of the rows between its coming and its leaving at which a joint that stays is at the stop: a hum
takes what is measured off it half of the time, and one that swings past an angle is there for a moment."""


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
    seen = [r for r in recordings if r.angle is not None]
    drives = [r.command if r.pressure is None else r.pressure for r in seen]
    if not seen or (whole := float(np.ptp(np.concatenate(drives)))) == 0.0:
        return 0.0
    return (
        max(_pressed(r.angle, way * drive, angle, way) for r, drive in zip(seen, drives, strict=True)) / whole
    )


def _pressed(measured: Any, drive: Any, angle: float, way: float) -> float:
    beyond, noise = way * (measured - angle), noise_floor(measured)
    there = beyond >= -NEAR * noise
    away = np.flatnonzero(beyond < -max(AWAY[0] * noise, AWAY[1] * float(np.ptp(measured))))
    coming, farthest = np.inf, -np.inf
    for rows in np.split(np.arange(len(drive)), away):
        at = rows[there[rows]]
        if len(at) and np.mean(there[at[0] : rows[-1] + 1]) >= STAYS:
            coming, farthest = min(coming, drive[at[0]]), max(farthest, drive[rows].max())
    return max(0.0, float(farthest - coming))
