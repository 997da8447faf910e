"""Rows of a log that are closer than a fit needs: every n-th is kept, and between them the command's mean.

A regulator that takes 100 ms to follow tells nothing in a millisecond, and each row costs time.  Over a row
that is short against the time constants a command acts by its mean, so that jumps between kept rows come at
their time.  What was measured is taken at the kept rows, not averaged, which keeps its time and its noise.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.recording import Recording

Array = NDArray[np.float64]
FINEST = 0.01
"""Distance of rows [s] that is never exceeded: that of the built-in rig's log."""

OF_LAG = 0.1
"""Distance of rows that is close enough, as a share of the regulator's time constant."""

ON = 0.99
"""Share of a sample beyond which a row is one sample on."""


def rows_for(recordings: Sequence[Recording], lag: float) -> int:
    """Which row in how many is kept of recordings of a regulator of a time constant [s]: 1 for all, as where
    a logger renews a channel in some rows only.

    >>> time = np.arange(0.0, 1.0, 0.001)
    >>> rows_for([Recording("a", time, 0.0 * time, time)], 0.08)
    8
    """
    if any(r.held(channel) for r in recordings for channel in r.renewed):
        return 1
    step = min(_step(r) for r in recordings)
    return max(1, int(min(FINEST, OF_LAG * lag) / step + 1e-6))


def decimated(recording: Recording, rows: int) -> Recording:
    """The recording with every n-th of its rows, and the mean of the command from each to the next.

    >>> logged = Recording("a", np.arange(6) * 0.001, np.array([0.0, 0.0, 3.0, 3.0, 3.0, 3.0]))
    >>> decimated(logged, 3).command.tolist()
    [1.0, 3.0]
    """
    if rows == 1:
        return recording
    kept = slice(None, None, rows)
    arrays: dict[str, Any] = {n: v[kept] for n, v in vars(recording).items() if isinstance(v, np.ndarray)}
    end = 2.0 * recording.time[-1] - recording.time[-2]
    edges = np.append(recording.time[kept], end)
    arrays["command"] = mean_held(recording.time, recording.command, edges)
    extra = {n: v[kept] for n, v in recording.extra.items()}
    renewed = {n: v[kept] for n, v in recording.renewed.items()}
    return replace(recording, **arrays, extra=extra, renewed=renewed, between="held", ahead=None)


def for_sample_time(recording: Recording, sample_time: float, log_time: float) -> Recording:
    """The recording at rows that fall on samples [s] of a model where its own are closer than these, at the
    most as far apart as those of the rig's log [s]."""
    step = _step(recording)
    if step > ON * sample_time:
        return recording
    most = max(1, round(log_time / step))
    whole = (n for n in range(1, most) if _is_whole(n * step / sample_time))
    return decimated(recording, next(whole, most))


def _is_whole(samples: float) -> bool:
    return samples > ON and abs(samples - round(samples)) < 1.0 - ON


def _step(recording: Recording) -> float:
    return float(np.median(np.diff(recording.time)))


def mean_held(time: Array, values: Array, edges: Array) -> Array:
    """Mean of values (n,), each held from its time [s] on, from each of some edges [s] to the next, (k,).

    >>> mean_held(np.array([0.0, 1.0, 2.0]), np.array([1.0, 2.0, 5.0]), np.array([0.0, 2.0, 3.0])).tolist()
    [1.5, 5.0]
    """
    ends = np.append(time, max(edges[-1], time[-1]))
    area = np.append(0.0, np.cumsum(values * np.diff(ends)))
    mean: Array = np.diff(np.interp(edges, ends, area)) / np.diff(edges)
    changes = time[1:][np.diff(values) != 0.0]
    first = np.searchsorted(changes, edges[:-1], side="right")
    last = np.searchsorted(changes, edges[1:], side="left")
    held = values[np.maximum(np.searchsorted(time, edges[:-1], side="right") - 1, 0)]
    return np.where(first == last, held, mean)  # what does not change is not rounded
