"""Where recordings start, and what was measured in them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plants.hysteresis import HysteresisLaw
from plants.measured.recording import Recording
from plants.wrist import Number, State

Array = NDArray[np.float64]
NEAR = 5.0, 1.0
"""Pressures [kPa] and angles [deg] closer together than this are those of the same rest."""


@dataclass(frozen=True)
class Begin:
    """Where a recording starts that does not start at rest: pressure [kPa], angle [deg], and
    whether the wrist is still on its virgin curve."""

    pressure: float
    angle: float
    virgin: bool

    def state(self, loop: HysteresisLaw) -> State:
        """The state of a wrist with a loop; on the virgin curve the static angle is 0."""
        return begun(loop, self.pressure, self.angle, self.virgin)


def begun(loop: HysteresisLaw, pressure: Number, angle: Number, virgin: bool) -> State:
    """A wrist at rest at a pressure [kPa] and an angle [deg], on the virgin curve or between the branches."""
    memory = loop.initial() if virgin else loop.resting("inside", angle, pressure)
    return State(pressure, memory, angle)


def first_begin(recording: Recording, rest_pressure: float) -> Begin:
    """The start that the first rows of a recording show.

    Where a channel was not logged the wrist's rest stands in for it.  A wrist at
    rest in both is taken to be on the virgin curve.
    """
    pressure = rest_pressure if recording.pressure is None else float(np.median(recording.pressure[:3]))
    angle = 0.0 if recording.angle is None else float(np.median(recording.angle[:3]))
    return Begin(pressure, angle, at_rest(recording, rest_pressure))


def like_fitted(recording: Recording, rest_pressure: float, fitted: Sequence[Begin]) -> Begin:
    """The start that the first rows of a held-out recording show, on the virgin curve or not as recordings to
    fit on are that start there: `fitted`, of which that was estimated."""
    own = first_begin(recording, rest_pressure)
    pressure, angle = NEAR
    same = [
        b.virgin
        for b in fitted
        if abs(b.pressure - own.pressure) < pressure and abs(b.angle - own.angle) < angle
    ]
    return replace(own, virgin=2 * sum(same) >= len(same)) if same else own


def at_rest(recording: Recording, rest_pressure: float) -> bool:
    """Whether the first rows of a recording look like a wrist that rests at its rest pressure."""
    off = 0.0 if recording.pressure is None else float(np.median(recording.pressure[:3])) - rest_pressure
    angle = 0.0 if recording.angle is None else float(np.median(recording.angle[:3]))
    return abs(off) < NEAR[0] and abs(angle) < NEAR[1]


def measured(recording: Recording, channel: str) -> Array | None:
    """A measured channel of a recording by its column name, None where it was not logged."""
    return recording.pressure if channel == "pressure_kPa" else recording.angle
