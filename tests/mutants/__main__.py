"""``python -m tests.mutants``: draw faults with a seed, run the tests that reach each, list survivors.

Each fault is put into a copy of the project.  Which tests reach it is recorded first (`tests.mutants.reach`);
the first that fails ends a run.  A mutant that makes a test run for more than five times as long as the
longest of its file took when recorded, and a minute more, counts as caught, as in mutmut and Cosmic Ray, and
is told apart; one whose tests as a whole do not end in time says nothing.  Mutants of ``equivalent.toml``
change nothing, for the reason given there, and are not run.  Exit codes: 0 at least `--ask` of a hundred
caught, 1 not.
"""

import argparse
import json
import shutil
import tempfile
import time
import tomllib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from tests.mutants.forked import prepare, pytest_forked
from tests.mutants.mutate import Mutant, drawn, mutants
from tests.mutants.reach import Reached, chosen, enclosing, importing, limits, naming, quickest, record, seen

ROOT = Path(__file__).parents[2]
EQUIVALENT = Path(__file__).parent / "equivalent.toml"
ROOMS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "laws": (
        ("plants/hysteresis", "plants/actuator", "plants/effects", "plants/lag.py", "plants/dynamics.py",
         "plants/wrist.py", "plants/simulation", "plants/equilibrium.py", "design/controllers"),
        ("laws/*", "oracles/*", "control/test_[fipt]*", "control/test_behind*", "control/test_cascade*",
         "control/test_export_hand*", "control/test_export_second*", "control/test_limit_effects*",
         "control/test_memory*", "control/test_mpc_loop*", "control/test_registered*", "control/test_spikes*",
         "design/test_effects*", "design/test_limits*", "design/test_tasks*", "measured/test_guess*",
         "robustness/test_lqi*", "robustness/test_remainder*", "robustness/test_structures*",
         "trace/test_excitation*", "trace/test_fitted*"),
    ),
    "kernels": (
        ("plants/kernel", "design/mpc"),
        ("kernel/*", "laws/test_k*", "laws/test_l*", "control/test_inverse*", "control/test_margins*",
         "control/test_mpc*", "control/test_export_[pr]*"),
    ),
    "statistics": (
        ("plants/measured/residual", "plants/measured/fitting/noise.py", "design/contest",
         "design/evaluation"),
        ("residual/*", "evaluation/*", "measured/test_[engl]*", "control/test_contest*",
         "control/test_break*", "design/test_t*", "oracles/test_metrics*", "robustness/test_sequences*"),
    ),
    "certificates": (
        ("design/robustness/certificates", "design/limit"), ("robustness/*", "control/test_limit*"),
    ),
    "export": (("design/export",), ("control/test_export*", "cli/test_export*")),
}  # fmt: skip
"""Sources, and the tests that are run on them, by what they are of."""
IMPORTING = (
    "control", "design", "evaluation", "kernel", "laws", "measured", "oracles", "residual", "robustness",
)  # fmt: skip
"""Folders of tests that are of one thing each: what imports a module is run on its faults, whatever its room;
pages, commands and searches of causes use nearly all, and take long."""
OF_ALL = ("tests/test_frozen.py",)
"""Tests of how any source is written."""


def sources(room: str) -> list[Path]:
    """The Python files of a room, without those that only gather."""
    found: list[Path] = []
    for name in ROOMS[room][0]:
        path = ROOT / name
        found += sorted(path.rglob("*.py")) if path.is_dir() else [path]
    return [p for p in found if p.name != "__init__.py"]


def files_of(room: str) -> list[str]:
    """The files of tests of a room, and those in `IMPORTING` that import a module of it."""
    wanted = importing(p.relative_to(ROOT) for p in sources(room))
    found = {p for name in ROOMS[room][1] for p in (ROOT / "tests").glob(name)}
    others = (p for folder in IMPORTING for p in (ROOT / "tests" / folder).glob("test_*.py"))
    found |= {p for p in others if wanted.search(p.read_text(encoding="utf-8"))}
    return sorted(str(p.relative_to(ROOT)) for p in found if p.name.startswith("test_") and p.suffix == ".py")


def equivalents() -> list[dict[str, str]]:
    """Mutants that change nothing: ``path``, ``after`` (the changed line), ``reason``."""
    return tomllib.loads(EQUIVALENT.read_text(encoding="utf-8")).get("mutant", [])


def survivors(room: str, kept: Path) -> list[Mutant]:
    """Those of a room that survived in the record of an earlier run, wherever their lines are now."""
    wanted = {
        (m["place"].rpartition(":")[0], m["after"])
        for m in json.loads(kept.read_text(encoding="utf-8"))["mutants"]
        if m["room"] == room and m["ended"] == "survived"
    }
    of, lines = ({w[i] for w in wanted} for i in (0, 1))
    every = [m for p in sources(room) if str(p.relative_to(ROOT)) in of for m in mutants(p, lines)]
    return [m for m in every if (str(m.path.relative_to(ROOT)), m.after) in wanted]


