"""A recording: what was commanded and what was measured, in standard units."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from plants.rig import Zero

Array = NDArray[np.float64]

Stage = Literal["wrist", "regulator"]

HELD = 0.6
"""Share of rows with a value of their own below which a channel is held between renewals."""


@dataclass(frozen=True)
class Recording:
    """One run of the rig; arrays of shape (n,), None for a channel that was not logged.

    name: the file; time [s], strictly increasing; command [V]; angle [deg];
    pressure [kPa]; reference [deg], there where the loop was closed;
    other_pressure [kPa] of the other motion; extra: any further numeric channel
    by its column name, in the unit of the file.  judged_from [s]: time from which its
    error counts, where the rows before were fitted on.  renewed: rows at which a channel was renewed, of
    those that the logger holds in between, or leaves empty; there the values are straight lines.  mended:
    how many rows the logger wrote twice (``repeated``) or in the wrong order (``swapped``), how many cells it
    left ``empty``, how many ``gaps`` its time has, and from when its ``clock`` counts [s].  ahead [s], (n,):
    how long before its row the command jumped, where a set-point changed between two rows; None for a
    command that jumps at rows.  between: whether the command is ``held`` between rows or moves ``straight``;
    None where it is not known: then held in open loop and straight in a closed one.  ranges: least
    and largest value that the sensor of a channel shows, where it saturates at one of them.

    A row holds the sensors at its time, before the command of that row acts.
    """

    name: str
    time: Array
    command: Array
    angle: Array | None = None
    pressure: Array | None = None
    reference: Array | None = None
    other_pressure: Array | None = None
    extra: Mapping[str, Array] = field(default_factory=dict)
    judged_from: float = -math.inf
    renewed: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict)
    mended: Mapping[str, float] = field(default_factory=dict)
    ahead: Array | None = None
    between: Literal["held", "straight"] | None = None
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def fresh(self, channel: str) -> NDArray[np.bool_]:
        """Rows at which a channel was renewed, (n,): all, unless its logger holds it in between."""
        return self.renewed.get(channel, np.ones(len(self.time), bool))

    def shown(self, channel: str) -> NDArray[np.bool_]:
        """Rows at which a channel was renewed and its sensor was not saturated, (n,)."""
        low, high = self.ranges.get(channel, (-math.inf, math.inf))
        values = self.channels[channel]
        return self.fresh(channel) & (values > low) & (values < high)

    def held(self, channel: str) -> bool:
        """Whether a channel was logged in some rows only."""
        return float(self.fresh(channel).mean()) < HELD

    @property
    def commanded(self) -> Literal["held", "straight"]:
        """What the command does between rows."""
        return self.between or ("held" if self.reference is None else "straight")

    @property
    def judged(self) -> NDArray[np.bool_]:
        """Which rows count when the error is reported, (n,)."""
        return self.time >= self.judged_from

    @property
    def channels(self) -> dict[str, Array]:
        """What was logged beside the time, by standard name or, of further channels, by column."""
        own = {
            "command_V": self.command,
            "angle_deg": self.angle,
            "pressure_kPa": self.pressure,
            "reference_deg": self.reference,
            "other_pressure_kPa": self.other_pressure,
        }
        return {**self.extra, **{n: v for n, v in own.items() if v is not None}}

    def counted_from(self, zero: Zero) -> "Recording":
        """The recording with its pressure and its angles counted from what is zero for the rig's plants."""

        def counted(values: Array | None, by: float, sign: float = 1.0) -> Array | None:
            return values if values is None or (by, sign) == (0.0, 1.0) else sign * (values - by)

        way = -1.0 if zero.reversed else 1.0
        first, last = sorted(way * (end - zero.angle) for end in self.ranges.get("angle_deg", (0.0, 0.0)))
        return replace(
            self, pressure=counted(self.pressure, zero.pressure), angle=counted(self.angle, zero.angle, way),
            reference=counted(self.reference, zero.angle, way),
            ranges={"angle_deg": (first, last)} if self.ranges else {},
        )  # fmt: skip

    def until(self, time: float) -> "Recording":
        """The recording up to a time [s]."""
        kept = self.time < time
        arrays: dict[str, Any] = {n: v[kept] for n, v in vars(self).items() if isinstance(v, np.ndarray)}
        extra = {n: v[kept] for n, v in self.extra.items()}
        return replace(self, **arrays, extra=extra, renewed={n: v[kept] for n, v in self.renewed.items()})
