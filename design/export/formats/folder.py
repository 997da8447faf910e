"""The folder that goes to the target: everything is made before anything is written."""

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from design.export.part import Part
from design.export.precision import in_single
from design.export.rendering import render
from design.export.vectors import STEPS, Vector, csv, vector
from plants.errors import InputError
from plants.files import replaced_folder, write_atomically
from plants.wrist import Wrist

MANIFEST = "manifest.sha256"
"""SHA-256 of the other files, as ``sha256sum -c`` reads it; written last."""


def contents(part: Part, wrist: Wrist, steps: int = STEPS) -> dict[str, str]:
    """Files by name: header, sources, README, test vector of so many steps and what replays it.  The same,
    to the byte, for the same law.  The loop of the vector runs around the wrist without its effects."""
    return around(part, vector(part, replace(wrist, effects=()), steps))


def around(part: Part, found: Vector) -> dict[str, str]:
    """Files by name, as `contents`, with a test vector that is there: that of a law is the same in each
    precision and for each target."""
    n = part.name
    written = in_single if part.precision == "single" else str
    files = {
        f"{n}.h": written(render("law.h.jinja", part)),
        f"{n}.c": written(render(part.template, part, **part.constants)),
        f"{n}_law.c": written(part.code),
        f"{n}_vector.csv": csv(part, found),
        "test_vector.c": render("test_vector.c.jinja", part, found=found),
        "Makefile": render("Makefile.jinja", part),
        "README.md": render("README.md.jinja", part),
    }
    return with_manifest(files)


def with_manifest(files: dict[str, str]) -> dict[str, str]:
    """Files by name, and their checksums."""
    sums = {name: hashlib.sha256(text.encode()).hexdigest() for name, text in files.items()}
    return files | {MANIFEST: "".join(f"{digest}  {name}\n" for name, digest in sums.items())}


def write(part: Part, wrist: Wrist, folder: Path) -> list[Path]:
    """Write the files of a part into a folder; the paths.  As `write_together`."""
    return write_together(contents(part, wrist), folder)


def write_together(made: Mapping[str, str], folder: Path) -> list[Path]:
    """Write files by name, a manifest among them, into a folder, all of them or none; the paths.

    They are written into a folder beside, which takes the place of a folder that is new, empty, or holds an
    export and nothing else.  A folder with anything else in it is kept: its manifest goes first and comes
    last, so that ``make check`` fails in between.  Raises InputError, before anything is written, where a
    folder stands in a file's place, and where the folder cannot be written to.
    """
    for name in made:
        if (folder / name).is_dir():
            raise InputError(f"--out: {folder / name} is a folder; remove it or choose another place")
    target = folder.resolve()
    if _is_export(target):
        with replaced_folder(target) as beside:
            for name, text in made.items():
                write_atomically(beside / name, text)
    else:
        (target / MANIFEST).unlink(missing_ok=True)
        for name, text in made.items():
            write_atomically(target / name, text)
    return [folder / name for name in made]


def _is_export(folder: Path) -> bool:
    """Whether a folder holds an export and nothing else, or nothing, and nobody works in it."""
    if not folder.exists():
        return True
    if Path.cwd().resolve().is_relative_to(folder):
        return False
    there = {p.name for p in folder.iterdir()}
    try:
        listed = {line.split()[-1] for line in (folder / MANIFEST).read_text().splitlines()}
    except (OSError, UnicodeDecodeError, IndexError):
        listed = set()
    return there <= listed | {MANIFEST, "test_vector"} if listed else not there
