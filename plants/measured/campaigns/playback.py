"""Playing a recording's command through wrists, and reading them where the recording has rows."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.recording import Recording
from plants.simulation.open_loop import open_loop, pressed
from plants.wrist import SAMPLE_TIME, State, Wrist

Array = NDArray[np.float64]
JUMP = 0.0125
"""A command that moves less than this share of its range from one row to the next has not jumped."""

SHARPER = 3.0
"""A jump is this many times larger than what the command moves in the rows beside it."""

SMOOTHED = 11
"""Rows over which the other motion's pressure is smoothed."""


@dataclass(frozen=True)
class Playback:
    """A recording prepared for simulation at a sample time `dt` [s]."""

    recording: Recording
    dt: float = SAMPLE_TIME

    @cached_property
    def rows(self) -> NDArray[np.int64]:
        """Index of the sample of 1 ms that each row falls on, (n,)."""
        at: NDArray[np.int64] = np.rint((self.recording.time - self.recording.time[0]) / self.dt).astype(
            np.int64
        )
        return at

    @cached_property
    def jumped(self) -> NDArray[np.bool_]:
        """Rows that a command jumped to, as with a set-point, which moves straight otherwise, (n,)."""
        v = self.recording.command
        if self.recording.commanded == "held":
            return np.zeros(len(v), bool)
        lasts = np.diff(self.rows)  # over a gap a command moves further without a jump
        size = np.abs(np.diff(v)) * (float(np.median(lasts)) / lasts)
        beside = np.maximum(np.append(0.0, size[:-1]), np.append(size[1:], 0.0))
        return np.append(False, (size > JUMP * np.ptp(v)) & (size > SHARPER * beside))

    @property
    def ahead(self) -> Array:
        """Times [s] by which jumps come ahead of their rows, zero where none is known, (n,)."""
        known = self.recording.ahead
        return np.zeros(len(self.rows)) if known is None else known

    def jumping(self, times: Array) -> "Playback":
        """The recording with other times [s] of its jumps ahead of their rows, (jumps,)."""
        ahead = np.zeros(len(self.rows))
        ahead[self.jumped] = times
        return replace(self, recording=replace(self.recording, ahead=ahead))

    @cached_property
    def commands(self) -> Array:
        """Command [V] of every sample of 1 ms.

        Held from row to row, or, where it moves straight, interpolated but for its jumps: these come at their
        rows, or as long `ahead` of them as is known.
        """
        v, rows = self.recording.command, self.rows
        samples = np.arange(rows[-1])
        row = np.searchsorted(rows, samples, side="right") - 1
        if self.recording.commanded == "held":
            return v[row]
        moved = np.diff(v)
        share = (samples - rows[row]) / (rows[row + 1] - rows[row])
        if self.jumped.any():
            # A jump within a sample counts by the share of the sample that is left.
            after = np.clip(samples + 1.0 - (rows - self.ahead / self.dt)[row + 1], 0.0, 1.0)
            share = np.where(self.jumped[row + 1], after, share)
        between: Array = v[row] + moved[row] * share
        return between

    @cached_property
    def other_pressure(self) -> Array | None:
        """Pressure of the other motion [kPa] of every sample of 1 ms, None where it was not logged.

        Smoothed over a tenth of a second, since its noise would work the hysteresis.
        """
        from scipy.signal import savgol_filter

        logged = self.recording.other_pressure
        if logged is None:
            return None
        smooth = savgol_filter(logged, SMOOTHED, 2) if len(logged) > SMOOTHED else logged
        return np.interp(np.arange(self.rows[-1]), self.rows, smooth)

    @cached_property
    def every(self) -> int:
        """Greatest number of samples of which all rows are multiples."""
        return int(np.gcd.reduce(np.diff(self.rows)))

    @cached_property
    def kept(self) -> slice | NDArray[np.int64]:
        """Which of every `every` samples, from the first on, are rows: all of them (a slice, which copies
        nothing) where rows are evenly spaced."""
        at = self.rows // self.every
        return slice(0, len(at)) if at[-1] == len(at) - 1 else at

    def play(self, wrist: Wrist, state: State | None = None) -> tuple[Array, Array]:
        """Pressure [kPa] and angle [deg] of a wrist at the recording's rows, as its logger writes them.

        Shape (n,), or (n, lanes) for a wrist with arrays as parameters.
        """
        other = self.other_pressure if wrist.effects else None
        response: Any = open_loop(wrist, self.commands, state, self.every, 1, other, self._first)
        pressure, angle = response.pressure[self.kept], response.angle[self.kept]
        return self.as_logged(pressure, "pressure_kPa"), self.as_logged(angle, "angle_deg")

    def press(self, wrist: Wrist, state: State | None = None) -> Array:
        """The pressure alone, as `play` gives it, of a wrist with effects of its regulator."""
        other = self.other_pressure if wrist.effects else None
        pressure = pressed(wrist, self.commands, state, self.every, 1, other, self._first)
        return self.as_logged(pressure[self.kept], "pressure_kPa")

    @property
    def _first(self) -> float:
        return float(self.recording.time[0])

    def as_logged(self, values: Array, channel: str) -> Array:
        """Values (n,) or (n, lanes) of a simulated channel as its logger writes them.

        They are kept in the range of the sensor, where it saturates, and straight lines are over the rows at
        which the channel was not renewed, as the recording has: no error of those is one of the simulation.

        >>> renewed = {"angle_deg": np.array([True, False, False, True])}
        >>> log = Recording("a", np.arange(4) * 0.01, np.zeros(4), angle=np.zeros(4), renewed=renewed)
        >>> Playback(log, 0.01).as_logged(np.array([0.0, 5.0, 5.0, 3.0]), "angle_deg").tolist()
        [0.0, 1.0, 2.0, 3.0]
        """
        if channel in self.recording.ranges:
            values = np.clip(values, *self.recording.ranges[channel])
        if channel not in self.recording.renewed:
            return values
        before, after, share = self._lines[channel]
        share = share if values.ndim == 1 else share[:, None]
        found: Array = values[before] + share * (values[after] - values[before])
        return found

    @cached_property
    def _lines(self) -> dict[str, tuple[NDArray[np.intp], NDArray[np.intp], Array]]:
        """Of each channel that is not renewed in all rows: the rows between which the straight line of a row
        is, and how far along it the row is, (n,) each."""
        time, found = self.recording.time, {}
        for channel, fresh in self.recording.renewed.items():
            own = np.flatnonzero(fresh)
            place = np.searchsorted(own, np.arange(len(time)), side="right")
            before, after = own[np.maximum(place - 1, 0)], own[np.minimum(place, len(own) - 1)]
            lasts = time[after] - time[before]
            share = np.divide(time - time[before], lasts, out=np.zeros(len(time)), where=lasts > 0.0)
            found[channel] = before, after, np.clip(share, 0.0, 1.0)
        return found
