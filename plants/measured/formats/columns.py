"""From a file's own column names and units to the standard ones."""

from collections.abc import Mapping
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from plants.errors import InputError
from plants.measured.formats.cells import Array, shorten
from plants.measured.formats.units import KINDS, SUCH, factor, kept

STANDARD = ("time_s", "command_V", "angle_deg", "pressure_kPa", "reference_deg", "other_pressure_kPa")
"""The names of the columns that a recording knows; the unit is in the name."""


ROLES = {"time_s": "time", "command_V": "command", "angle_deg": "angle", "reference_deg": "reference"}
"""What is measured in a column, which tells its units; any other is a pressure."""

ATMOSPHERE = 101.325
"""Standard atmosphere [kPa]: what an absolute pressure is counted from."""

VACUUM = 0.1
"""Share of the deepest pressure below the air's by which a vacuum's may lie above."""


class Source(NamedTuple):
    """Where a standard column comes from: value = scale * raw + offset, raw being the column `name`, or,
    where there is a `quaternion` (four columns w, x, y, z), the angle [deg] by which it has turned since the
    first row, about the axis about which it turns most.  unit: in which it stays, "" for the standard one;
    about: an axis on whose side that of a quaternion is."""

    name: str
    scale: float = 1.0
    offset: float = 0.0
    quaternion: tuple[str, ...] = ()
    unit: str = ""
    about: tuple[float, ...] = ()


