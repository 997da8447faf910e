"""Targets by controllers by largest difference, under each hysteresis law: python -m design.export.table
writes docs/targets.md.

Every target is run over the same samples, with noise, spikes, lost samples, references out of reach: C by the
compiler of this machine, units by FMPy.  Structured text is run by the tests, since no tool here does.
"""

import argparse
import re
import subprocess
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from design.export.catalogue import CATALOGUE, part
from design.export.formats.fmu import FMI, unit
from design.export.formats.folder import around
from design.export.formats.targets import VERSIONS
from design.export.part import Part
from design.export.vectors import STEPS, Vector, vector
from plants.errors import InputError
from plants.files import write_atomically
from plants.hysteresis import PrandtlIshlinskii
from plants.wrist import Wrist

PAGE = Path("docs/targets.md")
HEADING = "## Deviation from Python"
HEADING_OF_PLAYS = "## Deviation under the second hysteresis law"
HEAD = ("controller", "unit", "C, double", "C, single", "FMI 2.0", "FMI 3.0")

PLAYS = PrandtlIshlinskii(
    v0=0.08, v=(0.12, 0.09, 0.07), reach=34.0, span=9.0, b2=0.85, b1=0.9, c1=1.1, c2=1.05
)
"""About as wide and as steep as the built-in flexion's four segments; curved, its reversals rounded."""


def of_plays(wrist: Wrist) -> Wrist:
    """A wrist with the same regulator and lag whose hysteresis is a sum of plays."""
    return replace(wrist, hysteresis=PLAYS)


EXEMPLARY = (
    *CATALOGUE,
    *(f"{kind} --gains {CATALOGUE[kind].example}" for kind in CATALOGUE if "mpc" in kind),
)
"""What the tables show: each controller of the catalogue, the MPCs also with a dead time in their model."""


def exemplary(kind: str, wrist: Wrist) -> Part:
    """The part of one of `EXEMPLARY`; where it names no gains those that are used where none are given, else
    those that the help shows."""
    kind, _, text = kind.partition(" --gains ")
    entry = CATALOGUE[kind]
    if not text and entry.default is not None:
        return part(kind, "flexion", wrist)
    return part(kind, "flexion", wrist, tuple(map(float, (text or entry.example).split(","))))


def row(kind: str, wrist: Wrist, steps: int = STEPS) -> list[str]:
    """A line, of one of `EXEMPLARY`: it, unit, C in double and in single precision, units of FMI 2.0 and 3.0.

    The vector is made once, which takes longer than all that is compiled and run.
    """
    one = exemplary(kind, wrist)
    found = vector(one, wrist, steps)
    off = [difference_in_c(one.at(precision), found) for precision in ("double", "single")]
    off += [difference_in_unit(one, found, fmi) for fmi in VERSIONS]
    return [kind, one.output.unit, *(f"{x:.1g}" for x in off)]


def difference_in_c(made: Part, found: Vector) -> float:
    """Largest difference of the compiled C from Python over a test vector, in the unit of the output.

    Raises RuntimeError, with what the compiler said, where it does not compile.
    """
    with tempfile.TemporaryDirectory() as place:
        written(around(made, found), Path(place))
        said = subprocess.run(["make", "check"], cwd=place, capture_output=True, text=True, check=False)
    shown = re.search(r"largest difference (\S+)", said.stdout)
    if shown is None:
        raise RuntimeError(said.stdout + said.stderr)
    return float(shown[1])


def difference_in_unit(made: Part, found: Vector, fmi: FMI) -> float:
    """Largest difference of a functional mock-up unit from Python over a test vector."""
    import fmpy

    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / f"{made.name}.fmu"
        path.write_bytes(unit(made, around(made, found), fmi))
        described = fmpy.read_model_description(str(path))
        loaded: Any = fmpy.instantiate_fmu(
            fmpy.extract(str(path), f"{place}/unit"), described, "CoSimulation"
        )
        at = {v.name: v.valueReference for v in described.modelVariables}
        put, get = (getattr(loaded, f"{w}{'Real' if fmi == '2.0' else 'Float64'}") for w in ("set", "get"))
        put([at["start_pressure_kPa"], at["start_angle_deg"]], [found.pressure, found.angle])
        loaded.enterInitializationMode()
        loaded.exitInitializationMode()
        worst = 0.0
        for k, seen in enumerate(found.rows):
            put([at[f.member] for _, f in made.read], [float(seen[i]) for i, _ in made.read])
            loaded.doStep(k * made.period, made.period)
            worst = max(worst, abs(get([at[made.output.member]])[0] - float(seen[-1])))
        loaded.terminate()
        loaded.freeInstance()
    return worst


def written(files: dict[str, str], folder: Path) -> None:
    """Write files by name into a folder."""
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")


def told(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown; each row is shown as soon as it is there.

    >>> print(told(("law", "V"), [("pi", "0")]))
    pi 0
    | law | V |
    | --- | --- |
    | pi | 0 |
    """
    lines: list[Sequence[str]] = [head, ["---"] * len(head)]
    for one in rows:
        print(*one, flush=True)
        lines.append(one)
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def replaced(page: str, heading: str, table: str) -> str:
    """A page with a table in the place of the first one under a heading.

    Raises InputError where there is none.

    >>> replaced("## A\\nwords\\n\\n| x |\\n| --- |\\n\\nrest", "## A", "| y |")
    '## A\\nwords\\n\\n| y |\\n\\nrest'
    """
    before, found, after = page.partition(heading + "\n")
    there = re.search(r"^\|.*\n(?:\|.*\n)*", after.split("\n## ")[0] + "\n", re.MULTILINE)
    if not found or there is None:
        raise InputError(f"no table under {heading!r}; restore the page")
    return before + found + after[: there.start()] + table + "\n" + after[there.end() :]


def into_page(
    prog: str, heading: str, head: Sequence[str], rows: Iterable[Sequence[str]], words: str | None
) -> None:
    """The command line of a table: makes it and puts it under its heading into the page.

    Raises InputError, before anything is made, where the page has no place for it.
    """
    parser = argparse.ArgumentParser(prog=prog, description=words)
    parser.add_argument("--page", type=Path, default=PAGE, help="the page that the table is put into")
    page = parser.parse_args().page
    try:
        replaced(page.read_text(encoding="utf-8"), heading, "")
        table = told(head, rows)  # takes minutes, in which the page may change
        write_atomically(page, replaced(page.read_text(encoding="utf-8"), heading, table))
    except (OSError, InputError) as error:
        raise SystemExit(f"{page}: {error}") from None


if __name__ == "__main__":
    flexion = Wrist.flexion()
    for heading, wrist in ((HEADING, flexion), (HEADING_OF_PLAYS, of_plays(flexion))):
        into_page(
            "python -m design.export.table", heading, HEAD, map(partial(row, wrist=wrist), EXEMPLARY), __doc__
        )
