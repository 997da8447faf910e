"""Gains as a TOML file: what the tuner and a design keep, and ``--gains FILE.toml`` takes."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from design.synthesis.answer import UNITS
from design.synthesis.requirements import LIMIT_UNITS
from plants.errors import InputError
from plants.files import write_atomically
from plants.rig import Rig
from plants.toml import check_keys, is_number, read_toml

MORE = {"b": "1", "Tf": "s"}
"""What the gains of a PI with two degrees of freedom have beside."""

OF_MPC = {"swing": "1/deg^2", "move": "1/V^2", "delay": "periods"}
"""What is tuned of an MPC, in the units of the built-in rig (`design.mpc.problem.weighted`)."""

ADVICE = "give a file that the tuner kept, or Kp,Ki"
ADVICE_OF_MPC = "give a file that `wrist design --mpc` wrote, or swing,move,delay"


def units_of(rig: Rig | None = None) -> dict[str, str]:
    """Units of Kp and Ki on a rig, the built-in one where none is given.

    >>> units_of()
    {'Kp': 'kPa/deg', 'Ki': 'kPa/(deg s)'}
    """
    return {name: unit if rig is None else rig.unit(unit) for name, unit in UNITS.items()}


def write(
    path: str | Path,
    gains: Mapping[str, float],
    tuned_on: Mapping[str, Any] | None = None,
    mine: Collection[Path] = (),
    rig: Rig | None = None,
) -> Path:
    """Write gains, complete or not at all, and return where: the path, ending in .toml, made absolute.

    gains: Kp [kPa/deg] and Ki [kPa/(deg s)], in the units of the rig, and where they are not those of a plain
    PI the reference weight b [1] and the time constant Tf [s] of the filter of the angle.  tuned_on: what
    TOML holds, by name, that says of which plant the gains are, and which limits they break; for people, and
    for `broken`.  mine: files that may be replaced.  rig: the built-in one where not given.  Raises
    InputError for a path without a name, for another file that is there already, and for a place that cannot
    be written to.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     read(write(Path(folder) / "mine", {"Kp": 2.3, "Ki": 6.4}))
    (2.3, 6.4)
    """
    path = _place(str(path).strip())
    if path.exists() and path not in mine:
        raise InputError(f"{path}: exists already; choose another name")
    units = units_of(rig)
    if gains.get("b", 1.0) != 1.0 or gains.get("Tf", 0.0) != 0.0:
        units |= MORE
    return _written(path, f"Gains of a PI, for: wrist robust --gains {path.name}", gains, units, tuned_on)


def write_mpc(
    path: Path,
    gains: Mapping[str, float],
    tuned_on: Mapping[str, Any] | None = None,
    rig: Rig | None = None,
) -> Path:
    """Write what was tuned of an MPC, in place of what is there, and return where: the weights swing
    [1/deg^2] and move [1/V^2], in the units of the rig, and the delay [periods] of its model; tuned_on as of
    `write`.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     read_mpc(write_mpc(Path(folder) / "mpc.toml", {"swing": 25.0, "move": 50.0, "delay": 2.0}))
    (25.0, 50.0, 2.0)
    """
    words = f"An MPC, for: wrist export mpc-real-time-robust --gains {path.name}"
    return _written(path, words, gains, units_of_mpc(rig), tuned_on)


def units_of_mpc(rig: Rig | None = None) -> dict[str, str]:
    """Units of what is tuned of an MPC on a rig, the built-in one where none is given."""
    return {n: unit if rig is None else rig.unit(unit) for n, unit in OF_MPC.items()}


def _written(
    path: Path,
    words: str,
    gains: Mapping[str, float],
    units: Mapping[str, str],
    tuned_on: Mapping[str, Any] | None,
) -> Path:
    import tomlkit

    document = tomlkit.document()
    document.add(tomlkit.comment(words))
    tables = tomlkit.table(is_super_table=True)
    for name, unit in units.items():
        tables[name] = {"value": float(gains[name]), "unit": unit}
    document["gains"] = tables
    if tuned_on:
        document["tuned_on"] = dict(tuned_on)
    write_atomically(path, tomlkit.dumps(document))
    return path


def _place(text: str) -> Path:
    """Where gains of that name go."""
    if not text.removesuffix(".toml").strip("./\\ ") or "\0" in text:
        raise InputError(f"{text!r} is no name of a file; give one such as gains.toml")
    return Path(text if text.endswith(".toml") else f"{text}.toml").expanduser().absolute()


def read_more(path: str | Path) -> tuple[float, float]:
    """Reference weight b [1] and filter Tf [s] of a TOML file; 1 and 0, those of a plain PI, where it has
    none.

    Raises InputError as `read`.
    """
    entries = _entries(path, {**UNITS, **MORE}, UNITS, ADVICE)
    if not entries.keys() >= MORE.keys():
        return 1.0, 0.0
    b, Tf = (_value(f"{path}: gains.{name}", unit, entries[name]) for name, unit in MORE.items())
    return b, Tf


def read(path: str | Path, rig: Rig | None = None) -> tuple[float, float]:
    """Kp [kPa/deg] and Ki [kPa/(deg s)] of a TOML file, in the units of a rig, the built-in one where none is
    given.

    Raises InputError, in one line, for a file that is missing, no TOML or without the two, for a wrong
    unit, and for a value that is not a finite number, or negative.
    """
    entries = _entries(path, {**UNITS, **MORE}, UNITS, ADVICE)
    Kp, Ki = (_value(f"{path}: gains.{name}", unit, entries[name]) for name, unit in units_of(rig).items())
    return Kp, Ki


def read_mpc(path: str | Path, rig: Rig | None = None) -> tuple[float, ...]:
    """Weights swing [1/deg^2] and move [1/V^2], in the units of a rig, and delay [periods] of a TOML file.

    Raises InputError as `read`.
    """
    entries = _entries(path, OF_MPC, OF_MPC, ADVICE_OF_MPC)
    units = units_of_mpc(rig)
    return tuple(_value(f"{path}: gains.{name}", unit, entries[name]) for name, unit in units.items())


@dataclass(frozen=True)
class Broken:
    """That gains break limits, those named where it is known which; nearest: no gains were found that break
    none, and these come nearest."""

    limits: tuple[str, ...]
    nearest: bool


def broken(path: str | Path) -> Broken | None:
    """What a TOML file of gains says of limits that they break; None where it says nothing of the kind."""
    about = read_toml(Path(path), "file of gains", ADVICE).get("tuned_on")
    told: Mapping[str, Any] = about if isinstance(about, dict) else {}
    names = told.get("limits_broken")
    limits = tuple(n for n in LIMIT_UNITS if n in names) if isinstance(names, list) else ()
    nearest = told.get("holds") is False
    return Broken(limits, nearest) if nearest or limits else None


def _entries(
    path: str | Path, known: Collection[str], needed: Collection[str], advice: str
) -> Mapping[str, Any]:
    path = Path(path)
    table = read_toml(path, "file of gains", f"`wrist robust --help`, or {advice}")
    entries = table.get("gains")
    if not isinstance(entries, dict) or not entries.keys() >= set(needed):
        first, *_, last = needed
        raise InputError(f"{path}: holds no [gains.{first}] and [gains.{last}]; {advice}")
    check_keys(table, ("gains", "tuned_on"), str(path))
    check_keys(entries, tuple(known), f"{path}: gains")
    return entries


def _value(where: str, unit: str, entry: Any) -> float:
    given: Mapping[str, Any] = entry if isinstance(entry, dict) else {}
    check_keys(given, ("value", "unit"), where)
    value: Any = given.get("value")
    if not is_number(value) or value < 0.0:
        raise InputError(f"{where}: value {value!r} is not a finite number, or is negative")
    if given.get("unit") != unit:
        raise InputError(f"{where}: unit {given.get('unit')!r} is wrong; give it in {unit}")
    return float(value)
