"""Channels of a log of any known format."""

import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from plants.errors import InputError
from plants.measured.formats.binary.apart import apart
from plants.measured.formats.binary.bags import read_bag, read_mcap
from plants.measured.formats.binary.mdf4 import read_mdf
from plants.measured.formats.binary.tdms import read_tdms
from plants.measured.formats.cells import one_line, shorten
from plants.measured.formats.channel import GAP, Array, LoggedChannel, LoggedSeries
from plants.measured.formats.dialect import named_unit, read_text
from plants.measured.formats.tables import Table, read_table
from plants.measured.formats.units import factor, quantity
from plants.measured.importing.names import HINTS, unit_in
from plants.measured.instrument.missing import numbers_in

TEXTS = (".csv", ".tsv", ".txt", ".asc", ".dat")
HDF5 = (".h5", ".hdf5", ".hdf")
TABLES = (".mat", ".parquet", ".pq")

COUNTERS = (2.0**32, 2.0**16)
"""Numbers after which a counter of a microcontroller begins again."""

MILLISECONDS, NANOSECONDS = 0.7, 1e4
"""Steps from which a time without a unit is in ms, and from which in ns."""


class Log(NamedTuple):
    """The channels of a file, and what was taken for granted in reading it."""

    path: Path
    channels: tuple[LoggedChannel, ...]
    notes: tuple[str, ...]


def read_log(path: Path, sample_time: float | None = None) -> Log:
    """All numeric channels of a file, or of the folder of a ROS 2 bag.

    sample_time [s]: of files without a time; else a column of time is looked for.
    Raises InputError, in one line, for a file that cannot be read, is of an unknown kind, or has no time.
    """
    if not path.exists():
        raise InputError(f"{path}: no such file; give a log that exists")
    reader, groups = _reader(path)
    try:
        read = reader(path)
    except (InputError, MemoryError):
        raise
    except Exception as error:  # damaged bytes make readers raise nearly anything
        raise InputError(
            f"{path}: cannot be read ({one_line(error)[:200]}); it may be cut off: export it again"
        ) from None
    notes: list[str] = []
    channels = list(_timed(path, read, sample_time, notes)) if groups else list(read)
    return log_of(path, channels, notes)


def log_of(path: Path, channels: Iterable[LoggedChannel], notes: list[str]) -> Log:
    """A log of those channels that hold a series, without samples that are no numbers.

    Raises InputError where there are none, with what was noted of the time.
    """
    usable = [c for c in map(_clean, channels) if len(c.time) > 1]
    if not usable:
        timeless = (n for n in notes if "no time for" in n)
        empty = f"{path}: holds no series of numbers; export the log with its signals"
        raise InputError(next(timeless, empty))
    return Log(path, tuple(_named_apart(usable)), tuple(notes))


def _reader(path: Path) -> tuple[Callable[[Path], list], bool]:  # type: ignore[type-arg]
    """What reads a file, and whether it gives groups of series, which have no time yet."""
    suffix = path.suffix.lower()
    if path.is_dir() or suffix in (".bag", ".db3"):
        return (lambda p: read_bag(p.parent if suffix == ".db3" else p)), False
    if suffix in (".mf4", ".mdf"):
        return read_mdf, False
    if suffix == ".mcap":
        return read_mcap, False
    if suffix == ".tdms":
        return read_tdms, True
    if suffix in HDF5:
        return (lambda p: apart("plants.measured.formats.binary.hdf5", "read_hdf5", p)), True
    if suffix in TABLES:
        return _of_table, True
    if suffix in TEXTS:
        return (lambda p: [read_text(p)]), True
    known = (*TEXTS, *TABLES, *HDF5, ".mf4", ".mdf", ".tdms", ".mcap", ".bag", ".db3")
    raise InputError(
        f"{path}: unknown kind of file; logs are {', '.join(known)}, or the folder of a ROS 2 bag"
    )


def _of_table(path: Path) -> list[list[LoggedSeries]]:
    return groups_of(read_table(path))[0]


def groups_of(table: Table) -> tuple[list[list[LoggedSeries]], dict[str, str]]:
    """The series of a table, those of one length together, and its columns by the name of their series, from
    which a unit in brackets is taken off."""
    found: dict[int, list[LoggedSeries]] = {}
    columns: dict[str, str] = {}
    for column, cells in table.columns.items():
        values = numbers_in(cells)
        if values is None or len(values) < 2:
            continue
        name, unit = named_unit(safe_name(column))
        if name in columns or (name != column and name in table.columns):
            name = column
        columns[name] = column
        found.setdefault(len(values), []).append(LoggedSeries(name, unit, values))
    return list(found.values()), columns


def _timed(
    path: Path, groups: Iterable[list[LoggedSeries]], sample_time: float | None, notes: list[str]
) -> Iterable[LoggedChannel]:
    """LoggedSeries on their time: a column of their group, or the distance that the file tells for each."""
    without = []
    for group in groups:
        clocks = clocks_in(group)
        for s in group:
            if s.name in (c.name for c in clocks):
                continue
            own = _clock_of(s, clocks)
            if own is not None and len(own.values) == len(s.values) and not s.step:
                yield LoggedChannel(s.name, s.unit, _seconds(own, clocks[0], notes), s.values)
            elif step := s.step or sample_time:
                yield LoggedChannel(s.name, s.unit, np.arange(len(s.values), dtype=float) * step, s.values)
            else:
                without.append(s.name)
    if without and not sample_time:
        said = f"{path}: no time for {shorten(without, 5)}; give --sample-time in seconds, or log the time"
        if not notes:
            notes.append(said)


