"""Compiling exported folders as a target would, with the compiler of this machine."""

import atexit
import shutil
import subprocess
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import pytest

from design.export.catalogue import part
from design.export.formats.folder import contents
from design.export.part import Part
from plants import Wrist

CC = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
MADE = ("-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-O2", "-ffp-contract=off")
OWN = (*MADE, "-pedantic")
WRIST = Wrist.flexion()

GAINS = {
    "pi": (3.1, 10.4),
    "pi-2dof": (3.1, 10.4, 0.7, 0.01),
    "cascade": (2.6, 8.8, 0.8, 1.0),
    "lqi": (600.0, -640.0, -70.0, 8.0, 45.0),
    "feedforward": (25.0,),
    "feedforward-pi": (1.2, 2.2, 0.0305),  # a delay between samples
    "observer": (15.0,),
    "mpc": (),
    "mpc-robust": (),
    "mpc-real-time": (),
    "mpc-robust --gains 100,100,1": (100.0, 100.0, 1.0),  # a dead time in its model, of a single command
    "mpc-real-time-robust --gains 25,50,2": (25.0, 50.0, 2.0),
}
SHORT = ("feedforward", "mpc-real-time", "mpc-real-time-robust --gains 25,50,2")
STEPS = dict.fromkeys(SHORT, 2000)  # the inverse runs its 10,000 steps with the PI


def quick(kinds: Iterable[str]) -> list[Any]:
    """Kinds for a test that is quick but for those that take six seconds and more to write."""
    return [pytest.param(k, marks=pytest.mark.slow) if k.startswith("mpc-robust") else k for k in kinds]


needs_compiler = pytest.mark.skipif(CC is None, reason="no C compiler (cc, gcc, clang) on this machine")


@cache
def exported(kind: str) -> tuple[Part, Path]:
    """A controller's part, and the folder that it was written to."""
    made = part(kind.split()[0], "flexion", WRIST, GAINS[kind] or None)
    folder = Path(mkdtemp(prefix=f"{made.name}-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    for name, text in contents(made, WRIST, STEPS.get(kind, 10_000)).items():
        (folder / name).write_text(text)
    return made, folder


def run(*words: object, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    """A command and what it said; not checked."""
    return subprocess.run([str(w) for w in words], cwd=folder, capture_output=True, text=True, check=False)


def compiled(source: str, flags: tuple[str, ...], folder: Path) -> str:
    """The object of a source; fails where the compiler has anything to say."""
    out = source.replace(".c", ".o")
    said = run(CC, *flags, "-c", source, "-o", out, folder=folder)
    assert said.returncode == 0, said.stderr
    return out


@cache
def objects(kind: str) -> list[str]:
    """Objects of a controller: its own source under strict warnings, CasADi's without ``-pedantic``."""
    made, folder = exported(kind)
    return [compiled(f"{made.name}.c", OWN, folder), compiled(f"{made.name}_law.c", MADE, folder)]


def program(kind: str, name: str, source: str | None = None) -> Path:
    """An executable around a controller, of a source that is in its folder or given."""
    _, folder = exported(kind)
    if source is not None:
        (folder / f"{name}.c").write_text(source)
    main = compiled(f"{name}.c", OWN, folder)
    said = run(CC, main, *objects(kind), "-lm", "-o", name, folder=folder)
    assert said.returncode == 0, said.stderr
    return folder / name
