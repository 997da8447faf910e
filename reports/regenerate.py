"""The committed examples: which command makes each, and whether it still gives the same numbers.

    python -m reports.regenerate            makes them again, into reports/examples (some minutes)
    python -m reports.regenerate --check    makes them into build/examples and compares the numbers
    python -m reports.regenerate --check --made NAME    compares what lies in build/examples/NAME

Run from the project's root.  The comparison plays what build/examples/design holds, and robustness is
shown of the gains that the design has left in reports/examples, so the design comes first.  Where it finds
other gains, commit them and make these two again: a page names the commit.  A design that other sources
made is judged anew by the comparison, on a tenth of the samples: make it again first.  The check leaves out
the perturbed plants of the comparison and the MPC of the design, which take minutes.
"""

import argparse
import json
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from math import isclose, isfinite
from pathlib import Path
from typing import Any

EXAMPLES = Path("reports/examples")
BUILT = Path("build/examples")


@dataclass(frozen=True)
class Example:
    """command: words after ``wrist`` that make it, but for ``--out``; quick: those of the check, where they
    differ; page, record: its HTML and JSON; files: what is kept besides, by its name in the folder made;
    slow: paths of the record that the quick command leaves out."""

    command: tuple[str, ...]
    page: str
    record: str
    files: Mapping[str, str] = field(default_factory=dict)
    quick: tuple[str, ...] = ()
    slow: tuple[str, ...] = ()


DESIGNED = ("gains-flexion.toml", "gains-deviation.toml", "plant-flexion.toml", "plant-deviation.toml")
"""What a design recommends, and on which plants: kept, and read by the example after it."""

DESIGN = ("design", "plants/measured/examples/flexion", "plants/measured/examples/deviation")

ALL: Mapping[str, Example] = {
    "design": Example(
        (*DESIGN, "--mpc"),
        "design.html",
        "design.json",
        {"card.png": "design-card.png", **{n: n for n in DESIGNED}},
        DESIGN,
        ("*robust MPC*",),
    ),
    "comparison": Example(
        ("compare", "--design", f"{BUILT}/design", "--samples", "50", "--mpc-plants", "10"),
        "comparison.html",
        "comparison.json",
        {n: n for n in ("comparison.csv", "contest.csv", "steps-flexion.png", "paper.html")},
        ("compare", "--design", f"{BUILT}/design", "--samples", "0", "--mpc-plants", "0"),
        ("contest*", "ledger*"),
    ),
    "trace": Example(
        ("trace", "plants/measured/examples/deviation"),
        "trace.html",
        "trace.json",
        {"revised.toml": "revised.toml"},
    ),
    "robust": Example(
        ("robust", "--gains", f"{EXAMPLES}/{DESIGNED[0]}", "--plant", f"{EXAMPLES}/{DESIGNED[2]}"),
        "robust.html",
        "robust.json",
        {"worst.toml": "worst.toml", "gains.png": "robust-gains.png"},
    ),
}


@dataclass(frozen=True)
class Tolerance:
    """How far numbers may lie apart whose path matches a pattern, and why; None: they are not compared."""

    pattern: str
    relative: float | None
    absolute: float
    why: str


