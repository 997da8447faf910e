"""A campaign: a folder of recordings of one rig, and ``campaign.toml`` which says what they are for."""

import hashlib
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from plants.errors import InputError, InputWarning
from plants.measured.campaigns.draft import draft
from plants.measured.campaigns.read_table import RADIANS, from_table, on_one_axis, required
from plants.measured.campaigns.recording import Recording, Stage
from plants.measured.formats.columns import Source, parse_columns
from plants.measured.formats.tables import Table, read_table
from plants.measured.instrument.stated import StatedHabits, parse_logger
from plants.rig import Rig, Units, built_in_rig
from plants.toml import check_keys, is_number, parse_toml

FILE = "campaign.toml"
EXAMPLES = Path(__file__).parents[1] / "examples"
"""Where the campaigns lie that ship with the project."""

KEYS = ("axis", "stage", "start", "sample_time_s", "fit", "validate", "columns", "logger")

Start = Literal["rest", "unknown"]

FEW = 100
"""Rows up to which two recordings may well agree by chance."""

FITTED = 0.6
"""Share of a single recording that is fitted on; the rest reports the error."""


@dataclass(frozen=True)
class Campaign:
    """Recordings of one rig, to fit on and to report the error on.

    name: the folder; axis: ``flexion``, ``deviation`` or a user's own; stage: the last stage that
    was measured; start: whether every recording starts at rest at 100 kPa on the virgin curve;
    sample_time [s] of the log; fit: may be used to fit and to choose; validate: only ever to report
    the error; checksum: SHA-256 of campaign.toml and the recordings, the same on every machine; logger: what
    campaign.toml says that the logger does; units: in which command, pressure and angle are kept.
    """

    name: str
    axis: str
    stage: Stage
    start: Start
    sample_time: float
    fit: tuple[Recording, ...]
    validate: tuple[Recording, ...]
    checksum: str
    logger: StatedHabits = field(default_factory=StatedHabits)
    units: Units = field(default_factory=lambda: built_in_rig().units)

    @property
    def recordings(self) -> tuple[Recording, ...]:
        """All recordings, those that are held out last."""
        return (*self.fit, *self.validate)

    @property
    def names(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(r.name for r in self.recordings)

    def each(self, change: Callable[[Recording], Recording]) -> "Campaign":
        """The campaign with each recording changed."""
        return replace(self, fit=tuple(map(change, self.fit)), validate=tuple(map(change, self.validate)))


@dataclass(frozen=True)
class Declaration:
    """What campaign.toml says; fit and validate are paths of files within the folder."""

    axis: str
    stage: Stage
    start: Start
    sample_time: float
    fit: tuple[str, ...]
    validate: tuple[str, ...]
    columns: Mapping[str, Source]
    logger: StatedHabits


def load_campaign(folder: str | Path, rig: Rig | None = None) -> Campaign:
    """The campaign in a folder, of a rig; where not given, of the built-in one if it has that motion.

    Raises InputError, in one line with the file and, where it applies, row and column, for a
    folder without a valid campaign.toml and for recordings that ``from_table`` refuses.
    """
    folder = Path(folder)
    content = _read_declaration(folder)
    said = parse_declaration(content, folder / FILE)
    if rig is None and said.axis in built_in_rig().motions:
        rig = built_in_rig()
    units = _units(said.columns)
    if rig is not None:
        _check_units(said.columns, rig, folder / FILE)
    tables = {name: read_table(folder / name) for name in said.fit + said.validate}
    said = replace(said, columns=on_one_axis(said.columns, tables))
    recordings = {
        name: from_table(table, _sources_in(table, said, tables), said.stage, said.sample_time, name, rig)
        for name, table in tables.items()
    }
    if rig is None:
        _warn_of_radians(folder, recordings.values())
    fit, validate = (tuple(recordings[n] for n in names) for names in (said.fit, said.validate))
    if not validate:
        fit, validate = _split(fit[0], folder)
    else:
        _check_copies(fit, validate, folder)
    return Campaign(
        folder.resolve().name, said.axis, said.stage, said.start, said.sample_time, fit, validate,
        _checksum(content, folder, said.fit + said.validate), said.logger,
        units,
    )  # fmt: skip


KEPT = {"command": "command_V", "angle": "angle_deg"}
"""Columns that may stay in a unit of their own, by what a rig says the unit of."""


def _units(columns: Mapping[str, Source]) -> Units:
    """In which a campaign is kept, of which ``[columns]`` says what is in another unit than the standard."""
    own = {what: columns[name].unit for what, name in KEPT.items() if name in columns and columns[name].unit}
    return replace(built_in_rig().units, **own)


def _check_units(columns: Mapping[str, Source], rig: Rig, path: Path) -> None:
    """Refuse a column that stays in a unit which is not that of the rig."""
    for what, name in KEPT.items():
        own, wanted = columns[name].unit if name in columns else "", getattr(rig.units, what)
        if own and own != wanted:
            raise InputError(
                f"{path}: [columns] {name} stays in {own}, but the {what} of the rig is in {wanted}; "
                "give its scale in place of the unit"
            )


def shipped() -> list[Path]:
    """Folders of the campaigns that ship with the project; their data is synthetic."""
    return sorted(p.parent for p in EXAMPLES.glob(f"*/{FILE}"))


def _warn_of_radians(folder: Path, recordings: Iterable[Recording]) -> None:
    """Warn of angles that all stay within `RADIANS`, of a rig of which no file gives a range or a unit."""
    most = max((float(np.max(np.abs(r.angle))) for r in recordings if r.angle is not None), default=0.0)
    if 0.0 < most < RADIANS:
        warnings.warn(
            f"{folder}: the angle stays within {most:.3g} deg in every recording, which looks like radians; "
            "map it with scale = 57.29578",
            InputWarning,
            stacklevel=3,
        )


def _split(recording: Recording, folder: Path) -> tuple[tuple[Recording, ...], tuple[Recording, ...]]:
    """A single recording as two: its first part to fit on, and the whole, judged on the rest."""
    first, last = float(recording.time[0]), float(recording.time[-1])
    at = first + FITTED * (last - first)
    warnings.warn(
        f"{folder / FILE}: only one recording and no validate; it is fitted up to {at:.4g} s and the error "
        "reported on the rest, which is of the same run; record another to be sure",
        InputWarning,
        stacklevel=3,
    )
    return (recording.until(at),), (replace(recording, judged_from=at),)


def _check_copies(fit: tuple[Recording, ...], validate: tuple[Recording, ...], folder: Path) -> None:
    """Refuse a recording that stands in both lists under two names."""
    for a in fit:
        for b in validate:
            pairs = ((a.command, b.command), (a.angle, b.angle), (a.pressure, b.pressure))
            if len(a.time) > FEW and all(np.array_equal(np.asarray(x), np.asarray(y)) for x, y in pairs):
                raise InputError(
                    f"{folder / FILE}: {b.name!r} in validate holds the same rows as {a.name!r} in fit; the "
                    "error must come from held-out recordings"
                )


def load_recording(
    path: str | Path,
    columns: Mapping[str, Any] | None = None,
    stage: Stage = "wrist",
    sample_time: float | None = None,
    rig: Rig | None = None,
) -> Recording:
    """A single recording; `columns` as the ``[columns]`` table of campaign.toml, sample_time in s.

    Raises InputError as ``load_campaign`` does.
    """
    rig = built_in_rig() if rig is None else rig
    return from_table(read_table(path), parse_columns(columns, str(path)), stage, sample_time, rig=rig)


def parse_declaration(content: bytes, path: Path) -> Declaration:
    """What the bytes of a campaign.toml say; `path` begins the errors.

    Raises InputError, naming the key, for one that is unknown, missing or wrong.
    """
    table = parse_toml(content, path, "correct it")
    check_keys(table, KEYS, str(path))
    axis, sample_time = table.get("axis"), _sample_time(table.get("sample_time_s"), path)
    if not isinstance(axis, str) or not axis:
        raise InputError(f'{path}: axis is missing; give axis = "flexion", "deviation" or a name of your own')
    stage, start = table.get("stage", "wrist"), table.get("start", "rest")
    if stage not in ("wrist", "regulator"):
        raise InputError(f'{path}: stage {stage!r} is unknown; it is "wrist" or "regulator"')
    if start not in ("rest", "unknown"):
        raise InputError(f'{path}: start {start!r} is unknown; it is "rest" or "unknown"')
    fit = _names(table, "fit", path, "they are what the model is fitted to")
    alone = len(fit) == 1 and not table.get("validate")
    validate = (
        () if alone else _names(table, "validate", path, "the error is reported on held-out recordings")
    )
    _check_separate(fit, validate, path)
    return Declaration(
        axis, stage, start, sample_time, fit, validate, parse_columns(table.get("columns"), str(path)),
        parse_logger(table.get("logger"), str(path), fit + validate),
    )  # fmt: skip


def _read_declaration(folder: Path) -> bytes:
    try:
        return (folder / FILE).read_bytes()
    except FileNotFoundError:
        if not folder.exists():
            raise InputError(f"{folder}: no such folder; give the folder of a campaign") from None
        advice, said = draft(folder)
        raise InputError(f"{folder}: holds no {FILE}; {advice}", said) from None
    except NotADirectoryError:
        raise InputError(f"{folder}: is a file; give the folder that holds it and {FILE}") from None
    except OSError as error:
        raise InputError(f"{folder / FILE}: cannot be read ({error.strerror})") from None


def _sample_time(value: Any, path: Path) -> float:
    if is_number(value) and value > 0.0:
        return float(value)
    problem = "is missing" if value is None else f"{value!r} is not a positive number"
    raise InputError(f"{path}: sample_time_s {problem}; give the log's sample time in seconds")


def _names(table: Mapping[str, Any], key: str, path: Path, why: str) -> tuple[str, ...]:
    names = table.get(key)
    if names is None or names == []:
        problem = "is missing" if names is None else "is empty"
        raise InputError(f"{path}: {key} {problem}; list at least one recording: {why}")
    if not isinstance(names, list) or not all(isinstance(n, str) and n for n in names):
        raise InputError(f'{path}: {key} must be a list of file names such as ["steps.csv"]')
    return tuple(Path(n).as_posix() for n in names)


def _check_separate(fit: tuple[str, ...], validate: tuple[str, ...], path: Path) -> None:
    both = [n for n in fit if n in validate]
    if both:
        raise InputError(
            f"{path}: {both[0]!r} is in both fit and validate; the error must come from recordings "
            "that were held out of the fit"
        )
    for key, names in (("fit", fit), ("validate", validate)):
        twice = [n for i, n in enumerate(names) if n in names[:i]]
        if twice:
            raise InputError(f"{path}: {twice[0]!r} is listed twice in {key}; list it once")


def _sources_in(table: Table, said: Declaration, tables: Mapping[str, Table]) -> dict[str, Source]:
    """The mappings that concern one recording of the campaign.

    A channel that not every run logged, such as the set-point, may be missing from some of the
    files; one that is in none of them is a name mistyped, and stays to be refused.
    """
    optional_elsewhere = {
        name
        for name, source in said.columns.items()
        if name not in required(said.stage) and any(source.name in t.columns for t in tables.values())
    }
    return {
        name: source
        for name, source in said.columns.items()
        if source.name in table.columns or name not in optional_elsewhere
    }


def _checksum(declaration: bytes, folder: Path, names: tuple[str, ...]) -> str:
    """SHA-256 [hex] of campaign.toml and the recordings, by name, whatever order they are listed in."""
    digest = hashlib.sha256()
    contents = [(FILE, declaration), *((n, (folder / n).read_bytes()) for n in sorted(names))]
    for name, content in contents:
        digest.update(f"{name}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()
