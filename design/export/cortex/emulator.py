"""Instructions of a step, counted on an emulated Cortex-M4F.

QEMU emulates no pipeline and no memory that waits: it says how many instructions ran, not how many cycles.
With ``-icount shift=7`` its clock moves on by 128 ns for each instruction, so that a timer of 25 MHz counts
3.2 ticks; the program measures its own ticks per instruction along 2,000 known ones.
"""

import re
from pathlib import Path
from typing import NamedTuple

from design.export.cortex.toolchain import COMPILER, FLAGS, QEMU, said
from design.export.part import Part
from design.export.rendering import render
from design.export.vectors import Vector
from plants.errors import InputError

SHIFT = 7


class StepCount(NamedTuple):
    """Of a run over a test vector: instructions a step, mean and most; stack [bytes] that was used, the C
    library's frames included; largest difference from Python, in the unit of the output; instructions per
    tick of the timer, as calibrated."""

    mean: float
    most: float
    stack: int
    worst: float
    per_tick: float


def counted(part: Part, found: Vector, made: list[str], folder: Path) -> StepCount:
    """Run the objects of a part over a vector in QEMU.

    Raises InputError where it does not link, does not end, or says something else.
    """
    (folder / "measure.c").write_text(render("measure.c.jinja", part, found=found), encoding="utf-8")
    link = ["--specs=rdimon.specs", "-Wl,--section-start=.vectors=0", "-lm", "-o", "measure"]
    said([COMPILER, *FLAGS, "measure.c", *made, *link], folder)
    machine = ["-M", "mps2-an386", "-nographic", "-monitor", "none", "-serial", "none"]
    words = [*machine, "-semihosting-config", "enable=on,target=native", "-icount", f"shift={SHIFT}"]
    told = said([QEMU, *words, "-kernel", "measure"], folder)
    shown = re.fullmatch(r"mean (\S+) most (\S+) stack (\d+) worst (\S+) tick (\S+)\n", told)
    if shown is None:
        raise InputError(f"{QEMU}: no figures but {told[:200]!r}")
    mean, most, stack, worst, per_tick = shown.groups()
    return StepCount(float(mean), float(most), int(stack), float(worst), float(per_tick))
