"""Where recordings start, and what was measured in them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plants.hysteresis import HysteresisLaw
from plants.measured.campaigns.recording import Recording
from plants.rig import Rig
from plants.wrist import State

Array = NDArray[np.float64]
Number = Any
NEAR = 5.0, 1.0
"""Pressures [kPa] and angles [deg] closer together than this are those of the same rest; of a rig in other
units, such a share of its range and its step (`plants.rig.Rig.scaled`)."""


@dataclass(frozen=True)
class Begin:
    """Where a recording starts that does not start at rest: pressure [kPa], angle [deg], and
    whether the wrist is still on its virgin curve, which begins at an angle `rest` [deg]; how far the other
    motion's pressure is from its rest, `other` [kPa]."""

    pressure: float
    angle: float
    virgin: bool
    rest: float = 0.0
    other: float = 0.0

    @property
    def at_zero(self) -> bool:
        """Whether it starts on the virgin curve of a wrist that rests at an angle of 0."""
        return self.virgin and not self.rest

    def on_virgin_curve(self, loop: HysteresisLaw) -> bool:
        """Whether it starts on the virgin curve of a loop, which not every law has from any angle."""
        return self.virgin and loop.unmoved(self.rest) is not None

    def state(self, loop: HysteresisLaw) -> State:
        """The state of a wrist with a loop: on its virgin curve or between the branches."""
        if self.on_virgin_curve(loop):
            return State(self.pressure, loop.unmoved(self.rest), self.angle)
        return State(self.pressure, loop.resting("inside", self.angle, self.pressure), self.angle)


def without_shift(begin: Begin, shift: Number, rest_pressure: float, rig: Rig) -> Begin:
    """The start that a recording would show if the other motion did not shift the angle, by `shift` [deg]: a
    wrist at rest that it moved away from there is on its virgin curve."""
    off = 0.0 if rig.zero.rest else begin.pressure - rest_pressure
    angle, zero = begin.angle - shift, rig.zero.rest
    # Of one that looks at rest as it is, whether it is on that curve was decided without the shift.
    away = not _near(off, float(np.median(begin.angle)) - zero, rig)
    rests = away and _near(off, float(np.median(angle)) - zero, rig)
    return replace(begin, angle=angle, virgin=begin.virgin or rests)


def first_rows(recording: Recording, rest_pressure: float = 0.0) -> tuple[float, float]:
    """Pressure [kPa] and angle [deg] in the first rows of a recording; where a channel was not logged the
    rest stands in for it."""
    pressure = rest_pressure if recording.pressure is None else float(np.median(recording.pressure[:3]))
    return pressure, 0.0 if recording.angle is None else float(np.median(recording.angle[:3]))


def rows_before_move(recording: Recording, by: float = 0.0) -> int:
    """Rows of a recording before its command has moved by more than `by` [V]; all where it never does.

    >>> rows_before_move(Recording("one", np.arange(4.0), np.array([2.0, 2.0, 2.5, 2.0])))
    2
    """
    moved = np.abs(recording.command - recording.command[0]) > by
    return int(np.argmax(moved)) if moved.any() else len(recording.time)


def first_begin(recording: Recording, rest_pressure: float, rig: Rig) -> Begin:
    """The start that the first rows of a recording show; a wrist at rest is taken to be on the virgin
    curve."""
    own, beside = first_rows(recording, rest_pressure), recording.other_pressure
    other = 0.0 if beside is None else float(np.median(beside[:3])) - rig.rest_pressure
    return Begin(*own, at_rest(recording, rest_pressure, rig), rig.zero.rest, other)


def like_fitted(recording: Recording, rest_pressure: float, rig: Rig, fitted: Sequence[Begin]) -> Begin:
    """The start that the first rows of a held-out recording show, on the virgin curve or not as recordings to
    fit on are that start there: `fitted`, of which that was estimated."""
    own = first_begin(recording, rest_pressure, rig)
    same = [b.virgin for b in fitted if _near(b.pressure - own.pressure, b.angle - own.angle, rig)]
    return replace(own, virgin=2 * sum(same) >= len(same)) if same else own


def same_places(begins: Sequence[Begin], rig: Rig) -> tuple[tuple[int, ...], ...]:
    """Indices of starts that are near each other, place by place: each belongs to the first it is near."""
    found: list[list[int]] = []
    for i, begin in enumerate(begins):
        for group in found:
            first = begins[group[0]]
            if _near(begin.pressure - first.pressure, begin.angle - first.angle, rig):
                group.append(i)
                break
        else:
            found.append([i])
    return tuple(map(tuple, found))


def at_rest(recording: Recording, rest_pressure: float, rig: Rig) -> bool:
    """Whether the first rows of a recording look like a wrist that rests at its rest pressure; of one that
    rests elsewhere than at an angle of 0, the angle alone tells."""
    pressure, angle = first_rows(recording, rest_pressure)
    from_rest = 0.0 if rig.zero.rest else pressure - rest_pressure
    return _near(from_rest, angle - rig.zero.rest, rig)


def _near(pressure: float, angle: float, rig: Rig) -> bool:
    """Whether differences of pressure [kPa] and angle [deg] are within the same rest."""
    return abs(pressure) < rig.scaled(NEAR[0], "kPa") and abs(angle) < rig.scaled(NEAR[1], "deg")


def measured(recording: Recording, channel: str) -> Array | None:
    """A measured channel of a recording by its column name, None where it was not logged."""
    return recording.pressure if channel == "pressure_kPa" else recording.angle
