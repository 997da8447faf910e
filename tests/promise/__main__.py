"""How often gains that are designed from a rig's campaign hold on that rig: traced, tuned under the whole
requirement, then closed on the rig itself, as it is and with 50 ms more of dead time.

python -m tests.promise --count 20
python -m tests.promise --only outside --count 5 --without-residual
python -m tests.promise --seed 507 --count 45 --names
python -m tests.promise --seed 507 --count 45 --names --closed between
python -m tests.promise --seed 507 --count 45 --names --without pressure_kPa
"""

import argparse
import tempfile
import time
import warnings
from collections.abc import Sequence
from pathlib import Path

from design.robustness.tuning.recommended import tune_candidates
from design.studies.design_study import Taken, required_of
from design.synthesis.designed_plant import designed
from design.synthesis.tuning import Region
from tests.change.pairs import drawn, write
from tests.promise.held import Held, held
from tests.rig.campaign import drop, record_closed
from tests.rig.effects import OPEN
from tests.rig.rig import Rig
from tests.rig.suite import Case
from tests.trace.traces import KNOWN, NOTHING, OUTSIDE, Judged, trace_folder

DIGITS = {"at-rows": 2, "between": 3}
"""Digits of the moments [s] at which set-points of a closed loop change, in logs with a row every 0.01 s."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=20, help="rigs drawn from the judging suite")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=1, help="number of the rig to begin with")
    parser.add_argument("--only", choices=("outside", "known"), help="effects outside the vocabulary, or not")
    parser.add_argument("--without-residual", action="store_true", help="also gains that know of no residual")
    parser.add_argument("--names", action="store_true", help="only trace, and count what is named rightly")
    parser.add_argument(
        "--closed", choices=DIGITS, help="with --names: logs of a closed loop, set-points at rows or between"
    )
    parser.add_argument(
        "--without", nargs="+", default=(), metavar="COLUMN", help="with --names: what was not logged"
    )
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    if asked.names:
        rigs = _rigs(asked.seed, asked.count, asked.only)[asked.first - 1 :]
        _names(rigs, asked.first, asked.closed, asked.without)
        return
    found: dict[str, list[tuple[str, Held]]] = {}
    for number, (case, rig) in enumerate(_rigs(asked.seed, asked.count, asked.only), start=1):
        if number >= asked.first:
            _rig(number, case, rig, asked.without_residual, found)
    for name, rigs in found.items():
        for said in sorted({v for v, _ in rigs}):
            of = [h for v, h in rigs if v == said]
            kept, plain = sum(h.kept for h in of), sum(h.kept_as_it_is for h in of)
            print(f"{name}, {said}: {plain} of {len(of)} hold on the rig, {kept} with 50 ms more too")


def _names(rigs: list[tuple[Case, Rig]], first: int, closed: str | None, without: Sequence[str] = ()) -> None:
    """Trace rigs from logs in open loop, or closed, without some columns; a line for each, and how many are
    right by what they have."""
    judged = []
    for number, (case, rig) in enumerate(rigs, start=first):
        truth = {
            kind: [e for e in case.effects if (e in OPEN) == (kind == "open")] for kind in ("effects", "open")
        }
        with tempfile.TemporaryDirectory() as root:
            other = "cross-coupling" in case.effects
            folder = (
                record_closed(rig, Path(root), DIGITS[closed], other) if closed else write(rig, Path(root))
            )
            drop(folder, without)
            judged.append(Judged(f"{number:2d}", case.axis, truth, trace_folder(folder)))
        print("right" if judged[-1].right else "WRONG", judged[-1], f"{judged[-1].ratio:.2f}", flush=True)
    for kind, words in {
        KNOWN: "with effects",
        NOTHING: "without an effect",
        OUTSIDE: "of other causes",
    }.items():
        of = [j for j in judged if j.wanted == kind]
        exact = sum(j.effects == sorted(j.truth["effects"]) for j in of)
        verdicts = sum(j.trace.verdict == kind for j in of)
        print(f"{words}: {len(of)} rigs, named exactly {exact}, verdict {kind} {verdicts}")


def _rigs(seed: int, count: int, only: str | None) -> list[tuple[Case, Rig]]:
    """The first rigs of the suite in its order, all or of one kind."""
    of_kind = [
        (case, rig)
        for case, rig in drawn(seed, 1000)
        if only is None or (only == "outside") == any(e in OPEN for e in case.effects)
    ]
    return of_kind[:count]


def _rig(number: int, case: Case, rig: Rig, bare: bool, found: dict[str, list[tuple[str, Held]]]) -> None:
    """Trace, tune and close the loop on one rig; a line for each controller."""
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as root:
        trace = trace_folder(write(rig, Path(root)))
    named = ", ".join(e.name for e in trace.effects) or "nothing"
    has = ", ".join(f"{e} {case.variants.get(e, '')}".strip() for e in case.effects) or "nothing"
    print(f"{number:2d} {case.axis}, has {has}; {trace.verdict}, named {named}", flush=True)
    plant = designed(trace.revised)
    for name, taken in {
        "gains": Taken(),
        **({"without residual": Taken(remainder=True)} if bare else {}),
    }.items():
        required = required_of(plant, taken)
        tuned = tune_candidates(required, Region.of(required.wrist))
        gains = tuned.best.final.gains
        seen = held(rig, gains, trace.revised)
        promised = "held in the model" if tuned.best.holds else "no gains hold in the model"
        found.setdefault(name, []).append((f"{trace.verdict}, {promised}", seen))
        said = ", ".join(f"{k} {v:.3g}" for k, v in gains.items())
        print(
            f"   {name}: {said} ({'held' if tuned.best.holds else tuned.best.ended} in the model); {seen}; "
            f"{time.perf_counter() - began:.0f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
