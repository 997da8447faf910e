"""Orientations in a log: four channels that together are a quaternion."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from plants.measured.formats.channel import Array, LoggedChannel
from plants.measured.formats.columns import turned

UNIT = 0.05
"""Length of a quaternion over which it may be off from 1; recorders round."""

LETTERS = (("w", "x", "y", "z"), ("W", "X", "Y", "Z"), ("0", "1", "2", "3"))


def orientations(channels: Sequence[LoggedChannel]) -> dict[str, tuple[LoggedChannel, tuple[str, ...]]]:
    """The quaternions of a log by the name of their first channel: the angle [deg] that each has turned as a
    channel of that name, and the names of its four.

    >>> t = np.arange(3.0)
    >>> half = np.radians([0.0, 10.0, 20.0]) / 2
    >>> parts = {"q_w": np.cos(half), "q_x": np.sin(half), "q_y": 0 * half, "q_z": 0 * half}
    >>> found = orientations([LoggedChannel(n, "", t, v) for n, v in parts.items()])
    >>> found["q_w"][0].values[1:].round(6).tolist(), found["q_w"][1]
    ([10.0, 20.0], ('q_w', 'q_x', 'q_y', 'q_z'))
    """
    named = {c.name: c for c in channels}
    found: dict[str, tuple[LoggedChannel, tuple[str, ...]]] = {}
    for names in _quadruples(named):
        time, parts = _together([named[n] for n in names])
        length = np.sqrt(np.sum(np.square(parts), axis=0))
        if len(time) > 1 and np.all(np.abs(length - 1.0) < UNIT):
            found.setdefault(names[0], (LoggedChannel(names[0], "deg", time, turned(*parts)), names))
    return found


def _quadruples(named: Mapping[str, LoggedChannel]) -> Iterable[tuple[str, ...]]:
    """Names that differ in one letter alone: w, x, y and z, or 0 to 3."""
    for name in named:
        for first, *others in LETTERS:
            for i in (i for i, letter in enumerate(name) if letter == first):
                names = (name, *(name[:i] + letter + name[i + 1 :] for letter in others))
                if all(n in named for n in names):
                    yield names


def _together(channels: Sequence[LoggedChannel]) -> tuple[Array, list[Array]]:
    """Times [s] at which all channels have a value, and their values there."""
    time = channels[0].time
    for c in channels[1:]:
        time = np.intersect1d(time, c.time)
    return time, [c.values[np.isin(c.time, time)] for c in channels]