def parse_columns(entries: Any, where: str) -> dict[str, Source]:
    """A ``[columns]`` table, checked: standard names to the file's names, with scale and offset.

    where: the beginning of an error, such as the file that holds the table.
    Raises InputError for a name that is not standard and for an entry that makes no sense.

    >>> parse_columns({"angle_deg": {"name": "theta", "scale": 57.29578}}, "campaign.toml")
    {'angle_deg': Source(name='theta', scale=57.29578, offset=0.0, quaternion=(), unit='', about=())}
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
    return {
        name: _source(f"{where}: [columns] {name}", entry, ROLES.get(name, "pressure"))
        for name, entry in entries.items()
    }


def _source(where: str, entry: Any, role: str) -> Source:
    if isinstance(entry, str):
        return Source(entry)
    if isinstance(entry, Mapping) and "quaternion" in entry:
        return _turned(where, entry)
    if not isinstance(entry, Mapping) or not isinstance(entry.get("name"), str):
        raise InputError(f'{where}: must be "NAME" or {{name = "NAME", scale = 1.0, offset = 0.0}}')
    unknown = [k for k in entry if k not in KEYS]
    if unknown:
        raise InputError(f"{where}: unknown key {unknown[0]!r}; known are {shorten(KEYS)}")
    if set(entry) & {"unit", "absolute", "counts", "full"}:
        return _converted(where, entry, role)
    for key in ("scale", "offset"):
        value = entry.get(key, 1.0)
        if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
            raise InputError(f"{where}: {key} {value!r} is not a finite number")
    source = Source(entry["name"], float(entry.get("scale", 1.0)), float(entry.get("offset", 0.0)))
    if source.scale == 0.0:
        raise InputError(f"{where}: scale must not be 0, which would erase the column")
    return source


KEYS = ("name", "scale", "offset", "unit", "absolute", "counts", "full")
"""Keys of an entry of ``[columns]``."""


def _converted(where: str, entry: Mapping[str, Any], role: str) -> Source:
    """An entry with a unit (`absolute` for pressures above vacuum) or in counts of a converter whose `counts`
    stand for `full` of the standard unit."""
    if "scale" in entry or "offset" in entry:
        raise InputError(f"{where}: scale and offset do not go with unit or counts; give one or the other")
    if "counts" in entry or "full" in entry:
        counts, full = (_positive(where, entry, n) for n in ("counts", "full"))
        return Source(entry["name"], full / counts)
    absolute = entry.get("absolute", False)
    if not isinstance(absolute, bool) or (absolute and role != "pressure"):
        raise InputError(f"{where}: absolute = true is for pressures; leave it out")
    unit = entry.get("unit", KINDS[role])
    if not isinstance(unit, str):
        raise InputError(f"{where}: unit {unit!r} is no text; give one such as {SUCH[role]}")
    scale, offset = factor(unit, role, where), -ATMOSPHERE if absolute else 0.0
    return Source(entry["name"], scale, offset, unit=kept(unit, role))


def _turned(where: str, entry: Mapping[str, Any]) -> Source:
    names = entry["quaternion"]
    if (
        len(entry) > 1
        or not isinstance(names, list)
        or len(names) != 4
        or not all(isinstance(n, str) for n in names)
    ):
        raise InputError(f'{where}: must be {{quaternion = ["w", "x", "y", "z"]}}, four columns')
    return Source(names[0], quaternion=tuple(names))


def _positive(where: str, entry: Mapping[str, Any], key: str) -> float:
    value = entry.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value) or value <= 0.0:
        raise InputError(
            f"{where}: {key} {value!r} must be a positive number; counts = 4095 stand for full = 10.0"
        )
    return float(value)


def turned(w: Array, x: Array, y: Array, z: Array, *, about: tuple[float, ...] = ()) -> Array:
    """Angle [deg] by which an orientation (quaternions of shape (n,)) has turned since its first row about
    the axis about which it turns most; not a number where a row lacks a number of it, or has four zeros,
    which are no orientation.  about: an axis on whose side that one is; else it turns most upwards.

    >>> half = np.radians([0.0, 10.0, np.nan, 20.0]) / 2
    >>> turned(np.cos(half), np.sin(half), 0 * half, 0 * half)[1:].round(6).tolist()
    [10.0, nan, 20.0]
    """
    there, vectors = _vectors(w, x, y, z)
    angle: Array = np.full(len(there), np.nan)
    if len(vectors):
        axis = _axis(vectors)
        angle[there] = vectors @ (axis if not about or axis @ np.array(about) >= 0.0 else -axis)
    return angle


def axis_of(w: Array, x: Array, y: Array, z: Array) -> tuple[float, tuple[float, ...]]:
    """How far an orientation (quaternions of shape (n,)) turns [deg], and about which axis (3,).

    >>> half = np.radians([0.0, -10.0, -20.0]) / 2
    >>> far, axis = axis_of(np.cos(half), np.sin(half), 0 * half, 0 * half)
    >>> round(far, 6), round(axis[0], 6)
    (20.0, -1.0)
    """
    _, vectors = _vectors(w, x, y, z)
    if not len(vectors):
        return 0.0, ()
    axis = _axis(vectors)
    return float(np.max(vectors @ axis)), tuple(map(float, axis))


def _vectors(w: Array, x: Array, y: Array, z: Array) -> tuple[Any, Array]:
    """Rows that hold an orientation (n,), and how these have turned since the first [deg], (rows, 3)."""
    from scipy.spatial.transform import Rotation

    parts = np.column_stack([x, y, z, w])
    there = np.isfinite(parts).all(axis=1) & parts.any(axis=1)
    if not there.any():
        return there, np.empty((0, 3))
    seen = Rotation.from_quat(parts[there])
    return there, (seen[0].inv() * seen).as_rotvec(degrees=True)


def _axis(vectors: Array) -> Array:
    """The axis about which rotations (rows, 3) turn most, on the side to which they turn farthest."""
    axis: Array = np.linalg.svd(vectors, full_matrices=False)[2][0]
    along = vectors @ axis
    return axis if along[np.argmax(np.abs(along))] >= 0.0 else -axis


def is_vacuum(lowest: float, highest: float) -> bool:
    """Whether a pressure counted from the air's stays below it.

    >>> is_vacuum(-66.0, 0.4), is_vacuum(-1.0, 200.0)
    (True, False)
    """
    return highest < -VACUUM * lowest