class First:
    """A plugin that runs the chosen tests in their order, all where none are given, and notes the first that
    fails."""

    def __init__(self, chosen: Sequence[str] = ()) -> None:
        self.rank = {test: place for place, test in enumerate(chosen)}
        self.found = ""

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        if not self.rank:
            return
        wanted = [i for i in items if i.nodeid in self.rank or not i.nodeid.startswith("tests/")]
        items[:] = sorted(wanted, key=lambda i: self.rank.get(i.nodeid, -1))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed and not self.found:
            self.found = report.nodeid

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed and not self.found:
            self.found = report.nodeid


def run(
    mutant: Mutant,
    files: list[str],
    plugin: Callable[[], Any],
    copy: Path,
    timeout: float,
    each: Mapping[str, float],
) -> tuple[str, str]:
    """How tests ended on a mutant: caught, held up, survived or out of time, and by which test.

    Held up is one test beyond its own limit of ``each`` [s], out of time all beyond ``timeout`` [s]."""
    path = mutant.path.relative_to(ROOT)
    target = copy / path
    whole = target.read_text(encoding="utf-8")
    target.write_text(mutant.text, encoding="utf-8")
    try:
        ended = pytest_forked(copy, ["-x", *files, str(path)], plugin, timeout, each)
    finally:
        target.write_text(whole, encoding="utf-8")
    if ended.code is None:
        return ("held up", ended.found) if ended.found else ("out of time", "")
    if ended.code in (0, 5):  # all passed, none chosen
        return "survived", ""
    return "caught", ended.found or "the process died"


def judged(
    mutant: Mutant,
    reached: dict[str, Reached],
    unknown: list[str],
    copy: Path,
    most: float,
    known: list[dict[str, str]],
) -> tuple[str, str]:
    """How a mutant ends, `run` with the tests that reach it; where they pass also with whole files of which
    that is not known, and for what is done on import, which no test is seen to reach, with all quick ones."""
    path = str(mutant.path.relative_to(ROOT))
    for other in known:
        if (other["path"], other["after"]) == (path, mutant.after):
            return "equivalent", other["reason"]
    source = mutant.path.read_text(encoding="utf-8")
    functions, enough, each = enclosing(source, path, mutant.line), 5.0 * most + 60.0, limits(reached)
    others = [] if seen(reached, functions) else quickest(reached, most)
    tries: list[tuple[list[str], list[str]]] = [([*OF_ALL], [])]
    for tests in (chosen(reached, functions, path, most), others):
        tries.append((list(dict.fromkeys(t.partition("::")[0] for t in tests)), tests))
    tries.append((naming(copy, unknown, Path(path), functions), []))
    ended = "survived", ""
    for files, tests in tries:
        if files and ended[0] == "survived":
            ended = run(mutant, files, partial(First, tests), copy, enough, each)
    return ended


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("--count", type=int, default=20, help="mutants of each room")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--room", choices=sorted(ROOMS), action="append")
    parser.add_argument("--most", type=float, default=60.0, help="seconds of tests for a mutant, as recorded")
    parser.add_argument("--ask", type=float, default=95.0)
    parser.add_argument("--only", default="", help="only mutants of files with this in their path")
    parser.add_argument("--again", type=Path, help="the survivors of an earlier --out, none drawn")
    parser.add_argument("--out", type=Path, default=Path("build/mutants.json"))
    asked = parser.parse_args()
    counts: Counter[str] = Counter()
    records: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder).resolve() / "project"
        left = shutil.ignore_patterns(".git", ".venv", "build", "__pycache__", "*.ipynb")
        shutil.copytree(ROOT, copy, ignore=left)
        prepare(Path(folder) / "cache")
        known = equivalents()
        for room in asked.room or ROOMS:
            reached, unknown = record(copy, files_of(room), Path("build/reach.json"), asked.most)
            files = [p for p in sources(room) if asked.only in str(p)]
            for mutant in (
                survivors(room, asked.again) if asked.again else drawn(files, asked.count, asked.seed)
            ):
                begun = time.monotonic()
                ended, by = judged(mutant, reached, unknown, copy, asked.most, known)
                counts[ended] += 1
                place = f"{mutant.path.relative_to(ROOT)}:{mutant.line}"
                took = time.monotonic() - begun
                print(f"{room}: {ended} ({took:.0f} s): {place}: {mutant.after} [{by}]", flush=True)
                records.append({
                    "room": room, "ended": ended, "place": place, "before": mutant.before,
                    "after": mutant.after, "by": by,
                })  # fmt: skip
                asked.out.parent.mkdir(parents=True, exist_ok=True)
                asked.out.write_text(json.dumps({"seed": asked.seed, "mutants": records}, indent=1) + "\n")
    caught, held = counts["caught"] + counts["held up"], counts["held up"]
    ended = caught + counts["survived"]
    print(f"{caught} of {ended} caught, {held} of them by a test that took five times its time and a minute;")
    print(f"{counts['survived']} survived; {counts['equivalent']} change nothing;")
    print(f"of {counts['out of time']} more the tests did not end in time, which says nothing")
    return int(caught < asked.ask / 100.0 * ended)


if __name__ == "__main__":
    raise SystemExit(main())
