"""The statements that people read first: of each claim one, by the best rung or on the worst branch."""

from collections.abc import Iterable

from design.robustness.assess import Assessment
from design.robustness.certificates.certificate import Certificate, Switching
from design.robustness.certificates.statements import DiesAway, of_class
from design.robustness.statement import Claim, Statement


def verdict(a: Assessment) -> list[Statement]:
    """Certificates, then predictions, then samples: of the rungs that are about one class of loops the one
    with the largest decay, of branches the worst."""
    others = [s for s in a.certificates if not isinstance(s.claim, DiesAway)]
    return [*_switching(a.ladder, a.left_out), *_worst(others), *_worst(a.predictions), *a.samples]


def _switching(rungs: Iterable[Certificate], left_out: tuple[str, ...]) -> list[Statement]:
    """Of each dead time a statement for each class of loops, the narrowest class first."""
    found = []
    for dead_time in dict.fromkeys(c.dead_time for c in rungs):
        for switching in Switching:
            of = [
                c
                for c in rungs
                if c.dead_time == dead_time and c.about is not None and c.about.switching is switching
            ]
            if of:
                found.append(of_class(switching, of, left_out))
    return found


def _worst(statements: Iterable[Statement]) -> list[Statement]:
    """Of statements that make one claim of several branches the one that holds least, or is the least."""
    rank = {False: 0, None: 1, True: 2}
    by_claim: dict[Claim, list[Statement]] = {}
    for s in statements:
        by_claim.setdefault(s.claim, []).append(s)
    return [
        min(of, key=lambda s: (rank[s.holds], s.value if s.value is not None else float("-inf")))
        for of in by_claim.values()
    ]
