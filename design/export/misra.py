"""Where exported C departs from MISRA C:2012: python -m design.export.misra writes it into docs/targets.md.

What cppcheck's add-on and its own checks find in the sources of every controller, and why each stays.  The
command ends with 1 where something is found that is not listed here.
"""

import re
import shutil
import subprocess
import tempfile
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from design.export.part import Part
from design.export.rendering import render
from design.export.table import EXEMPLARY, exemplary, into_page
from plants.errors import InputError
from plants.wrist import Wrist

HEADING = "## Where the C departs from MISRA"
HEAD = ("rule", "category", "where", "times", "why it stays")
OWN, LAW = "the controller", "CasADi's law"


class RuleBreach(NamedTuple):
    """What was found: a rule of MISRA C:2012, or the name of one of cppcheck's own checks, and where."""

    rule: str
    where: str


class Deviation(NamedTuple):
    """What stays: the rule's category as MISRA has it, and why."""

    category: str
    why: str


DEVIATIONS: Mapping[RuleBreach, Deviation] = {
    RuleBreach("2.5", OWN): Deviation("advisory", "the header's macros (period, range) are for who calls it"),
    RuleBreach("8.9", OWN): Deviation("advisory", "the tables of the QP stand before the functions"),
    RuleBreach("15.5", OWN): Deviation("advisory", "a sample that is refused returns at once"),
    RuleBreach("8.4", LAW): Deviation("required", "the law has no header: NAME.c declares it"),
    RuleBreach("10.3", LAW): Deviation("required", "CasADi keeps truths in numbers, and writes 0 for 0.0"),
    RuleBreach("12.3", LAW): Deviation("advisory", "CasADi declares all intermediate results in one line"),
    RuleBreach("20.10", LAW): Deviation("advisory", "CasADi gives its names the law's prefix by ##"),
}  # fmt: skip


def found_in(part: Part) -> Counter[RuleBreach]:
    """What cppcheck finds in the header and the sources of a part, and how often.

    Raises InputError where cppcheck is missing or fails.
    """
    if shutil.which("cppcheck") is None:
        raise InputError("not on this machine: cppcheck; apt-get install cppcheck")
    n = part.name
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / f"{n}.h").write_text(render("law.h.jinja", part), encoding="utf-8")
        (folder / f"{n}.c").write_text(render(part.template, part, **part.constants), encoding="utf-8")
        (folder / f"{n}_law.c").write_text(part.code, encoding="utf-8")
        words = ["--addon=misra", "--std=c99", "--enable=warning,style,portability", "--template={file}:{id}"]
        done = subprocess.run(
            ["cppcheck", "-q", *words, f"{n}.c", f"{n}_law.c"],
            cwd=folder, capture_output=True, text=True, check=False, timeout=600,
        )  # fmt: skip
    if done.returncode:
        raise InputError(f"cppcheck failed: {' '.join((done.stdout + done.stderr).split())[:300]}")
    shown = re.findall(r"^(\w+\.[ch]):(?:misra-c2012-)?(\S+)$", done.stderr, re.MULTILINE)
    return Counter(RuleBreach(rule, LAW if file == f"{n}_law.c" else OWN) for file, rule in shown)


def row(finding: RuleBreach, times: int) -> list[str]:
    """A line of the table."""
    known = DEVIATIONS.get(finding, Deviation("", "not listed"))
    return [finding.rule, known.category, finding.where, str(times), known.why]


def main() -> None:
    """Command line."""
    wrist = Wrist.flexion()
    try:
        found = sum((found_in(exemplary(kind, wrist)) for kind in EXEMPLARY), Counter[RuleBreach]())
    except InputError as error:
        raise SystemExit(str(error)) from None
    order = [*DEVIATIONS, *sorted(found.keys() - DEVIATIONS.keys())]
    rows = [row(finding, found[finding]) for finding in order if found[finding]]
    into_page("python -m design.export.misra", HEADING, HEAD, rows, __doc__)
    if found.keys() - DEVIATIONS.keys():
        raise SystemExit(1)


if __name__ == "__main__":
    main()
