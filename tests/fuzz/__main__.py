"""``python -m tests.fuzz``: try bad input of every kind, count what failed, print a table.

Exit codes: 0 nothing failed, 1 something did.
"""

import argparse
import json
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, Phase, given, seed, settings

from tests.fuzz.rooms import Room, rooms
from tests.fuzz.sandbox import FAULTS, Sandbox


def tried(room: Room, tries: int, number: int, box: Sandbox) -> tuple[Counter[str], list[str]]:
    """How many tries of a room ended how, and those that failed, in words."""
    counts: Counter[str] = Counter()
    failed: list[str] = []

    @seed(number)
    @settings(
        max_examples=tries, database=None, deadline=None, phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(room.given)
    def each(what: Any) -> None:
        if counts["tried"] >= tries:
            return
        with box.fresh():
            outcome = room.attempt(box, what)
        counts["tried"] += 1
        counts["taken" if outcome.code in (0, 1) else "refused"] += 1
        for fault in outcome.faults:
            counts[fault] += 1
        if outcome.faults:
            failed.append(
                f"{', '.join(outcome.faults)}: {what!r:.600}: {outcome.code} {outcome.err[-300:]!r}"
            )

    while counts["tried"] < tries:  # what was tried already, hypothesis does not try again
        before = counts["tried"]
        each()
        number += 1
        if counts["tried"] == before:
            break
        seed(number)(each)
    return counts, failed


def table(found: dict[str, Counter[str]]) -> str:
    """The counts as a table in Markdown."""
    columns = ("tried", "refused", "taken", *FAULTS)
    rows = [(name, *(str(counts[c]) for c in columns)) for name, counts in found.items()]
    total = sum(found.values(), Counter[str]())
    rows.append(("all", *(str(total[c]) for c in columns)))
    lines = ["| what | " + " | ".join(columns) + " |", "|" + " --- |" * (len(columns) + 1)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--tries", type=int, default=5000, help="tries in all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--room", help="only this one")
    parser.add_argument("--out", type=Path, default=Path("build/fuzz.json"))
    asked = parser.parse_args()
    found: dict[str, Counter[str]] = {}
    failures: dict[str, list[str]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, room in rooms().items():
            if asked.room in (None, name):
                tries = asked.tries if asked.room else max(1, round(asked.tries * room.share))
                found[name], failures[name] = tried(room, tries, asked.seed, Sandbox(Path(folder) / "box"))
                print(f"{name}: {dict(found[name])}", file=sys.stderr)
    print(table(found))
    for name, failed in failures.items():
        for words in failed[:10]:
            print(f"{name}: {words}", file=sys.stderr)
    asked.out.parent.mkdir(parents=True, exist_ok=True)
    record = {"seed": asked.seed, "counts": {n: dict(c) for n, c in found.items()}, "failed": failures}
    asked.out.write_text(json.dumps(record, indent=1) + "\n")
    return int(any(failures.values()))


if __name__ == "__main__":
    raise SystemExit(main())