TOLERANCES = (
    Tolerance("made.*", None, 0.0, "version, commit and command are what differs; data and plants follow"),
    Tolerance("ledger.*", None, 0.0, "wall times"),
    Tolerance(
        "*robust LQI*", 0.35, 2.0, "a random search along a flat optimum: a solver's last digit decides"
    ),
    Tolerance("*spread_of_best_searches", None, 0.0, "a difference of nearly equal costs"),
    Tolerance("*map_feasible", 0.0, 3.0, "cells whose worst value lies on a limit"),
    Tolerance("*.std_error", 0.05, 0.0, "from differences of the residual, to two digits on the page"),
    Tolerance("correlation.*", 0.0, 0.05, "from the same differences, to one digit on the page"),
    Tolerance("certificates.*.margin", None, 0.0, "what a solver leaves beyond its own tolerance"),
    Tolerance("certificates.*.intervals", None, 0.0, "how often a sweep is split: a last digit decides"),
    Tolerance("certificates.*.forms.*", 0.05, 1e-6, "matrices of problems solved to 1e-8 at best"),
    Tolerance("standings.*MPC.tolerated_*", 0.25, 0.0051, "steps of a search, of 5 ms or 5 %"),
    Tolerance("certificates.*.value", 0.05, 0.0, "decays by bisection of problems solved to 1e-8 at best"),
    Tolerance("worst_case.greatest_excess", 0.25, 0.0, "a random search: any better scenario is welcome"),
    Tolerance("worst_case.excess_of", 0.0, 0.0, "which limit is the worst one"),
    Tolerance("worst_case.*", None, 0.0, "the scenario itself, of many that are nearly as bad"),
    Tolerance("samples.*.violations", 0.0, 3.0, "cases that lie on a limit"),
    Tolerance("samples.*", 0.02, 0.2, "shares [%] that follow the violations"),
    Tolerance("sampled.quantiles.*", 0.02, 1e-3, "order statistics of simulated times in whole samples"),
    Tolerance("recommended.*.worst_case.*", None, 0.0, "a random search: any better scenario is welcome"),
    Tolerance("decisions.*.worst_case.*", None, 0.0, "a random search: any better scenario is welcome"),
    Tolerance("decisions.*", 0.05, 3.0, "gains agree to 2 %, and samples that lie on a limit"),
    Tolerance("limits.*", 0.05, 1e-3, "worst values of gains that agree to 2 %, and of a random search"),
    Tolerance("designs.*.worst_*", None, 0.0, "a random search: any worse case is welcome"),
    Tolerance("designs.*PI + feedforward*", 0.35, 2.0, "a value of its ladder up or down: a search decides"),
    Tolerance("prices.*PI + feedforward*", 0.35, 0.05, "a value of its ladder up or down: a search decides"),
    Tolerance("designs.*", 0.02, 2.0, "gains agree to 2 %; rounds and cases until they do are no claim"),
    Tolerance("prices.*", 0.03, 0.02, "what follows of gains that agree to 2 %"),
    Tolerance("recommended.*", 0.03, 2e-3, "gains agree to 2 %, and what follows of them"),
    Tolerance("*settling*", 0.01, 0.01, "a band is left and entered where the curve is nearly flat"),
    Tolerance("*rise_time*", 0.01, 0.003, "whole samples of 1 ms"),
    Tolerance("*overshoot*", 0.01, 0.02, "per cent of the step; the tuned PI stands on this limit"),
    Tolerance("*steady*", 0.02, 1e-3, "what is left of the error at the end, far below the band"),
    Tolerance("*", 5e-3, 1e-6, "gains are searched to a thousandth, and what follows from them with them"),
)
"""Tolerances, the first that matches; the rest of a run is the same to rounding on one machine, and to
a few parts in a million on another, whose compiler fuses other products."""

NAMES = ("motion", "axis", "task", "controller", "statement", "branch", "rate", "dead_time_s", "rung",
         "kind", "metric", "name")  # fmt: skip
"""What tells records of a list apart, so that one that lacks some can be compared with one that does not."""

