"""How often a planned recording settles a tie, and how often a staircase of its length does.

Rigs of the tests' own simulator log little: one short recording to fit on.  Where the trace names effects
that others tie with, the recording that `wrist plan` asks for is made on the rig and added; and, apart, a
staircase.  A tie is settled where the trace then names exactly what the rig has, and nothing ties with it.

python -m tests.ties --count 10
"""

import argparse
import itertools
import tempfile
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plants.errors import InputError
from plants.measured.trace.plan import plan, rival, rivals_of
from plants.measured.trace.result import Trace
from tests.change.pairs import drawn
from tests.rig.campaign import logged_table, run_of, salt_of, write_description
from tests.rig.effects import OPEN
from tests.rig.rig import Rig
from tests.rig.suite import Case
from tests.trace.traces import trace_folder

POOR = ("small", "sine", "staircase", "steps")
"""Recordings of which a rig logs one to fit on, in turn."""

HELD_OUT = "task"
PLANNED, STAIRCASE = "planned", "stairs"
SECONDS = 60.0


@dataclass(frozen=True)
class Tie:
    """A rig whose log leaves a tie: what was named and what ties with it, and whether each further recording
    settles it."""

    number: int
    case: Case
    named: str
    settled: dict[str, bool]
    predicted: float


def named(trace: Trace) -> str:
    """Effects, each with what ties with it."""
    return ", ".join("|".join((e.name, *e.alternatives)) for e in trace.effects) or "nothing"


def right(trace: Trace, case: Case) -> bool:
    """Whether a trace names exactly what the rig has, and nothing ties with it."""
    return sorted(e.name for e in trace.effects) == sorted(case.effects) and not any(
        e.alternatives for e in trace.effects
    )


def write(rig: Rig, folder: Path, name: str, more: dict[str, np.ndarray]) -> Path:
    """A campaign of one short recording, the held-out one and further ones under commands at 1 kHz."""
    folder.mkdir(parents=True, exist_ok=True)
    other = "cross-coupling" in rig.effects
    runs = {n: run_of(rig, n, short=True) for n in (name, HELD_OUT)}
    runs |= {n: rig.play(command, salt_of(n)) for n, command in more.items()}
    for n, run in runs.items():
        logged_table(rig, n, run, other).to_csv(folder / f"{n}.csv", index=False, lineterminator="\n")
    write_description(folder, rig.axis, (name, *more, HELD_OUT), (HELD_OUT,))
    return folder


def tie(number: int, case: Case, rig: Rig, name: str, root: Path) -> Tie | None:
    """The tie that one short recording of a rig leaves; None where it leaves none, or is refused."""
    try:
        first = trace_folder(write(rig, root / "poor", name, {}))
    except InputError:
        return None
    if not any(e.alternatives for e in first.effects):
        return None
    own = [rival(s.model, s.model, s.name, s.name) for s in first.stages]
    asked = plan(rivals_of(first), own, SECONDS, seed=number)
    settled = {
        n: right(trace_folder(write(rig, root / n, name, {n: command})), case)
        for n, command in {PLANNED: asked.command, STAIRCASE: asked.staircase}.items()
    }
    return Tie(number, case, named(first), settled, min(asked.planned))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=10, help="ties to look at")
    parser.add_argument("--seed", type=int, default=0, help="of the first rigs; further seeds follow")
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    found: list[Tie] = []
    tried = 0
    rigs = itertools.chain.from_iterable(drawn(seed, 1000) for seed in itertools.count(asked.seed))
    for number, (case, rig) in enumerate(rigs, start=1):
        if len(found) == asked.count:
            break
        if not case.effects or any(e in OPEN for e in case.effects):
            continue
        tried += 1
        with tempfile.TemporaryDirectory() as root:
            of = tie(number, case, rig, POOR[number % len(POOR)], Path(root))
        if of is not None:
            found.append(of)
            print(
                f"{number:2d} {case.axis} {', '.join(case.effects)}: {of.named}; settled by {of.settled}, "
                f"predicted distance {of.predicted:.0f}",
                flush=True,
            )
    for name in (PLANNED, STAIRCASE):
        print(
            f"{name}: {sum(t.settled[name] for t in found)} of {len(found)} ties settled ({tried} rigs tried)"
        )


if __name__ == "__main__":
    main()
