"""Controllers on a Cortex-M4F: python -m design.export.cortex writes the table into docs/targets.md."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

from design.export.cortex.emulator import counted
from design.export.cortex.stack import deepest
from design.export.cortex.toolchain import missing, objects, sizes
from design.export.formats.folder import around
from design.export.part import Part
from design.export.precision import Precision
from design.export.table import EXEMPLARY, exemplary, into_page, written
from design.export.vectors import Vector, vector
from plants.wrist import Wrist

HEADING = "## Cost on a Cortex-M4F"
HEAD = (
    "controller", "precision", "flash [B]", "RAM [B]", "stack, graph [B]", "stack, seen [B]",
    "instructions, mean", "instructions, most", "these at 168 MHz [us]", "off from Python",
)  # fmt: skip
STEPS = 2_000
"""Samples that are run: every kind of reference of the vector, both ends of the range."""

CLOCK_MHZ = 168.0
"""Of an STM32F4."""

PRECISIONS: tuple[Precision, ...] = ("double", "single")


def row(kind: str, part: Part, found: Vector) -> list[str]:
    """A line of the table: a part in its precision, run over a vector."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        written(around(part, found), folder)
        made = objects(part.name, folder)
        flash, ram = sizes(part.name, part.real, made, folder)
        graphs = [(folder / name).with_suffix(".ci").read_text() for name in made]
        depth = max(deepest(graphs, f"{part.name}_{entry}")[0] for entry in ("init", "step"))
        ran = counted(part, found, made, folder)
    return [
        kind, part.precision, f"{flash:,}", f"{ram:,}", f"{depth:,}", f"{ran.stack:,}", f"{ran.mean:,.0f}",
        f"{ran.most:,.0f}", f"{ran.most / CLOCK_MHZ:,.1f}", f"{ran.worst:.1g} {part.output.unit}",
    ]  # fmt: skip


def rows() -> Iterator[list[str]]:
    """All controllers of the catalogue in both precisions."""
    wrist = Wrist.flexion()
    for kind in EXEMPLARY:
        part = exemplary(kind, wrist)
        found = vector(part, wrist, STEPS)
        for precision in PRECISIONS:
            yield row(kind, part.at(precision), found)


if __name__ == "__main__":
    absent = missing()
    if absent:
        raise SystemExit(absent)
    into_page("python -m design.export.cortex", HEADING, HEAD, rows(), __doc__)
