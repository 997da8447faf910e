"""The statements that people read first: of each claim one, by the best rung or on the worst branch."""

from collections.abc import Callable, Iterable
from dataclasses import replace

from design.robustness.assess import Assessment
from design.robustness.certificates.certificate import Certificate
from design.robustness.certificates.continuous import popov
from design.robustness.certificates.statements import late, of_ladder
from design.robustness.statement import Statement

SAMPLED = "sampled: "
CLASSES: dict[str, Callable[[Certificate], bool]] = {
    "dies away however the slope switches, the regulator's law being fixed": lambda c: c.rung == popov.RUNG,
    "dies away however slope and regulator rate switch": lambda c: (
        c.rung != popov.RUNG and not c.rung.startswith(SAMPLED)
    ),
    "dies away however slope and regulator rate switch from one sample to the next": lambda c: (
        c.rung.startswith(SAMPLED)
    ),
}
"""Classes of loops, in words, and which rungs are about them; the narrowest first."""


def verdict(a: Assessment) -> list[Statement]:
    """Certificates, then predictions, then samples: of the rungs that are about one class of loops the one
    with the largest decay, of branches the worst."""
    rungs = {s.evidence["rung"] for s in a.certificates if "rung" in s.evidence}
    others = [s for s in a.certificates if s.evidence.get("rung") not in rungs]
    return [*_switching(a.ladder, a.left_out), *_worst(others), *_worst(a.predictions), *a.samples]


def _switching(rungs: Iterable[Certificate], left_out: tuple[str, ...]) -> list[Statement]:
    found = []
    for dead_time in dict.fromkeys(c.dead_time for c in rungs):
        for words, about in CLASSES.items():
            of = [c for c in rungs if about(c) and c.dead_time == dead_time]
            if not of:
                continue
            best = max(of, key=lambda c: (c.holds, c.decay or 0.0))
            (told,) = of_ladder([best], left_out)
            because = f"{best.rung.removeprefix(SAMPLED)}, {told.because}" if best.holds else _none(of)
            found.append(replace(told, statement=words + late(best), because=because))
    return found


def _none(rungs: list[Certificate]) -> str:
    """Why a class has no certificate, in a few words."""
    names = ", ".join(c.rung.removeprefix(SAMPLED) for c in rungs)
    exists = any("none exists" in c.why for c in rungs)
    return f"none found ({names})" + ("; none exists, since a word makes the class grow" if exists else "")


def _worst(statements: Iterable[Statement]) -> list[Statement]:
    """Of statements that make one claim of several branches the one that holds least, or is the least."""
    rank = {False: 0, None: 1, True: 2}
    by_claim: dict[str, list[Statement]] = {}
    for s in statements:
        by_claim.setdefault(s.statement, []).append(s)
    return [
        min(of, key=lambda s: (rank[s.holds], s.value if s.value is not None else float("-inf")))
        for of in by_claim.values()
    ]
