"""Certificates as statements: what each rung says, and what it says of the step that is asked for."""

from collections.abc import Sequence

from design.robustness.certificates.certificate import Certificate
from design.robustness.statement import Statement


def statements(ladder: Sequence[Certificate]) -> list[Statement]:
    """One statement a rung; `value` is the decay rate [1/s] that was certified.

    A rung that found nothing says so (`holds` is None): a larger class of loops may be unstable, or a
    better function may exist; neither tells that the loop itself is unstable.
    """
    return [_statement(c) for c in ladder]


def _statement(c: Certificate) -> Statement:
    late = f", with {1000 * c.dead_time:g} ms of dead time" if c.dead_time else ""
    if c.holds:
        because = f"found by {c.solver}, confirmed outside it"
        if c.margin is not None:
            because += f" with a margin of {c.margin:.2g}"
    else:
        because = c.why
    evidence = {"rung": c.rung, "dead_time_s": c.dead_time, "solver": c.solver, "margin": c.margin}
    return Statement(
        "certificate", f"{c.rung}: {c.claim}{late}", True if c.holds else None,
        c.decay if c.holds else None, "1/s", because=because, evidence={**evidence, **c.evidence},
    )  # fmt: skip
