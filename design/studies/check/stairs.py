"""What a log of a closed loop shows stair by stair: the same figures of a rig and of simulated ones."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from design.evaluation.scaled import SMALLEST
from plants.errors import InputError

Array = NDArray[np.float64]
SHORTEST = 0.5
"""A reference held for less [s] is passed through, and not judged."""

AVERAGED = 0.05
"""Time [s] over which readings are averaged, so that peaks are the angle's and not the noise's."""

END = 0.2
"""Last share of a stair, in which it is judged where the wrist has come to."""

BAND = 0.05
"""Half-width of the band in which a stair is settled, as a share of the task's step: wider than that of the
requirement, which noise would leave again."""

UNITS = {
    "overshoot": "%", "rise time": "s", "settling time": "s", "IAE": "deg s", "error at the end": "deg",
    "command at the end": "V",
}  # fmt: skip
"""Figures of a stair, in the order in which they are known, with their units."""

FINEST = {
    "overshoot": 1.0, "rise time": 0.02, "settling time": 0.05, "IAE": 0.1, "error at the end": 0.05,
    "command at the end": 0.02,
}  # fmt: skip
"""Differences below which a figure is the same, in its unit: of a log at 100 Hz with the noise that logs
have."""


@dataclass(frozen=True)
class Stair:
    """A reference [deg] held from a row to another, the later not included; times [s]."""

    reference: float
    first: int
    last: int
    begins: float
    ends: float


def stairs_of(time: Array, reference: Array) -> tuple[Stair, ...]:
    """The stairs of a logged reference that are long enough to be judged, but for one at the start that
    asks for nothing new.  Raises InputError where there is none."""
    edges = [0, *(np.flatnonzero(np.diff(reference) != 0.0) + 1).tolist(), len(time) - 1]
    found = tuple(
        Stair(float(reference[a]), a, b, float(time[a]), float(time[b]))
        for k, (a, b) in enumerate(pairwise(edges))
        if time[b] - time[a] >= SHORTEST and (k > 0 or reference[0] != 0.0)
    )
    if not found:
        raise InputError(
            f"reference_deg never steps and stays for {SHORTEST:g} s; log steps such as the task's"
        )
    return found


def figures(
    stairs: tuple[Stair, ...], time: Array, angle: Array, command: Array, step: float
) -> dict[tuple[int, str], Array]:
    """Figures of stairs, by number of the stair and name, each (lanes,): of readings of the angle [deg] and
    commands [V], (rows, lanes); step [deg]: the task's.

    >>> t = np.arange(0.0, 10.0, 0.01)
    >>> answer = (15.0 * (1.0 - np.exp(-t / 0.5)))[:, None]
    >>> found = figures(stairs_of(t, np.full_like(t, 15.0)), t, answer, 0.0 * answer, 15.0)
    >>> [round(float(found[0, n][0]), 1) for n in ("overshoot", "rise time", "settling time", "IAE")]
    [0.0, 1.2, 1.5, 7.5]
    """
    from scipy.ndimage import uniform_filter1d

    dt = float(np.median(np.diff(time)))
    rows = max(1, round(AVERAGED / dt))
    smooth = uniform_filter1d(angle, rows, axis=0, mode="nearest")
    found: dict[tuple[int, str], Array] = {}
    for i, s in enumerate(stairs):
        begin = smooth[max(s.first - rows, 0)]
        y, since = smooth[s.first : s.last], time[s.first : s.last] - s.begins
        way, size = np.sign(s.reference - begin), np.abs(s.reference - begin)
        lasts, error = s.ends - s.begins, s.reference - y
        beyond = np.maximum((-error * way).max(axis=0), 0.0)
        far = np.abs(error) > BAND * step
        risen = (y - begin) * way >= 0.9 * size
        end = slice(round((1.0 - END) * len(y)), None)
        found[i, "overshoot"] = 100.0 * beyond / np.maximum(size, SMALLEST * step)
        found[i, "rise time"] = np.where(risen.any(axis=0), since[np.argmax(risen, axis=0)], lasts)
        outside = since[len(y) - 1 - np.argmax(far[::-1], axis=0)] + dt
        found[i, "settling time"] = np.where(far.any(axis=0), np.minimum(outside, lasts), 0.0)
        found[i, "IAE"] = np.trapezoid(np.abs(error), dx=dt, axis=0)
        found[i, "error at the end"] = error[end].mean(axis=0)
        found[i, "command at the end"] = command[s.first : s.last][end].mean(axis=0)
    return found
