"""Free runs: a recording beside what wrists make of its command alone, and the errors of that."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.begin import measured
from plants.measured.campaigns.recording import Recording

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FreeRun:
    """A recording beside free runs of the wrist that was found and of the one before, shape (n,) each.

    role: ``fit``, or ``validate`` where it is held out; angles are None for a campaign of the regulator
    alone.
    """

    recording: Recording
    role: str
    pressure: Array
    angle: Array | None
    pressure_before: Array
    angle_before: Array | None


def squares(
    runs: Sequence[FreeRun], channel: str, before: bool = False, role: str = "validate"
) -> list[Array]:
    """Squared errors of the recordings of a role that logged a channel, one array for each."""
    name = ("pressure" if channel == "pressure_kPa" else "angle") + ("_before" if before else "")
    used = [r for r in runs if r.role == role]
    pairs = [
        (getattr(r, name), measured(r.recording, channel), r.recording.judged & r.recording.fresh(channel))
        for r in used
    ]
    return [(a - b)[rows] ** 2 for a, b, rows in pairs if a is not None and b is not None]


def rmse(runs: Sequence[FreeRun], channel: str, before: bool = False, role: str = "validate") -> float | None:
    """Root mean square error of a channel over the runs of a role; None where it was not logged."""
    found = squares(runs, channel, before, role)
    return float(np.sqrt(np.mean(np.concatenate(found)))) if found else None
