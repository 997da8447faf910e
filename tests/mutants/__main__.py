"""``python -m tests.mutants``: draw faults with a seed, run tests of the same room on each, list survivors.

Each fault is put into a copy of the project.  The tests are those of its room that name the module, or what
it defines; the first that fails ends a run.  Exit codes: 0 at least `--ask` of a hundred caught, 1 not.
"""

import argparse
import ast
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from tests.mutants.mutate import Mutant, drawn

ROOT = Path(__file__).parents[2]
ROOMS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "laws": (
        ("plants/hysteresis", "plants/actuator", "plants/effects", "plants/lag.py", "plants/dynamics.py",
         "plants/wrist.py",         "plants/simulation", "plants/equilibrium.py", "design/controllers"),
        ("tests/laws", "tests/oracles", "tests/control"),
    ),
    "kernels": (("plants/kernel", "design/mpc"), ("tests/kernel", "tests/laws", "tests/control")),
    "statistics": (
        ("plants/measured/residual", "plants/measured/noise.py", "design/contest", "design/evaluation"),
        ("tests/residual", "tests/measured", "tests/control", "tests/evaluation"),
    ),
    "certificates": (
        ("design/robustness/certificates", "design/limit"), ("tests/robustness", "tests/control"),
    ),
    "export": (("design/export",), ("tests/control",)),
}  # fmt: skip
"""Sources and tests by what they are of."""

MOST = 10
"""Test files that are run on a mutant."""

DEFINITIONS = (ast.ClassDef, ast.FunctionDef)


def sources(room: str) -> list[Path]:
    """The Python files of a room, without those that only gather."""
    found: list[Path] = []
    for name in ROOMS[room][0]:
        path = ROOT / name
        found += sorted(path.rglob("*.py")) if path.is_dir() else [path]
    return [p for p in found if p.name != "__init__.py"]


def asked_of(path: Path, room: str) -> list[str]:
    """Test files of a room that name a module, or what it defines, those first that do it most; and its own
    examples."""
    module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
    package, _, name = module.rpartition(".")
    defined = [n.name for n in ast.parse(path.read_text(encoding="utf-8")).body if isinstance(n, DEFINITIONS)]
    public = "|".join(n for n in defined if not n.startswith("_") and len(n) > 4) or "-"
    wanted = re.compile(
        rf"{re.escape(module)}\b|from {re.escape(package)} import [^\n]*\b{name}\b|\b({public})\b"
    )
    found = Counter({
        str(p.relative_to(ROOT)): len(wanted.findall(p.read_text(encoding="utf-8")))
        for folder in ROOMS[room][1]
        for p in (ROOT / folder).glob("test_*.py")
    })  # fmt: skip
    near = [p for p, count in found.most_common(MOST) if count] or sorted(found)
    return [*near, str(path.relative_to(ROOT))]


def run(mutant: Mutant, room: str, copy: Path, timeout: float) -> tuple[str, str]:
    """How the tests ended on a mutant: caught, survived or out of time, and by which test."""
    target = copy / mutant.path.relative_to(ROOT)
    whole = target.read_text(encoding="utf-8")
    target.write_text(mutant.text, encoding="utf-8")
    words = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "--no-header"]
    environment = os.environ | {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1", "MPLBACKEND": "Agg"}
    try:
        said = subprocess.run(
            [*words, *asked_of(mutant.path, room)], cwd=copy, env=environment, capture_output=True, text=True,
            timeout=timeout, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return "out of time", ""
    finally:
        target.write_text(whole, encoding="utf-8")
    if said.returncode == 0:
        return "survived", ""
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", said.stdout, re.MULTILINE)
    return "caught", failed[1] if failed else said.stdout[-200:]


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("--count", type=int, default=20, help="mutants of each room")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--room", choices=sorted(ROOMS), action="append")
    parser.add_argument("--timeout", type=float, default=600.0, help="seconds for the tests of one")
    parser.add_argument("--ask", type=float, default=95.0)
    parser.add_argument("--out", type=Path, default=Path("build/mutants.json"))
    asked = parser.parse_args()
    counts: Counter[str] = Counter()
    records = []
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "project"
        left = shutil.ignore_patterns(".git", ".venv", "build", "__pycache__", "*.ipynb")
        shutil.copytree(ROOT, copy, ignore=left)
        for room in asked.room or ROOMS:
            for mutant in drawn(sources(room), asked.count, asked.seed):
                begun = time.monotonic()
                ended, by = run(mutant, room, copy, asked.timeout)
                counts[ended] += 1
                place = f"{mutant.path.relative_to(ROOT)}:{mutant.line}"
                print(
                    f"{room}: {ended} ({time.monotonic() - begun:.0f} s): {place}: {mutant.after} [{by}]",
                    flush=True,
                )
                records.append({
                    "room": room, "ended": ended, "place": place, "before": mutant.before,
                    "after": mutant.after, "by": by,
                })  # fmt: skip
                asked.out.parent.mkdir(parents=True, exist_ok=True)
                asked.out.write_text(json.dumps({"seed": asked.seed, "mutants": records}, indent=1) + "\n")
    caught, ended = counts["caught"], counts["caught"] + counts["survived"]
    print(f"{caught} of {ended} caught; {counts['survived']} survived, some of which may change nothing;")
    print(f"of {counts['out of time']} more the tests did not end in time, which says nothing")
    return int(caught < asked.ask / 100.0 * ended)


if __name__ == "__main__":
    raise SystemExit(main())
