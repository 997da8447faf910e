"""A log on one time axis, and where it is cut into runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plants.errors import InputError
from plants.measured.campaigns.decimation import mean_held
from plants.measured.campaigns.read_table import FEW_GAPS, SHORT_GAP
from plants.measured.fitting.noise import in_steps
from plants.measured.formats.channel import GAP, Array, LoggedChannel
from plants.measured.importing.channels import Log
from plants.measured.importing.roles import Role
from plants.measured.instrument.missing import FILLED

REST = 2.0
"""Time [s] for which the command stands at where it began, that a run may end there."""

LONGER = 1.5
"""How much longer a rest has to be than those at other values."""

AT_END = 0.1
"""Share of the command's range within which a value is at an end of it."""

SHORTEST, FEWEST = 3.0, 100
"""Length [s] and rows that a run has to have."""

Rows = NDArray[np.bool_]

AS_CLOSE = 1.02
"""Rows are as close as the samples of a channel where their distances differ by no more than this factor."""


@dataclass(frozen=True)
class Run:
    """A part of a log without a gap: name; time [s] from its beginning, (n,); the channels by name, (n,), in
    the units of the file, not a number where the file has an empty cell; why it ends where it does."""

    name: str
    time: Array
    values: Mapping[str, Array]
    ends: str


def runs(log: Log, found: Mapping[str, Role], step: float, alone: bool) -> list[Run]:
    """The runs of a log: cut at gaps, and where the command rests at the value that it began with.

    step [s]: sample time of the campaign; alone: whether there is no other log, so that a rest amid the range
    of the command ends a run too.  Of what begins there nobody knows what the rig remembers.
    Raises InputError for channels that were not logged at the same time, and where no run is long enough.
    """
    named = {c.name: c for c in log.channels}
    mapped = [named[n] for r in found.values() for n in r.channels]
    time = _axis(mapped, named[_base(found)], step)
    if len(time) < FEWEST:
        raise InputError(f"{log.path}: command and what is measured were not logged together for long enough")
    command = found["command"].channel
    # What a computer holds between its samples; what is measured goes on in between.
    ways = {"command": _mean, "reference": _held}
    held = {found[role].channel: way for role, way in ways.items() if role in found}
    lines = {
        c.name: held.get(c.name, _between)(c, time)
        for c in log.channels
        if c in mapped or (c.time[0] <= time[0] and c.time[-1] >= time[-1])
    }
    empty = {c.name: _empty(c, time) for c in mapped if c.name not in held}
    empty = {n: lacking | _in_gaps(named[n], time) for n, lacking in empty.items()}
    cuts = _gaps(mapped, time, empty) + _rests(lines[command], time, alone)
    made = []
    edges = [(0, ""), *sorted(cuts), (len(time), "the log ends")]
    for (first, _), (last, why) in pairwise(edges):
        asked = lines[command][first:last]
        if last - first < FEWEST or time[last - 1] - time[first] < SHORTEST or not np.ptp(asked):
            continue
        part = {n: v[first:last] for n, v in lines.items()}
        for n, lacking in empty.items():
            if np.sum(~lacking[first:last]) >= FILLED:
                part[n] = np.where(lacking[first:last], np.nan, part[n])
        made.append(Run("", time[first:last] - time[first], part, why))
    if not made:
        raise InputError(
            f"{log.path}: no run of {SHORTEST:g} s and {FEWEST} rows in which the command moves; log more"
        )
    return made


def _base(found: Mapping[str, Role]) -> str:
    """The channel whose samples are the rows: that which the model is to follow."""
    return found.get("angle", found.get("pressure", found["command"])).channel


def steps_of(log: Log, found: Mapping[str, Role]) -> float:
    """Sample time [s] of the channel whose samples are the rows."""
    return next(c.step for c in log.channels if c.name == _base(found))


def _axis(mapped: Sequence[LoggedChannel], base: LoggedChannel, step: float) -> Array:
    """Times [s] at which all channels are there: the samples of one, or evenly spaced where these are not
    those of the campaign.  Where its cells are empty in some rows of a table, the rows are those of the
    channel of that table that has the most."""
    first, last = max(c.time[0] for c in mapped), min(c.time[-1] for c in mapped)
    same = (c for c in mapped if abs(c.step - base.step) <= 0.02 * base.step and np.all(_in(base.time, c)))
    base = max(same, key=lambda c: len(c.time))
    own = base.time[(base.time >= first) & (base.time <= last)]
    if len(own) > 1 and abs(base.step - step) <= 0.02 * step:
        return np.array(own)
    even: Array = np.arange(first, last + 0.5 * step, step, dtype=np.float64)
    return even


