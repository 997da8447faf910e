"""Contact with a stop: how far the drive goes on while the joint stays at an angle.

A joint that turns where its loop is flat stays at its largest angle as well.  Against a stop the pressure
goes on rising after the joint has come there.
"""

from collections.abc import Sequence

import numpy as np

from plants.measured.noise import noise_floor
from plants.measured.recording import Recording

NEAR = 3.0
"""Times the noise within which an angle is at a stop."""


def pressed_beyond(recordings: Sequence[Recording], angle: float, way: float) -> float:
    """By how much the drive goes on, at most, after the joint has come to an angle [deg], while the joint
    stays there or beyond, as a share of the drive's range; the pressure is the drive, or the command where it
    was not logged.  way: 1 for a largest angle, -1 for a least one.

    >>> t = np.arange(400) / 100
    >>> volts = 2.0 - 2.0 * np.cos(np.pi * t)
    >>> free, stopped = (Recording("a", t, volts, angle=np.minimum(10.0 * volts, top)) for top in (50, 30))
    >>> round(pressed_beyond([free], 39.0, 1.0), 3), round(pressed_beyond([stopped], 30.0, 1.0), 3)
    (0.024, 0.245)
    """
    most = 0.0
    seen = [r for r in recordings if r.angle is not None]
    drives = [r.command if r.pressure is None else r.pressure for r in seen]
    if not seen or (whole := float(np.ptp(np.concatenate(drives)))) == 0.0:
        return 0.0
    for r, drive in zip(seen, drives, strict=True):
        assert r.angle is not None
        there = way * (r.angle - angle) >= -NEAR * noise_floor(r.angle)
        begins = np.flatnonzero(there & ~np.append(False, there[:-1]))
        ends = np.flatnonzero(there & ~np.append(there[1:], False)) + 1
        for i, j in zip(begins, ends, strict=True):
            most = max(most, float(np.max(way * (drive[i:j] - drive[i]))))
    return most / whole
