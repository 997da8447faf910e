"""A recording: what was commanded and what was measured, checked, in standard units."""

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from plants.errors import InputError, InputWarning
from plants.measured.formats.cells import Array, Text, first_bad, shorten
from plants.measured.formats.columns import STANDARD, Source, turned
from plants.measured.formats.tables import Table
from plants.measured.instrument.rows import mended
from plants.rig import Rig, Zero

Stage = Literal["wrist", "regulator"]

GAP = 2.5
"""Steps longer than this many sample times are gaps; loggers jitter and may skip one row."""

SAMPLE_TIME_TOLERANCE = 0.05
"""How far the median step may be from the declared sample time, as a part of it."""

RADIANS = 1.2
"""An angle [deg] that stays within this while the wrist is worked over half its range is in radians."""


@dataclass(frozen=True)
class Recording:
    """One run of the rig; arrays of shape (n,), None for a channel that was not logged.

    name: the file; time [s], strictly increasing; command [V]; angle [deg];
    pressure [kPa]; reference [deg], there where the loop was closed;
    other_pressure [kPa] of the other motion; extra: any further numeric channel
    by its column name, in the unit of the file.  judged_from [s]: time from which its
    error counts, where the rows before were fitted on.  renewed: rows at which a channel was renewed, of
    those that the logger holds in between; there the values are straight lines.  mended: how many rows the
    logger wrote twice (``repeated``) or in the wrong order (``swapped``).

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
    mended: Mapping[str, int] = field(default_factory=dict)

    def fresh(self, channel: str) -> NDArray[np.bool_]:
        """Rows at which a channel was renewed, (n,): all, unless its logger holds it in between."""
        return self.renewed.get(channel, np.ones(len(self.time), bool))

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

        def less(values: Array | None, by: float) -> Array | None:
            return values if values is None or by == 0.0 else values - by

        return replace(
            self, pressure=less(self.pressure, zero.pressure), angle=less(self.angle, zero.angle),
            reference=less(self.reference, zero.angle),
        )  # fmt: skip

    def until(self, time: float) -> "Recording":
        """The recording up to a time [s]."""
        kept = self.time < time
        arrays: dict[str, Any] = {n: v[kept] for n, v in vars(self).items() if isinstance(v, np.ndarray)}
        extra = {n: v[kept] for n, v in self.extra.items()}
        return replace(self, **arrays, extra=extra, renewed={n: v[kept] for n, v in self.renewed.items()})


def from_table(
    table: Table,
    sources: Mapping[str, Source] | None = None,
    stage: Stage = "wrist",
    sample_time: float | None = None,
    name: str | None = None,
    rig: Rig | None = None,
) -> Recording:
    """The recording in a table whose columns `sources` maps to the standard names.

    sample_time [s]: what the steps of the time are compared with; None to take the file's own.
    rig: whose ranges the channels are held against, and whose zero they are counted from; None where it is
    not known.
    Raises InputError, in one line with file, row and column, for a column that
    is missing, cells that are no finite numbers, and a time that repeats, runs
    backwards (beyond what `plants.measured.instrument.rows` mends), has gaps or another
    sample time.  Warns, with InputWarning, of a command outside its range, an angle in radians, and of
    columns it drops.
    """
    sources = _sources(table, sources or {}, stage)
    table, counts = mended(table, sources["time_s"].name)
    found = {standard: _standard(table, standard, source) for standard, source in sources.items()}
    time, column = found["time_s"], sources["time_s"].name
    _check_lengths(table, sources, found)
    _check_time(table, column, time, sample_time)
    if rig is not None:
        _warn_of_command(table, sources["command_V"].name, found["command_V"], rig)
    if rig is not None and "angle_deg" in found:
        _warn_of_radians(table, sources["angle_deg"].name, found, rig)
    recording = Recording(
        name or table.path.name,
        time,
        found["command_V"],
        found.get("angle_deg"),
        found.get("pressure_kPa"),
        found.get("reference_deg"),
        found.get("other_pressure_kPa"),
        _extra(table, {s.name for s in sources.values()}, len(time)),
        mended=counts,
    )
    return recording if rig is None else recording.counted_from(rig.zero)


def required(stage: Stage) -> tuple[str, ...]:
    """The standard columns that a recording of a stage cannot do without."""
    return ("time_s", "command_V", "pressure_kPa" if stage == "regulator" else "angle_deg")


def _sources(table: Table, mapped: Mapping[str, Source], stage: Stage) -> dict[str, Source]:
    """The sources of all columns that are there: mapped, or by their standard name."""
    own = {name: Source(name) for name in STANDARD if name in table.columns and name not in mapped}
    note = f"; {table.note}" if table.note else ""
    for name, source in mapped.items():
        if source.name not in table.columns:
            raise InputError(
                f"{table.path}: no column {source.name!r}, to which [columns] maps {name}; "
                f"the file has {shorten(list(table.columns))}{note}"
            )
    for name in required(stage):
        if name not in own and name not in mapped:
            advice = "name it in [columns]"
            if name == "angle_deg":
                advice += ', or set stage = "regulator" if only the pressure was measured'
            has = shorten(list(table.columns))
            raise InputError(f"{table.path}: no column {name!r}; the file has {has}; {advice}{note}")
    return {name: mapped.get(name) or own[name] for name in STANDARD if name in mapped or name in own}


def _standard(table: Table, standard: str, source: Source) -> Array:
    """A column in its standard unit; an error names the first cell that is no finite number."""
    if source.quaternion:
        parts = [_standard(table, standard, Source(n)) for n in source.quaternion if n in table.columns]
        if len(parts) < len(source.quaternion):
            raise InputError(f"{table.path}: lacks a column of the quaternion {shorten(source.quaternion)}")
        return turned(*parts)
    column = table.columns[source.name]
    bad = first_bad(column)
    if bad is not None:
        i, problem = bad
        where = f"{table.path}: row {table.row(i)}, column {source.name!r}"
        raise InputError(f"{where}: {problem}; correct it or cut the recording there")
    assert not isinstance(column, Text), "text has a cell that is no number"
    return column if source == Source(source.name) else source.scale * column + source.offset


def _check_lengths(table: Table, sources: Mapping[str, Source], found: Mapping[str, Array]) -> None:
    count = len(found["time_s"])
    for name, values in found.items():
        if len(values) != count:
            raise InputError(
                f"{table.path}: column {sources[name].name!r} has {len(values)} values but the time "
                f"{sources['time_s'].name!r} has {count}; choose columns that were logged together"
            )
    if count < 2:
        rows = "no rows" if count == 0 else "only 1 row"
        raise InputError(f"{table.path}: has {rows}; a recording needs at least 2")


def _check_time(table: Table, column: str, time: Array, sample_time: float | None) -> None:
    steps = np.diff(time)

    def where(i: int) -> str:
        return f"{table.path}: row {table.row(i + 1)}, column {column!r}"

    back = np.flatnonzero(steps <= 0.0)
    if back.size:
        i = int(back[0])
        does = "repeats" if steps[i] == 0.0 else f"runs backwards, from {time[i]:.10g}"
        raise InputError(f"{where(i)}: time {time[i + 1]:.10g} s {does}; it must increase from row to row")
    median = float(np.median(steps))
    expected = median if sample_time is None else sample_time
    if abs(median - expected) > SAMPLE_TIME_TOLERANCE * expected:
        advice = "correct sample_time_s"
        if abs(median - 1000.0 * expected) <= SAMPLE_TIME_TOLERANCE * 1000.0 * expected:
            advice = "the time looks like milliseconds; map it with scale = 0.001"
        raise InputError(
            f"{table.path}: column {column!r}: the median step is {median:.4g} s but "
            f"sample_time_s is {expected:.4g}; {advice}"
        )
    gaps = np.flatnonzero(steps > GAP * expected)
    if gaps.size:
        i = int(gaps[0])
        raise InputError(
            f"{where(i)}: gap of {steps[i]:.4g} s after {time[i]:.10g} s, "
            f"the sample time being {expected:.4g} s; split the recording there"
        )


def _warn_of_command(table: Table, column: str, command: Array, rig: Rig) -> None:
    low, high = rig.command_range
    outside = np.flatnonzero((command < low) | (command > high))
    if outside.size:
        i = int(outside[0])
        _warn(
            f"{table.path}: row {table.row(i)}, column {column!r}: command {command[i]:.6g} V is outside "
            f"{low:g} to {high:g} V ({outside.size} of {len(command)} rows); "
            "if its unit is not volts, map it with a scale"
        )


def _warn_of_radians(table: Table, column: str, found: Mapping[str, Array], rig: Rig) -> None:
    if rig.units.angle != "deg":
        return
    angle = found["angle_deg"]
    worked = np.ptp(found["command_V"]) > 0.5 * (rig.command_range[1] - rig.command_range[0])
    if "pressure_kPa" in found:
        worked = worked or np.ptp(found["pressure_kPa"]) > 0.5 * (
            rig.pressure_range[1] - rig.pressure_range[0]
        )
    # An angle that never moves is a dead sensor or a locked joint, in any unit.
    if worked and np.ptp(angle) > 0.0 and np.max(np.abs(angle)) < RADIANS:
        _warn(
            f"{table.path}: column {column!r}: the angle stays within {np.max(np.abs(angle)):.3g} deg, "
            "which looks like radians; map it with scale = 57.29578"
        )


def _extra(table: Table, used: set[str], rows: int) -> dict[str, Array]:
    """The numeric channels that no standard name uses; a second copy of a used one is no channel."""
    kept: dict[str, Array] = {}
    copies = [c for name, c in table.columns.items() if name in used and not isinstance(c, Text)]
    for name, column in table.columns.items():
        if name in used:
            continue
        if name in STANDARD:
            _warn(f"{table.path}: column {name!r} is ignored; [columns] maps another column to it")
            continue
        bad = first_bad(column) if isinstance(column, Text) or len(column) == rows else None
        if bad is not None:
            i, problem = bad
            _warn(f"{table.path}: row {table.row(i)}, column {name!r}: {problem}; the column is dropped")
        elif (
            not isinstance(column, Text)
            and len(column) == rows
            and not any(np.array_equal(column, c) for c in copies)
        ):
            kept[name] = column
    return kept


def _warn(message: str) -> None:
    warnings.warn(message, InputWarning, stacklevel=2)
