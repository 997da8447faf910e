"""A campaign from the logs of a recorder: runs as CSV, and a campaign.toml that says why it is so."""

import csv
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import tomlkit

from plants.errors import InputError
from plants.files import file_name, replaced_folder, write_atomically
from plants.measured.campaigns.campaign import FILE
from plants.measured.formats.cells import shorten
from plants.measured.formats.channel import LoggedChannel
from plants.measured.formats.columns import STANDARD
from plants.measured.formats.units import kept
from plants.measured.importing.channels import Log, listed, read_log
from plants.measured.importing.columns_table import columns_table
from plants.measured.importing.excitation import Chosen, Excited, choose, excited
from plants.measured.importing.roles import Role, roles
from plants.measured.importing.runs import Run, runs, steps_of

TIME = "time_s"

ONE_CLOCK = (
    "files of one run are not joined: put their columns side by side into one file on one clock, the slower "
    "one held between its samples"
)
"""What to do about a log that has no command, or nothing that it moves."""


@dataclass(frozen=True)
class Imported:
    """What logs became: the logs as read; role to channel; sample time [s]; the runs, how their commands
    move, and which are held out."""

    logs: tuple[Log, ...]
    roles: Mapping[str, Role]
    step: float
    runs: tuple[Run, ...]
    excitation: tuple[Excited, ...]
    chosen: Chosen

    @property
    def unused(self) -> tuple[str, ...]:
        """The channels of any log that fill no role, and have no standard name by which a campaign takes
        them."""
        taken = {*STANDARD, *(n for r in self.roles.values() for n in r.channels)}
        names = dict.fromkeys(c.name for log in self.logs for c in log.channels)
        return tuple(n for n in names if n not in taken)

    @property
    def unused_words(self) -> str:
        """That a fit does not use them, in a line; "" where there are none.  A trace still asks whether one
        explains what is left."""
        return f"not used in the fit: {shorten(self.unused)}" if self.unused else ""


def import_logs(
    files: Sequence[Path], given: Mapping[str, tuple[str, str]], sample_time: float | None = None
) -> Imported:
    """Logs of one rig, read, named and cut; given: role to channel and unit, as the user says.

    Raises InputError, in one line, for a log that cannot be read, and where channels cannot be told.
    """
    logs = tuple(read_log(f, sample_time) for f in files)
    for log in logs:
        for note in log.notes:
            if "no time for" in note and not any(len(c.time) for c in log.channels):
                raise InputError(note)
    fullest = max(logs, key=lambda log: len(log.channels))
    found = roles(fullest.channels, given)
    logs = tuple(_named_alike(log, found, fullest) for log in logs)
    step = float(f"{max(steps_of(log, found) for log in logs):.4g}")
    made: list[Run] = []
    for log in logs:
        there = {c.name for c in log.channels}
        logged = {n: r for n, r in found.items() if set(r.channels) <= there}
        own = runs(log, logged, step, alone=len(logs) == 1)
        stem = file_name(log.path.resolve().stem)
        made += [
            replace(r, name=f"{stem}-{i}.csv" if len(own) > 1 else f"{stem}.csv")
            for i, r in enumerate(own, 1)
        ]
    made = _named_apart(made)
    asked = tuple(excited(r.time, found["command"].factor * r.values[found["command"].channel]) for r in made)
    return Imported(
        logs, found, step, tuple(made), asked, choose(asked, [r.name.removesuffix(".csv") for r in made])
    )


def _named_alike(log: Log, found: Mapping[str, Role], fullest: Log) -> Log:
    """A log whose channels in roles that were found are called as in the fullest log, and counted in its
    units.

    Of channels that it lacks by name its own are told as those of any log; it may do without a reference, and
    without a pressure where the angle was logged.  Raises InputError where another is not to be told.
    """
    there = {c.name: c for c in log.channels}
    missing = [name for name, r in found.items() if not set(r.channels) <= there.keys()]
    needed = [n for n in missing if n != "reference" and not (n == "pressure" and "angle" in found)]
    if not missing:
        return log
    known = {name: (r.channel, "") for name, r in found.items() if name not in missing}
    try:
        own = roles(log.channels, known)
    except InputError:
        own = {}
    moved: dict[str, LoggedChannel] = {}
    notes = []
    alike = {n for n in missing if n in own and _one_of_a_kind(own[n], found[n])}
    for name in (n for n in missing if n in alike):
        r, as_found = own[name], found[name]
        scaled = r.factor / as_found.factor * there[r.channel].values
        moved[r.channel] = there[r.channel]._replace(name=as_found.channel, unit=as_found.unit, values=scaled)
        notes.append(f"{r.channel} is taken for {as_found.channel}: {r.why}")
    lacks = [n for n in needed if n not in alike]
    if lacks:
        advice = "import it apart" if _stands_alone(log) else ONE_CLOCK
        raise InputError(
            f"{log.path}: has no channel {found[lacks[0]].channel!r}, which {fullest.path} has, and none "
            f"that can be told for it; {advice}"
        )
    channels = tuple(moved.get(c.name, c) for c in log.channels)
    return log._replace(channels=channels, notes=(*log.notes, *notes))