def _unit(named: LoggedSeries | LoggedChannel) -> str:
    return safe_name(named.unit) or unit_in(named.name)


def clocks_in(group: Iterable[LoggedSeries]) -> list[LoggedSeries]:
    """The series of a group that counts time, and others that count it in fewer rows: a second instrument in
    the columns of the same file, with rows of its own, which end earlier."""
    found = [s for s in map(_unwrapped, group) if _is_time(s)]
    full = [int(np.isfinite(s.values).sum()) for s in found]
    return [s for s, n in zip(found, full, strict=True) if s is found[0] or n < full[0]]


def _clock_of(series: LoggedSeries, clocks: list[LoggedSeries]) -> LoggedSeries | None:
    """The clock that a series was logged by: the shortest that ticks wherever the series has a value."""
    valued = np.isfinite(series.values)
    ticks = {i: np.isfinite(c.values) for i, c in enumerate(clocks) if len(c.values) == len(series.values)}
    own = [i for i, on in ticks.items() if not np.any(valued & ~on)]
    return clocks[min(own, key=lambda i: int(ticks[i].sum()))] if own else next(iter(clocks), None)


def _unwrapped(series: LoggedSeries) -> LoggedSeries:
    """A counter that began again from 0 as one that counts on: by 2^32 or 2^16, as ``micros()`` does, where
    the step is then one of those beside it."""
    steps = np.diff(series.values)
    back = np.flatnonzero(steps < 0.0)
    usual = float(np.median(steps)) if steps.size else 0.0
    for turn in COUNTERS:
        if back.size and usual > 0.0 and np.all(np.abs(steps[back] + turn - usual) < GAP * usual):
            added = turn * np.concatenate([[0.0], np.cumsum(steps < 0.0)])
            return series._replace(values=series.values + added)
    return series


def _is_time(series: LoggedSeries) -> bool:
    """Whether a series counts time: by its name or unit, and it never runs backwards."""
    named = re.search(HINTS["time_s"], series.name.lower()) or quantity(_unit(series)) == "time"
    steps = np.diff(series.values[np.isfinite(series.values)])
    return bool(named and steps.size and np.all(steps >= 0.0) and np.median(steps) > 0.0)


def _seconds(time: LoggedSeries, first: LoggedSeries, notes: list[str]) -> Array:
    """A column of time in seconds from the first value of the first clock of its group, of its own where the
    two begin further apart than the first one runs: they count from different moments then."""
    if time.name != first.name:
        notes.append(f"{time.name!r} is a second clock, of the columns that have values where it has")
    own, of_first = (c.values * seconds_in(c, notes) for c in (time, first))
    began = own[np.isfinite(own)][0] - of_first[np.isfinite(of_first)][0]
    apart = abs(began) > np.nanmax(of_first) - np.nanmin(of_first)
    return np.asarray(own - own[np.isfinite(own)][0] + (0.0 if apart else began))


def seconds_in(time: LoggedSeries, notes: list[str]) -> float:
    """How many seconds 1 in a column of time is; guessed from its step where it has no unit, and noted."""
    if quantity(_unit(time)) == "time":
        return factor(_unit(time), "time", time.name)
    step = float(np.nanmedian(np.diff(time.values)))
    unit = "s" if step < MILLISECONDS else "ms" if step < NANOSECONDS else "ns"
    note = f"time {time.name!r} has no unit and steps of {step:g}: taken for {unit}"
    if unit != "s" and note not in notes:
        notes.append(note)
    return factor(unit, "time", time.name)


def _clean(channel: LoggedChannel) -> LoggedChannel:
    """Without samples that are no numbers, and those whose time does not increase."""
    kept = np.isfinite(channel.values) & np.isfinite(channel.time)
    time, values = channel.time[kept], channel.values[kept]
    if len(time):
        later = np.append(True, time[1:] > np.maximum.accumulate(time)[:-1])
        time, values = time[later], values[later]
    return channel._replace(time=time, values=values)


def _named_apart(channels: list[LoggedChannel]) -> Iterable[LoggedChannel]:
    """Names in one line without control characters, numbered where two are the same."""
    seen: dict[str, int] = {}
    for c in channels:
        name = safe_name(c.name)
        seen[name] = seen.get(name, 0) + 1
        yield c._replace(name=name if seen[name] == 1 else f"{name} ({seen[name]})", unit=_unit(c))


def safe_name(text: str) -> str:
    """A name as one line of a CSV header and of a terminal can hold it.

    >>> safe_name('a\\x1b[31m"b"\\nc')
    "a [31m'b' c"
    """
    return " ".join("".join(c if c.isprintable() else " " for c in text).replace('"', "'").split())[:200]


def listed(channels: Iterable[LoggedChannel]) -> list[Mapping[str, str | float]]:
    """Name, unit, lowest and highest value, rate [Hz] and number of samples of each channel."""
    return [
        {
            "name": c.name, "unit": c.unit,
            "low": float(c.values.min()) + 0.0, "high": float(c.values.max()) + 0.0,  # no -0
            "rate_Hz": c.rate, "samples": len(c.values),
        } for c in channels
    ]  # fmt: skip
