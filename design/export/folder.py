"""The folder that goes to the target: everything is made before anything is written."""

from dataclasses import replace
from pathlib import Path

from design.export.part import Part
from design.export.rendering import render
from design.export.vectors import STEPS, csv, vector
from plants.errors import InputError
from plants.files import write_atomically
from plants.wrist import Wrist


def contents(part: Part, wrist: Wrist, steps: int = STEPS) -> dict[str, str]:
    """Files by name: header, sources, README, test vector of so many steps and what replays it.  The same,
    to the byte, for the same law.  The loop of the vector runs around the wrist without its effects."""
    n = part.name
    found = vector(part, replace(wrist, effects=()), steps)
    return {
        f"{n}.h": render("law.h.jinja", part),
        f"{n}.c": render(part.template, part, **part.constants),
        f"{n}_law.c": part.code,
        f"{n}_vector.csv": csv(part, found),
        "test_vector.c": render("test_vector.c.jinja", part, found=found),
        "Makefile": render("Makefile.jinja", part),
        "README.md": render("README.md.jinja", part),
    }


def write(part: Part, wrist: Wrist, folder: Path) -> list[Path]:
    """Write the files of a part into a folder, each complete or not at all; the paths.

    Raises InputError, before anything is written, where a folder stands in a file's place, and where the
    folder cannot be written to.
    """
    made = contents(part, wrist)
    for name in made:
        if (folder / name).is_dir():
            raise InputError(f"--out: {folder / name} is a folder; remove it or choose another place")
    for name, text in made.items():
        write_atomically(folder / name, text)
    return [folder / name for name in made]
