"""What a campaign.toml says of its logger: the table ``[logger]``."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from plants.errors import InputError
from plants.measured.formats.cells import shorten
from plants.toml import is_number

DELAYS = {"angle_delay_s": "angle_deg", "pressure_delay_s": "pressure_kPa"}
OFFSETS = {"angle_offset_deg": "angle_deg", "pressure_offset_kPa": "pressure_kPa"}
HELD = {"angle_renewed_s": "angle_deg", "pressure_renewed_s": "pressure_kPa"}
RANGES = {"angle_range_deg": "angle_deg"}


@dataclass(frozen=True)
class StatedHabits:
    """What the user says that the logger does.

    delays: by how much a channel is logged late [s]; offsets: how far its zero is off, in its unit, by file;
    renewed: every how many seconds it is renewed; ranges: least and largest value that its sensor shows.  By
    the channel's column name; what is stated is not looked for.
    """

    delays: Mapping[str, float] = field(default_factory=dict)
    offsets: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    renewed: Mapping[str, float] = field(default_factory=dict)
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)


def parse_logger(entries: Any, where: str, files: tuple[str, ...]) -> StatedHabits:
    """A ``[logger]`` table, checked; `where` begins the errors, `files` are those of the campaign.

    An offset is one number for all files, or a table of numbers by file; a range is ``[least, largest]``, of
    which one may be infinite.  Raises InputError, naming the key, for one that is unknown or wrong.

    >>> parse_logger({"angle_delay_s": 0.04}, "campaign.toml", ()).delays
    {'angle_deg': 0.04}
    """
    if entries is None:
        return StatedHabits()
    if not isinstance(entries, Mapping):
        raise InputError(f"{where}: logger must be a table such as [logger] angle_delay_s = 0.04")
    known = (*DELAYS, *OFFSETS, *HELD, *RANGES)
    unknown = [k for k in entries if k not in known]
    if unknown:
        raise InputError(f"{where}: unknown key {unknown[0]!r} in [logger]; known are {shorten(known)}")
    for key in (*DELAYS, *HELD):
        value = entries.get(key, 1.0)
        if not is_number(value) or value < 0.0 or (value == 0.0 and key in HELD):
            raise InputError(f"{where}: [logger] {key} {value!r} is no positive number of seconds")
    return StatedHabits(
        {c: float(entries[k]) for k, c in DELAYS.items() if k in entries},
        {
            c: _offsets(entries[k], f"{where}: [logger] {k}", files)
            for k, c in OFFSETS.items()
            if k in entries
        },
        {c: float(entries[k]) for k, c in HELD.items() if k in entries},
        {c: _range(entries[k], f"{where}: [logger] {k}") for k, c in RANGES.items() if k in entries},
    )


def _range(entry: Any, where: str) -> tuple[float, float]:
    ends = entry if isinstance(entry, list) and len(entry) == 2 else []
    if not ends or not all(is_number(v) or v in (-math.inf, math.inf) for v in ends) or not ends[0] < ends[1]:
        raise InputError(f"{where} must be the least and the largest value, such as [0.0, 90.0]")
    return float(ends[0]), float(ends[1])


def _offsets(entry: Any, where: str, files: tuple[str, ...]) -> dict[str, float]:
    if is_number(entry):
        return dict.fromkeys(files, float(entry))
    if not isinstance(entry, Mapping) or not all(is_number(v) for v in entry.values()):
        raise InputError(f'{where}: must be a number or a table of numbers by file, {{"run1.csv" = 0.3}}')
    stray = [n for n in entry if n not in files]
    if stray:
        raise InputError(f"{where}: {stray[0]!r} is no file of this campaign; it has {shorten(files)}")
    return {n: float(v) for n, v in entry.items()}