def _between(channel: LoggedChannel, time: Array) -> Array:
    """Values of a channel at some times, between its own on the line through them, in steps of its sensor."""
    found: Array = np.interp(time, channel.time, channel.values)
    known = channel.values[np.isfinite(channel.values)]
    own = np.isin(time, channel.time)
    return np.where(own, found, in_steps(found, known)) if known.size else found


def _held(channel: LoggedChannel, time: Array) -> Array:
    """Values of a channel at some times, each the last before it."""
    at = np.searchsorted(channel.time, time * (1.0 + 1e-12) + 1e-9, side="right") - 1
    found: Array = channel.values[np.maximum(at, 0)]
    return found


def _mean(channel: LoggedChannel, time: Array) -> Array:
    """Mean of a channel that holds its values, from each of some times to the next; its value where its own
    samples are no closer.  A row is short against a regulator's time constant, so that the mean acts as the
    command does; the value that it has at the row would be late or early."""
    lasts = np.diff(time, append=2.0 * time[-1] - time[-2])
    if float(np.median(lasts)) < AS_CLOSE * channel.step:
        return _held(channel, time)
    return mean_held(channel.time, channel.values, np.append(time, time[-1] + lasts[-1]))


def _in(time: Array, channel: LoggedChannel) -> Rows:
    """At which times [s] a channel was logged, to the digit."""
    found: Rows = np.isin(time, channel.time)
    return found


def _empty(channel: LoggedChannel, time: Array) -> Rows:
    """Rows in which a channel of the same table has an empty cell; none for one that was logged apart."""
    within = channel.time[(channel.time >= time[0]) & (channel.time <= time[-1])]
    there = _in(time, channel)
    return ~there if there.sum() == len(within) else np.zeros(len(time), bool)


def _in_gaps(channel: LoggedChannel, time: Array) -> Rows:
    """Rows between two samples of a channel that are a gap apart, where there is nothing to draw a line
    through."""
    after = np.clip(np.searchsorted(channel.time, time, side="left"), 1, len(channel.time) - 1)
    apart = np.diff(channel.time)[after - 1] > GAP * channel.step
    there = np.isclose(channel.time[after], time, rtol=0.0, atol=1e-9) | (time <= channel.time[0] + 1e-9)
    lacking: Rows = apart & ~there
    return lacking


def _gaps(mapped: Sequence[LoggedChannel], time: Array, empty: Mapping[str, Rows]) -> list[tuple[int, str]]:
    """Rows before which a channel was not logged for a while.  Short gaps are left where they are few, and
    empty cells of a table too: the reader of campaigns bridges them."""
    found = []
    for c in [*mapped, LoggedChannel("the time", "", time, time)]:
        distances = np.diff(c.time)
        gaps = np.flatnonzero(distances > max(GAP * c.step, 1e-9))
        cells = c.name in empty and empty[c.name].any()
        short = cells or len(gaps) <= FEW_GAPS * len(distances)
        for i in gaps[distances[gaps] > (SHORT_GAP if short else GAP) * c.step]:
            row = int(np.searchsorted(time, c.time[i + 1] - 1e-9))
            if 0 < row < len(time):
                found.append((row, f"{c.name} was not logged for {distances[i]:.3g} s"))
    return found


def _rests(command: Array, time: Array, amid: bool) -> list[tuple[int, str]]:
    """Rows within the rests of the command at the value that it began with: the next run begins there, with
    half of the rest before it.  Treads of a staircase are rests too: one at home is no longer than others.
    amid: whether that value may be amid the range."""
    to_end = min(command[0] - np.min(command), np.max(command) - command[0])
    if to_end > AT_END * np.ptp(command) and not amid:
        return []
    near = np.abs(np.diff(command)) <= 1e-3 * np.ptp(command)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], near.astype(np.int8), [0]])))
    spans = [
        (int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True) if time[b] - time[a] >= 0.5
    ]
    home = [s for s in spans if np.all(np.abs(command[s[0] : s[1]] - command[0]) <= 0.01 * np.ptp(command))]
    away = [time[b] - time[a] for a, b in spans if (a, b) not in home]
    least = max(REST, LONGER * float(np.median(away)) if away else 0.0)
    return [
        ((a + b) // 2, "the command rests where it began")
        for a, b in home
        if a > 0 and b < len(time) - 1 and time[b] - time[a] >= least
    ]
