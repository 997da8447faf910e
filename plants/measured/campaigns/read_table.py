"""A table read as a recording: its columns found, checked, and put into standard units."""

import warnings
from collections.abc import Mapping

import numpy as np

from plants.errors import InputError, InputWarning
from plants.measured.campaigns.decimation import for_sample_time
from plants.measured.campaigns.recording import Recording, Stage
from plants.measured.formats.cells import Array, Text, first_bad, shorten
from plants.measured.formats.channel import GAP
from plants.measured.formats.columns import STANDARD, Source, axis_of, turned
from plants.measured.formats.tables import Table
from plants.measured.instrument.missing import lines_between, with_missing
from plants.measured.instrument.rows import mended
from plants.rig import Rig

SHORT_GAP, FEW_GAPS = 25.0, 0.01
"""Sample times that a gap may last, and share of the steps that may be gaps: packets that were lost."""

FAR = 1.0
"""Lengths of a recording from zero beyond which its clock counts from something else, such as 1970."""

MEASURED = ("angle_deg", "pressure_kPa", "other_pressure_kPa")
"""Channels that may lack cells."""

SAMPLE_TIME_TOLERANCE = 0.05
"""How far the median step may be from the declared sample time, as a part of it."""

RADIANS = 1.2
"""An angle [deg] that stays within this while the wrist is worked over half its range is in radians."""


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
    is missing, cells that are no finite numbers (but for those of measured channels that
    `plants.measured.instrument.missing` takes out), and a time that repeats, runs
    backwards (beyond what `plants.measured.instrument.rows` mends), has long gaps or another
    sample time.  Warns, with InputWarning, of a command outside its range, an angle in radians, and of
    columns it drops.
    """
    sources = _sources(table, sources or {}, stage)
    table, rows = mended(table, sources["time_s"].name)
    counts: dict[str, float] = dict(rows)
    found = {standard: _standard(table, standard, source) for standard, source in sources.items()}
    time, column = found["time_s"], sources["time_s"].name
    _check_lengths(table, sources, found)
    counts |= _check_time(table, column, time, sample_time)
    if abs(time[0]) > FAR * (time[-1] - time[0]):
        counts["clock"] = float(time[0])
        time = time - time[0]
    renewed = {n: np.isfinite(v) for n, v in found.items() if not np.isfinite(v).all()}
    if renewed:
        counts["empty"] = sum(int((~there).sum()) for there in renewed.values())
    for channel, there in renewed.items():
        found[channel] = lines_between(time, found[channel], there)
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
        _extra(table, {n for s in sources.values() for n in (s.name, *s.quaternion)}, len(time)),
        renewed=renewed,
        mended=counts,
    )
    if rig is None:
        return recording
    return for_sample_time(recording.counted_from(rig.zero), rig.sample_time, rig.log_time)


def required(stage: Stage) -> tuple[str, ...]:
    """The standard columns that a recording of a stage cannot do without."""
    return ("time_s", "command_V", "pressure_kPa" if stage == "regulator" else "angle_deg")


def on_one_axis(columns: Mapping[str, Source], tables: Mapping[str, Table]) -> dict[str, Source]:
    """The columns with one axis for the orientations of all recordings: that of the one that turns farthest,
    so that their angles have one sign.  Raises InputError as ``from_table``."""
    angle = columns.get("angle_deg")
    if angle is None or not angle.quaternion:
        return dict(columns)
    _, axis = max((_axis_in(t, angle) for t in tables.values()), key=lambda found: found[0])
    return {**columns, "angle_deg": angle._replace(about=axis)}


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
    """A column in its standard unit, not a number where a measured channel lacks a cell; an error names the
    first cell that is no finite number."""
    if source.quaternion:
        return _orientation(table, standard, source)
    column = table.columns[source.name]
    bad = first_bad(column)
    lacking = with_missing(column) if bad is not None and standard in MEASURED else None
    if lacking is not None:
        column = lacking
    elif bad is not None:
        i, problem = bad
        where = f"{table.path}: row {table.row(i)}, column {source.name!r}"
        raise InputError(f"{where}: {problem}; correct it or cut the recording there")
    assert not isinstance(column, Text), "text has a cell that is no number"
    return column if (source.scale, source.offset) == (1.0, 0.0) else source.scale * column + source.offset


def _orientation(table: Table, standard: str, source: Source) -> Array:
    """The angle [deg] that the columns of a quaternion have turned, not a number in rows that lack one."""
    names = source.quaternion
    where = f"{table.path}: the quaternion {shorten(names)}"
    if any(n not in table.columns for n in names):
        raise InputError(f"{table.path}: lacks a column of the quaternion {shorten(names)}")
    parts = _parts(table, standard, names)
    if len({len(p) for p in parts}) > 1:
        raise InputError(f"{where} has columns of different lengths; choose four that were logged together")
    angle = turned(*parts, about=source.about)
    if not np.isfinite(angle).all() and with_missing(angle) is None:
        row = table.row(int(np.flatnonzero(~np.isfinite(angle))[0]))
        raise InputError(f"{where} is no orientation in row {row}; correct it or cut the recording there")
    return angle


def _parts(table: Table, standard: str, names: tuple[str, ...]) -> list[Array]:
    return [_standard(table, standard, Source(n)) for n in names]


def _axis_in(table: Table, source: Source) -> tuple[float, tuple[float, ...]]:
    """How far the quaternion of a source turns in a table [deg], and about which axis (3,): 0 and none where
    the table lacks a column of it, or has them of different lengths."""
    if not source.quaternion or any(n not in table.columns for n in source.quaternion):
        return 0.0, ()
    parts = _parts(table, "angle_deg", source.quaternion)
    return axis_of(*parts) if len({len(p) for p in parts}) == 1 else (0.0, ())


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


def _check_time(table: Table, column: str, time: Array, sample_time: float | None) -> dict[str, int]:
    """How many short ``gaps`` the time has, if any.  Raises InputError for anything worse."""
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
    longer = gaps[steps[gaps] > SHORT_GAP * expected]
    if longer.size or gaps.size > FEW_GAPS * steps.size:
        i = int(longer[0] if longer.size else gaps[0])
        raise InputError(
            f"{where(i)}: gap of {steps[i]:.4g} s after {time[i]:.10g} s, "
            f"the sample time being {expected:.4g} s; split the recording there"
        )
    return {"gaps": int(gaps.size)} if gaps.size else {}


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
