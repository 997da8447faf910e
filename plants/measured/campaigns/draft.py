"""A campaign.toml to start from, for a folder that holds logs and none: what `wrist import` says of them, of
the files as they are."""

import re
import shlex
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import tomlkit

from plants.errors import InputError
from plants.measured.formats.channel import LoggedChannel
from plants.measured.formats.tables import read_table
from plants.measured.importing.channels import (
    HDF5,
    TABLES,
    TEXTS,
    Log,
    clocks_in,
    groups_of,
    log_of,
    read_log,
    safe_name,
    seconds_in,
)
from plants.measured.importing.columns_table import columns_table, in_a_line
from plants.measured.importing.excitation import choose, excited
from plants.measured.importing.roles import ROLES, Role, roles

AS_THEY_ARE = (".csv", ".tsv", ".txt", *TABLES)
"""Kinds of files of which a campaign may be made as they are."""

IMPORTED = (".mf4", ".mdf", ".tdms", ".mcap", ".bag", ".db3", *HDF5)
"""Kinds of files that hold logs for certain, and have to be imported."""


class Drafted(NamedTuple):
    """A log as a campaign would read it: its channels; the time's column, seconds in 1 of it, and step [s];
    the columns of the file by channel."""

    log: Log
    time: str
    seconds: float
    step: float
    columns: Mapping[str, str]


def draft(folder: Path) -> tuple[str, str | None]:
    """What to do about a folder that lacks a campaign.toml, and what that of its logs may look like; None
    where it has no logs, or none that can be read as they are."""
    files = sorted(p for p in folder.iterdir() if p.is_file())
    found, refused = [], {}
    for path in files:
        if path.suffix.lower() in AS_THEY_ARE:
            try:
                found.append(_read(path))
            except InputError as error:
                refused[path] = str(error)
    if found:
        return "correct the draft and save it there", _written(folder, found, refused)
    logs = [p for p in files if p.suffix.lower() in IMPORTED or _importable(p)]
    if logs:
        these = f"{shlex.quote(str(folder))}/*{logs[0].suffix}"
        return f"its logs need converting: {importing(these)}", None
    return "write one that names axis, fit and validate", None


def importing(logs: str, axis: str = "") -> str:
    """The command that makes a campaign of logs, given as a shell takes them, of a motion if it is known.

    >>> importing("logs/*.mf4"), importing("log.csv", "my finger")
    ('wrist import logs/*.mf4 --out NEW', "wrist import log.csv --axis 'my finger' --out NEW")
    """
    return f"wrist import {logs}{f' --axis {shlex.quote(axis)}' if axis else ''} --out NEW"


def _read(path: Path) -> Drafted:
    """A log as a campaign would read it.  Raises InputError for one that it would not, or without a time."""
    groups, columns = groups_of(read_table(path))
    strange = [c for c in columns.values() if not c.isprintable()]
    if strange:
        raise InputError(f"{path}: column {strange[0]!r} holds a control character; wrist import renames it")
    notes: list[str] = []
    for group in groups:
        clocks = clocks_in(group)
        if len(clocks) > 1:
            second = columns[clocks[1].name]
            raise InputError(f"{path}: column {second!r} is a second clock; wrist import reads both")
        time = clocks[0] if clocks else None
        if time is not None and len(group) > 1:
            scale = seconds_in(time, notes)
            seconds = scale * (time.values - time.values[0])
            channels = [LoggedChannel(s.name, s.unit, seconds, s.values) for s in group if s is not time]
            step = float(np.median(np.diff(seconds)))
            return Drafted(log_of(path, channels, notes), columns[time.name], scale, step, columns)
    raise InputError(f"{path}: has no column of time")


def _importable(path: Path) -> bool:
    """Whether a text or a table is a log that can be imported."""
    if path.suffix.lower() not in (*TEXTS, *TABLES):
        return False
    try:
        return bool(read_log(path).channels)
    except InputError:
        return False


def _written(folder: Path, logs: list[Drafted], refused: Mapping[Path, str]) -> str:
    fullest = max(logs, key=lambda d: len(d.log.channels))
    names = {c.name for c in fullest.log.channels}
    own = {role: (column, "") for role, column in ROLES.items() if column in names}
    document = tomlkit.document()
    document.add(tomlkit.comment("A draft, guessed from the logs as wrist import does: correct it"))
    found: dict[str, Role] = {}
    try:
        found = roles(fullest.log.channels, own)
    except InputError as error:
        document.add(tomlkit.comment(safe_name(f"{error}, or name them in [columns]")))
    wanted = {n for r in ("command", "angle" if "angle" in found else "pressure") if r in found
              for n in found[r].channels}  # fmt: skip
    kept = [d for d in logs if d.time == fullest.time and wanted <= {c.name for c in d.log.channels}]
    for line in _left_out([d for d in logs if d not in kept], refused):
        document.add(tomlkit.comment(safe_name(line)))
    document["axis"] = re.sub(r"[^A-Za-z0-9-]+", "-", folder.resolve().name).strip("-").lower() or "motion"
    if found and "angle" not in found:
        document["stage"] = "regulator"
    document["start"] = "unknown"
    document["sample_time_s"] = float(f"{max(d.step for d in kept):.4g}")
    _add_files(document, kept, found)
    table = tomlkit.table()
    if fullest.time != "time_s" or fullest.seconds != 1.0:
        time = Role(fullest.time, "s", fullest.seconds, "; ".join(fullest.log.notes))
        table["time_s"] = in_a_line(time.entry(), time.why)
    others = {r: of for r, of in found.items() if r not in own}
    for column, item in columns_table(others, fullest.columns).items():
        table[column] = item
    if table:
        document["columns"] = table
    return tomlkit.dumps(document)


def _left_out(logs: Iterable[Drafted], refused: Mapping[Path, str]) -> Iterable[str]:
    """Why some files are not in the draft."""
    for d in logs:
        yield f"{d.log.path.name} has other columns: left out; wrist import takes them together"
    for path, why in refused.items():
        yield f"{path.name} is left out: {why.removeprefix(f'{path}: ')}"


def _add_files(document: tomlkit.TOMLDocument, logs: list[Drafted], found: Mapping[str, Role]) -> None:
    """Add which logs are fitted on and which are held out, as an import would choose."""
    places = [d.log.path.name for d in logs]
    if "command" not in found:
        document["fit"] = places
        return
    asked = []
    for d in logs:
        command = next(c for c in d.log.channels if c.name == found["command"].channel)
        asked.append(excited(command.time, found["command"].factor * command.values))
    chosen = choose(asked)
    document.add(tomlkit.comment(chosen.why))
    document["fit"] = [places[i] for i in chosen.fit]
    if chosen.validate:
        document["validate"] = [places[i] for i in chosen.validate]