NUMBER = re.compile(r"[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def flat(record: Any, path: str = "") -> dict[str, Any]:
    """Every value of a JSON record by its path.

    >>> flat({"rows": [{"motion": "flexion", "IAE": 2.0}], "n": [1]})
    {'rows.flexion.motion': 'flexion', 'rows.flexion.IAE': 2.0, 'n.0': 1}
    """
    if isinstance(record, Mapping):
        items = [(str(k), v) for k, v in record.items()]
    elif isinstance(record, list):
        items = _named(record)
    else:
        return {path: record}
    found: dict[str, Any] = {}
    for name, value in items:
        found |= flat(value, f"{path}.{name}" if path else name)
    return found


def _named(items: list[Any]) -> list[tuple[str, Any]]:
    """Items of a list by what tells them apart, or by their place."""
    found: list[tuple[str, Any]] = []
    count: dict[str, int] = {}
    for place, item in enumerate(items):
        known = [str(item[n]) for n in NAMES if n in item] if isinstance(item, Mapping) else []
        name = "|".join(known) or str(place)
        count[name] = count.get(name, 0) + 1
        found.append((name if count[name] == 1 else f"{name}#{count[name]}", item))
    return found


def differences(committed: Any, fresh: Any, slow: tuple[str, ...] = ()) -> list[str]:
    """Where a fresh record says something else than a committed one, a line each; paths that match `slow`
    may lack in the fresh one."""
    old, new = flat(committed), flat(fresh)

    def left_out(path: str) -> bool:
        return any(fnmatchcase(path, p) for p in slow)

    said = [f"{p}: not made any more" for p in old if p not in new and not left_out(p)]
    said += [f"{p}: new, not in the committed example" for p in new if p not in old and not left_out(p)]
    for path in (p for p in new if p in old and not left_out(p)):
        tolerance = next(t for t in TOLERANCES if fnmatchcase(path, t.pattern))
        if not _agree(old[path], new[path], tolerance):
            said.append(f"{path}: {new[path]} against {old[path]} ({tolerance.why})")
    return said


def _agree(old: Any, new: Any, tolerance: Tolerance) -> bool:
    if tolerance.relative is None:
        return True
    if isinstance(old, str) and isinstance(new, str):  # numbers in words stand elsewhere as numbers
        return NUMBER.sub("#", old) == NUMBER.sub("#", new)
    if isinstance(old, bool) or isinstance(new, bool) or old is None or new is None:
        return old is new
    if not (isinstance(old, int | float) and isinstance(new, int | float)):
        return bool(old == new)
    if not (isfinite(old) and isfinite(new)):
        return old == new
    return isclose(old, new, rel_tol=tolerance.relative, abs_tol=tolerance.absolute)


def make(example: Example, folder: Path, quick: bool = False) -> None:
    """Run the command of an example; raises CalledProcessError where it does not end well."""
    words = (example.quick or example.command) if quick else example.command
    subprocess.run([sys.executable, "-m", "design.cli", *words, "--out", str(folder)], check=True)


def hand_on(example: Example, folder: Path) -> None:
    """Copy what commands of other examples read to where they do."""
    read = {word for other in ALL.values() for word in other.command}
    for source, name in example.files.items():
        if str(EXAMPLES / name) in read:
            shutil.copyfile(folder / source, EXAMPLES / name)


def keep(example: Example, folder: Path) -> None:
    """Copy what was made in a folder to the committed examples."""
    for source, name in {example.page: example.page, example.record: example.record, **example.files}.items():
        shutil.copyfile(folder / source, EXAMPLES / name)


def check(example: Example, folder: Path) -> list[str]:
    """What differs between a fresh example in a folder and the committed one: numbers, and headings that
    its page lacks."""
    before, after = (json.loads((f / example.record).read_text(encoding="utf-8")) for f in (EXAMPLES, folder))
    old, new = (_headings((f / example.page).read_text(encoding="utf-8")) for f in (EXAMPLES, folder))
    left = [h for h in new if h not in old]
    return [f"page: has no section “{h}”" for h in left] + differences(before, after, example.slow)


def _headings(page: str) -> list[str]:
    return re.findall(r"<h2 [^>]*>(.*?)</h2>", page)


def _known(name: str) -> str:
    if name not in ALL:
        raise argparse.ArgumentTypeError(f"no example {name!r}; one of {', '.join(ALL)}")
    return name


def main(arguments: list[str] | None = None) -> int:
    """Make or check the examples that are named, all where none is; 1 where some number differs."""
    parser = argparse.ArgumentParser(
        prog="python -m reports.regenerate", description=__doc__.partition("\n")[0] if __doc__ else None
    )
    parser.add_argument("names", nargs="*", type=_known, metavar="NAME", help=f"of {', '.join(ALL)}; or all")
    parser.add_argument("--check", action="store_true", help="compare with the committed ones, write nothing")
    parser.add_argument("--made", action="store_true", help=f"they are made already and lie in {BUILT}")
    given = parser.parse_args(arguments)
    if given.made and not given.check:
        parser.error("--made: only with --check; what is committed is made here")
    if not EXAMPLES.is_dir():
        parser.exit(2, f"no folder {EXAMPLES} here: run it from the root of a checkout\n")
    names, wrong = given.names or list(ALL), 0
    for name in names if not given.made else ():
        try:
            make(ALL[name], BUILT / name, quick=given.check)
        except subprocess.CalledProcessError as error:
            parser.exit(2, f"{name}: its command ended with {error.returncode}; what it said stands above\n")
        if not given.check:
            hand_on(ALL[name], BUILT / name)
    for name in names:  # after all are made: a page names the commit, and whether files differ from it
        if not given.check:
            keep(ALL[name], BUILT / name)
            continue
        said = check(ALL[name], BUILT / name)
        wrong += len(said)
        print(f"{name}: {f'{len(said)} differences' if said else 'the numbers of the committed example'}")
        for line in said[:40]:
            print(f"  {line}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
