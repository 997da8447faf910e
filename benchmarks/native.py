"""The hand-written C loops: compiled into a folder, called through ctypes.

The C sources name the rows of their arrays; the header with those names is written from the
trees of `plants.simulation.closed_loop`, so that both sides agree on the layout however the law grows.
"""

import ctypes
import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plants.kernel import pytrees as tree

Array = NDArray[np.float64]
Rollouts = Callable[[int, Array, Array], None]
"""Advance a state by a number of steps, in place: (steps, coefficients, state), rows (leaves, lanes)."""

SOURCES = Path(__file__).parent
NATIVE = ("-O3", "-march=native")
BUILDS = {
    "scalar": ("scalar.c", NATIVE),
    "simd": ("simd.c", (*NATIVE, "-ffast-math")),
    # With AVX-512 three vectors of eight are faster than four of four; found by trial.
    "simd_wide": ("simd.c", (*NATIVE, "-ffast-math", "-DWIDTH=8", "-DTOGETHER=3")),
}
"""Source and options of the compiler by name of the build."""

BLOCK = 48
"""Lanes are a multiple of this: every build's vectors come out even."""


class NoCompiler(Exception):
    """There is no C compiler on this machine, or it cannot compile our sources."""


def compiler() -> str:
    """Path of the C compiler: $CC, or gcc.  Raises NoCompiler where there is none."""
    name = os.environ.get("CC") or "gcc"
    path = shutil.which(name)
    if path is None:
        raise NoCompiler(f"no C compiler: {name} is not on the path; install gcc, or name one in $CC")
    return path


def version() -> str:
    """First line of what the compiler says about itself."""
    return _output("--version").splitlines()[0]


def has_avx512() -> bool:
    """Whether this machine has vectors of eight doubles, as the compiler sees it."""
    return "__AVX512F__" in _output("-march=native", "-dM", "-E", "-x", "c", os.devnull)


def _output(*options: str) -> str:
    done = subprocess.run([compiler(), *options], capture_output=True, text=True)
    if done.returncode:
        raise NoCompiler(f"{compiler()} failed: {' '.join(done.stderr.split())[:300]}")
    return done.stdout


def header(coefficients: Any, state: Any) -> str:
    """C enumerations of the leaves of two trees, in their order: ``coef_plant_a1`` and so on."""

    def rows(prefix: str, names: list[str]) -> str:
        return "enum { " + ", ".join(f"{prefix}_{n.replace('.', '_')}" for n in names) + " };\n"

    return rows("coef", tree.names(coefficients)) + rows("state", tree.names(state))


def build(name: str, coefficients: Any, state: Any, folder: Path) -> Rollouts:
    """The ``rollouts`` of one of `BUILDS`, compiled in a folder for trees of this shape."""
    source, options = BUILDS[name]
    part, library = folder / f"{name}.o", folder / f"{name}.so"
    (folder / "layout.h").write_text(header(coefficients, state))
    common = ("-std=gnu11", "-Wall", "-Wno-psabi", "-fPIC", f"-I{folder}")
    _output(*options, *common, "-c", "-o", str(part), str(SOURCES / source))
    # Linked apart, without -ffast-math: with it, loading the library would switch off
    # denormal numbers in this whole process.
    _output("-shared", "-o", str(library), str(part), "-lm")
    function = ctypes.CDLL(str(library)).rollouts
    pointer = ctypes.POINTER(ctypes.c_double)
    function.argtypes, function.restype = (ctypes.c_int, ctypes.c_int, pointer, pointer), None

    def rollouts(steps: int, c: Array, s: Array) -> None:
        lanes = s.shape[1]
        assert c.shape[1] == lanes
        assert lanes % BLOCK == 0
        assert c.flags.c_contiguous
        assert s.flags.c_contiguous
        function(lanes, steps, c.ctypes.data_as(pointer), s.ctypes.data_as(pointer))

    return rollouts


def stack(values: Any, lanes: int) -> Array:
    """Leaves of a tree as rows of one array, those shared by the lanes repeated."""
    return np.array([np.broadcast_to(np.asarray(leaf, float), lanes) for leaf in tree.leaves(values)])