def _stands_alone(log: Log) -> bool:
    """Whether a log has a command and what it moves, and so can be imported by itself."""
    try:
        roles(log.channels, {})
    except InputError:
        return False
    return True


def _one_of_a_kind(a: Role, b: Role) -> bool:
    """Whether the one can be counted in the unit of the other by a factor."""
    return a.absolute == b.absolute and not a.quaternion and not b.quaternion


def _named_apart(made: list[Run]) -> list[Run]:
    """Names of files that no two runs share."""
    seen: dict[str, int] = {}
    named = []
    for r in made:
        seen[r.name.lower()] = seen.get(r.name.lower(), 0) + 1
        again = seen[r.name.lower()]
        named.append(r if again == 1 else replace(r, name=f"{r.name.removesuffix('.csv')} ({again}).csv"))
    return named


def write_campaign(made: Imported, axis: str, folder: Path) -> list[Path]:
    """Write runs and campaign.toml into a new or empty folder, all of them or none; the paths.

    Raises InputError for a folder with something in it, and one that cannot be written to.
    """
    if folder.is_dir() and any(folder.iterdir()):
        raise InputError(f"--out: {folder} is not empty; choose a new folder")
    files = {r.name: table(r) for r in made.runs} | {FILE: declaration(made, axis)}
    with replaced_folder(folder.resolve()) as beside:
        for name, text in files.items():
            write_atomically(beside / name, text)
    return [folder / name for name in files]


def table(run: Run) -> str:
    """A run as CSV: the time, and every channel by its own name in its own unit; cells that the log lacks
    stay empty."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n", quoting=csv.QUOTE_MINIMAL)
    others = {n: v for n, v in run.values.items() if n != TIME}
    # A header whose names hold other separators is quoted, which the reader of campaigns passes over.
    heads = [TIME, *others]
    out.write(",".join(f'"{h}"' if re.search(r'[,;\t"]', h) or not h else h for h in heads) + "\n")
    digits = np.column_stack([np.round(run.time, 9), *others.values()])
    writer.writerows(["" if np.isnan(x) else repr(float(x)) for x in row] for row in digits)
    return out.getvalue()


def declaration(made: Imported, axis: str) -> str:
    """campaign.toml, each decision with its reason in a comment."""
    document = tomlkit.document()
    for line in _told(made):
        document.add(tomlkit.comment(line))
    document["axis"] = axis
    if "angle" not in made.roles:
        document["stage"] = "regulator"
        document.add(tomlkit.comment("regulator: no angle was logged, or none was recognised"))
    document["start"] = "unknown"
    document.add(tomlkit.comment('say "rest" if every run begins at rest, before the wrist has moved'))
    document["sample_time_s"] = made.step
    document.add(tomlkit.comment(made.chosen.why))
    document["fit"] = [made.runs[i].name for i in made.chosen.fit]
    if made.chosen.validate:
        document["validate"] = [made.runs[i].name for i in made.chosen.validate]
    document["columns"] = columns_table(made.roles)
    return tomlkit.dumps(document)


def _told(made: Imported) -> list[str]:
    """What was read, for the top of the file."""
    lines = ["Made by wrist import; every line may be corrected, and a comment says why it is as it is.", ""]
    for log in made.logs:
        lines.append(f"{file_name(log.path.name)}: channel, unit, from, to, rate")
        for c in listed(log.channels):
            lines.append(
                f"  {c['name']}, {c['unit'] or 'no unit'}, {c['low']:.6g}, {c['high']:.6g}, "
                f"{c['rate_Hz']:.4g} Hz"
            )
        lines += [f"  {note}" for note in log.notes]
    lines += [made.unused_words] if made.unused else []
    lines.append("")
    unit = kept(made.roles["command"].unit, "command") or "V"
    for run, asked in zip(made.runs, made.excitation, strict=True):
        lines.append(
            f"{run.name}: {asked.word}, {asked.low:.3g} to {asked.high:.3g} {unit}, {run.time[-1]:.4g} s; "
            f"ends where {run.ends}"
        )
    return lines
