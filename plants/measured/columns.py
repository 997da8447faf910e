"""From a file's own column names and units to the standard ones."""

from collections.abc import Mapping
from math import isfinite
from typing import Any, NamedTuple

from plants.errors import InputError
from plants.measured.cells import shorten

STANDARD = ("time_s", "command_V", "angle_deg", "pressure_kPa", "reference_deg", "other_pressure_kPa")
"""The names of the columns that a recording knows; the unit is in the name."""


class Source(NamedTuple):
    """Where a standard column comes from: value = scale * raw + offset, raw being the column `name`."""

    name: str
    scale: float = 1.0
    offset: float = 0.0


def parse_columns(entries: Any, where: str) -> dict[str, Source]:
    """A ``[columns]`` table, checked: standard names to the file's names, with scale and offset.

    where: the beginning of an error, such as the file that holds the table.
    Raises InputError for a name that is not standard and for an entry that makes no sense.

    >>> parse_columns({"angle_deg": {"name": "theta", "scale": 57.29578}}, "campaign.toml")
    {'angle_deg': Source(name='theta', scale=57.29578, offset=0.0)}
    """
    if entries is None:
        return {}
    if not isinstance(entries, Mapping):
        raise InputError(f'{where}: columns must be a table such as [columns] time_s = "Time"')
    unknown = [k for k in entries if k not in STANDARD]
    if unknown:
        raise InputError(
            f"{where}: unknown column {unknown[0]!r} in [columns]; known are {shorten(STANDARD)}"
        )
    return {name: _source(f"{where}: [columns] {name}", entry) for name, entry in entries.items()}


def _source(where: str, entry: Any) -> Source:
    if isinstance(entry, str):
        return Source(entry)
    if not isinstance(entry, Mapping) or not isinstance(entry.get("name"), str):
        raise InputError(f'{where}: must be "NAME" or {{name = "NAME", scale = 1.0, offset = 0.0}}')
    unknown = [k for k in entry if k not in Source._fields]
    if unknown:
        raise InputError(f"{where}: unknown key {unknown[0]!r}; known are {shorten(Source._fields)}")
    for key in ("scale", "offset"):
        value = entry.get(key, 1.0)
        if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
            raise InputError(f"{where}: {key} {value!r} is not a finite number")
    source = Source(entry["name"], float(entry.get("scale", 1.0)), float(entry.get("offset", 0.0)))
    if source.scale == 0.0:
        raise InputError(f"{where}: scale must not be 0, which would erase the column")
    return source
