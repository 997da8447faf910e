"""Certificates as statements: what each rung says of the loop, and what of the step that is asked for."""

from collections.abc import Sequence

from design.robustness.certificates.certificate import Certificate
from design.robustness.certificates.continuous.virgin import VirginBounds
from design.robustness.statement import Statement


def of_ladder(rungs: Sequence[Certificate], left_out: Sequence[str] = ()) -> list[Statement]:
    """One statement a rung; `value` is the decay rate [1/s] that was certified; left_out: effects of the
    plant that the loops of the rungs do not have.

    A rung that found nothing says so (`holds` is None): a larger class of loops may be unstable, or a
    better function may exist; neither tells that the loop itself is unstable.
    """
    return [_statement(c, left_out) for c in rungs]


def _statement(c: Certificate, left_out: Sequence[str]) -> Statement:
    because = c.why
    if c.holds:
        because = f"found by {c.solver}, confirmed outside it"
        if c.margin is not None:
            because += f" with a margin of {c.margin:.2g}"
        if left_out:
            because += f"; of the wrist without {', '.join(left_out)}"
    evidence = {"rung": c.rung, "dead_time_s": c.dead_time, "solver": c.solver, "margin": c.margin}
    return Statement(
        "certificate", f"{c.rung}{late(c)}: {c.claim}", True if c.holds else None,
        c.decay if c.holds else None, "1/s", because=because, evidence={**evidence, **c.evidence},
    )  # fmt: skip


def late(c: Certificate) -> str:
    """The dead time of a certificate, in words; empty where there is none."""
    return f", {1000 * c.dead_time:g} ms of dead time" if c.dead_time else ""


def of_step(rungs: Sequence[Certificate], step: float) -> list[Statement]:
    """Whether the command stays within its range for a step [deg], by the rungs that found a region; one
    statement a dead time, of the rung that covers the largest step."""
    found = []
    for dead_time in dict.fromkeys(c.dead_time for c in rungs):
        known = [
            (c.evidence["region"]["largest_step_deg"], c)
            for c in rungs
            if c.dead_time == dead_time
            and c.holds
            and c.evidence.get("region", {}).get("largest_step_deg") is not None
        ]
        if not known:
            continue
        largest, best = max(known, key=lambda pair: pair[0])
        covered = abs(step) <= largest
        found.append(
            Statement(
                "certificate",
                f"a step of {step:g} deg from a line never meets the end of the command{late(best)}",
                True if covered else None, float(largest), "deg",
                because=f"{best.rung}: steps up to this start within a set that is never left and in which "
                "the command is not clipped",
            )
        )  # fmt: skip
    return found


def of_virgin_curve(bounds: VirginBounds, step: float) -> Statement:
    """How long a step [deg] from rest stays on the virgin curve, which has slope 0 and is left for good."""
    left = bounds.leaves
    because = bounds.why or f"not before {1000 * bounds.earliest:.3g} ms, for any rate from k_slow to k_fast"
    return Statement(
        "certificate", f"a step of {step:+g} deg from rest leaves the virgin curve by this time", left,
        float(bounds.latest) if left else None, "s", "virgin", because, bounds.record,
    )  # fmt: skip
