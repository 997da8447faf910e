"""Exported C by Debian's compiler for ARM: objects, and how much flash and RAM they take."""

import shutil
import subprocess
from pathlib import Path

from plants.errors import InputError

PREFIX = "arm-none-eabi-"
COMPILER = f"{PREFIX}gcc"
QEMU = "qemu-system-arm"
CORE = ("-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard")
FLAGS = (*CORE, "-std=c99", "-O2", "-ffunction-sections", "-fdata-sections")
NEEDED = {
    COMPILER: "gcc-arm-none-eabi",
    f"{PREFIX}size": "binutils-arm-none-eabi",
    QEMU: "qemu-system-arm",
}
"""Tools, and the packages of Debian that have them."""

CALLER = """#include "{n}.h"
static {n}_state state;
static volatile {n}_measured measured;
static volatile {real} out;
void entry(void)
{{
    (void){n}_init(&state, 0, 0);
    for (;;) {{
        {n}_measured now = measured;
        {real} found;
        (void){n}_step(&state, &now, &found);
        out = found;
    }}
}}
"""
"""The least that calls a controller; its some 100 bytes are counted with it."""


def missing() -> str | None:
    """What has to be installed, in a line; None where all is there."""
    absent = [package for tool, package in NEEDED.items() if shutil.which(tool) is None]
    if NEEDED[COMPILER] not in absent:
        # the compiler comes without a C library, and answers with the bare name of what it does not find
        library = said([COMPILER, "-print-file-name=nano.specs"], Path.cwd()).strip()
        absent += ["libnewlib-arm-none-eabi"] * (not Path(library).is_absolute())
    if absent:
        return f"not on this machine: {', '.join(absent)}; apt-get install {' '.join(absent)}"
    return None


def said(words: list[str], folder: Path) -> str:
    """What a command printed.  Raises InputError, with the begin of what it complained of, where it fails."""
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False, timeout=1200)
    if done.returncode:
        raise InputError(f"{words[0]} failed: {' '.join((done.stderr or done.stdout).split())[:300]}")
    return done.stdout


def objects(name: str, folder: Path) -> list[str]:
    """Compile the two sources of an export in a folder, with the call graph of each beside (`NAME.ci`)."""
    made = []
    for source in (name, f"{name}_law"):
        words = [*FLAGS, "-Wall", "-Wextra", "-Werror", "-fcallgraph-info=su", "-c", f"{source}.c"]
        said([COMPILER, *words, "-o", f"{source}.o"], folder)
        made.append(f"{source}.o")
    return made


def sizes(name: str, real: str, made: list[str], folder: Path) -> tuple[int, int]:
    """Flash and RAM [bytes] of a controller with one state and the functions of the C library that it calls.

    real: type of its numbers; made: its objects.
    """
    (folder / "caller.c").write_text(CALLER.format(n=name, real=real), encoding="utf-8")
    link = ["--specs=nano.specs", "-nostartfiles", "-Wl,--gc-sections,-e,entry", "-lm", "-o", "caller"]
    said([COMPILER, *FLAGS, "caller.c", *made, *link], folder)
    text, data, bss = map(int, said([f"{PREFIX}size", "caller"], folder).splitlines()[1].split()[:3])
    return text + data, data + bss
