"""The folder that goes to the target: everything is made before anything is written."""

from dataclasses import replace
from pathlib import Path

from design.export.header import header
from design.export.part import Part
from design.export.readme import readme
from design.export.source import source
from design.export.vectors import STEPS, csv, program, vector
from plants.errors import InputError
from plants.files import write_atomically
from plants.wrist import Wrist


def contents(part: Part, wrist: Wrist, steps: int = STEPS) -> dict[str, str]:
    """Files by name: header, sources, README, test vector of so many steps and what replays it.  The same,
    to the byte, for the same law.  The loop of the vector runs around the wrist without its effects."""
    n = part.name
    found = vector(part, replace(wrist, effects=()), steps)
    return {
        f"{n}.h": header(part),
        f"{n}.c": part.source or source(part),
        f"{n}_law.c": part.code,
        f"{n}_vector.csv": csv(part, found),
        "test_vector.c": program(part, found),
        "Makefile": makefile(part),
        "README.md": readme(part),
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


def makefile(part: Part) -> str:
    """``make check`` replays the test vector with the compiler of the machine."""
    n = part.name
    return f"""\
# make check: replays the test vector on this machine.
CC ?= cc
CFLAGS ?= -O2

.PHONY: check clean

check: test_vector
	./test_vector {n}_vector.csv

test_vector: test_vector.c {n}.c {n}_law.c {n}.h
	$(CC) -std=c99 -Wall -Werror $(CFLAGS) -o $@ test_vector.c {n}.c {n}_law.c -lm

clean:
	rm -f test_vector
"""
