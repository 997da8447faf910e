"""Certificates as statements: what each rung says of the loop, and what of the step that is asked for."""

from collections.abc import Sequence
from dataclasses import dataclass

from design.robustness.certificates.certificate import Certificate, LoopClass, Switching
from design.robustness.certificates.continuous.virgin import VirginBounds
from design.robustness.certificates.reasons import NoCertificate, OtherLaw
from design.robustness.certificates.sampled.words import Word
from design.robustness.statement import Claim, Reason, Statement
from design.status import Status, of_proof


@dataclass(frozen=True)
class DiesAway(Claim):
    """Every loop of a class, behind a dead time [s], decays: what a rung would prove."""

    rung: str
    about: LoopClass | None
    dead_time: float


@dataclass(frozen=True)
class ClassDiesAway(Claim):
    """Every loop in which so much may switch, behind a dead time [s], decays."""

    switching: Switching
    dead_time: float


@dataclass(frozen=True)
class StaysInRange(Claim):
    """A step [deg] from a line never meets the end of the command, with a dead time [s]."""

    step: float
    dead_time: float


@dataclass(frozen=True)
class TasksDieAway(Claim):
    """Every run of the tasks, steps [deg] and returns, comes to where the loop decays for ever at the rate
    that is the statement's value, with a dead time [s], sampled, the command with its range."""

    step: float
    dead_time: float


@dataclass(frozen=True)
class LeavesVirginCurve(Claim):
    """A step [deg] from rest leaves the virgin curve by the time that is the statement's value."""

    step: float


@dataclass(frozen=True)
class Confirmed(Reason):
    """A solver found a function, the check outside it has this margin (None: has none); left_out: effects of
    the plant that the loop lacks; name: of the rung, where it is of a class."""

    solver: str
    margin: float | None
    left_out: tuple[str, ...]
    name: str = ""


@dataclass(frozen=True)
class NotFound(Reason):
    """A rung found nothing, for a reason; word: that shows that there is nothing to be found."""

    reason: NoCertificate | None
    word: Word | None


@dataclass(frozen=True)
class NoneFound(Reason):
    """None of the rungs about a class found anything, by name; word: as in `NotFound`, of any."""

    names: tuple[str, ...]
    word: Word | None


@dataclass(frozen=True)
class Covered(Reason):
    """Steps up to the statement's value start within a set of a rung that is never left, unclipped."""

    rung: str


@dataclass(frozen=True)
class Unclipped(Reason):
    """None of the runs of the task meets an end of the command, before it comes to the region of a rung or
    after."""

    rung: str
    runs: int


@dataclass(frozen=True)
class Arrive(Reason):
    """How many of the runs come into the region of a rung for good, at the latest at a time [s] after the
    last reference began, off by so much [deg] at most from then on; clipped: how many met an end of the range
    before; slowest [1/s]: decay of the slowest pole, which no rate exceeds; left_out: effects of the plant
    that the runs lack."""

    rung: str
    runs: int
    arrive: int
    latest: float | None
    off: float | None
    clipped: int
    slowest: float
    left_out: tuple[str, ...]


@dataclass(frozen=True)
class VirginTimes(Reason):
    """Between which times the curve is left, for good, or what keeps a step on it."""

    bounds: VirginBounds


def of_ladder(rungs: Sequence[Certificate], left_out: Sequence[str] = ()) -> list[Statement]:
    """One statement a rung; `value` is the decay rate [1/s] that was certified; left_out: effects of the
    plant that the loops of the rungs do not have.

    A rung that found nothing is open: a larger class of loops may be unstable, or a better function may
    exist; neither tells that the loop itself is unstable.  Where a loop of the class is known to grow, what
    the rung claims is disproved, which says nothing against the real loop either.
    """
    return [_statement(c, DiesAway(c.rung, c.about, c.dead_time), left_out) for c in rungs]


def of_class(switching: Switching, rungs: Sequence[Certificate], left_out: Sequence[str] = ()) -> Statement:
    """The statement about a class of loops, by the rung with the largest decay of those about it, which have
    one dead time."""
    best = max(rungs, key=lambda c: (c.holds, c.decay or 0.0))
    claim = ClassDiesAway(switching, best.dead_time)
    if best.holds:
        return _statement(best, claim, left_out, best.name)
    disproved = next((c for c in rungs if c.status is Status.DISPROVED), best)
    reason: Reason = NoneFound(tuple(c.name for c in rungs), disproved.word)
    if isinstance(best.reason, OtherLaw):
        reason = NotFound(best.reason, None)
    return _of(disproved, claim, reason)


def _statement(c: Certificate, claim: Claim, left_out: Sequence[str], name: str = "") -> Statement:
    reason: Reason = NotFound(c.reason, c.word)
    if c.holds:
        reason = Confirmed(c.solver, c.margin, tuple(left_out), name)
    return _of(c, claim, reason)


def _of(c: Certificate, claim: Claim, reason: Reason) -> Statement:
    holds = {Status.PROVED: True, Status.DISPROVED: False}.get(c.status)
    evidence = {"rung": c.rung, "dead_time_s": c.dead_time, "solver": c.solver, "margin": c.margin}
    return Statement(
        c.status, claim, holds, c.decay if c.holds else None, reason, "1/s",
        evidence={**evidence, **c.evidence},
    )  # fmt: skip


def of_step(rungs: Sequence[Certificate], step: float) -> list[Statement]:
    """Whether the command stays within its range for the step [deg] of the task, by the rungs that found a
    region, and by the runs that come to one; one statement a dead time, of the rung that covers the largest
    step."""
    found = []
    for dead_time in dict.fromkeys(c.dead_time for c in rungs):
        played = [
            (c, c.evidence["tasks"]) for c in rungs if c.dead_time == dead_time and "tasks" in c.evidence
        ]
        free = [(c.rung, t["runs"]) for c, t in played if t["covered"] and not t["clipped"]]
        known = [
            (c.evidence["region"]["largest_step_deg"], c)
            for c in rungs
            if c.dead_time == dead_time
            and c.holds
            and c.evidence.get("region", {}).get("largest_step_deg") is not None
        ]
        claim = StaysInRange(step, dead_time)
        if free and not any(abs(step) <= largest for largest, _ in known):
            found.append(Statement(Status.PROVED, claim, True, abs(step), Unclipped(*free[0]), "deg"))
            continue
        if not known:
            continue
        largest, best = max(known, key=lambda pair: pair[0])
        holds = True if abs(step) <= largest else None
        found.append(Statement(of_proof(holds), claim, holds, float(largest), Covered(best.rung), "deg"))
    return found


def of_tasks(rungs: Sequence[Certificate], step: float, left_out: Sequence[str] = ()) -> list[Statement]:
    """Whether the tasks, with steps [deg], come to where a rung holds; one statement for each rung that tells
    of them; left_out: as in `of_ladder`."""
    found = []
    for c in rungs:
        if "tasks" not in c.evidence:
            continue
        t = c.evidence["tasks"]
        holds = True if t["covered"] else None
        slowest = c.evidence["slowest_pole_1_s"]
        reason = Arrive(
            c.rung,
            t["runs"],
            t["arrive"],
            t["latest_s"],
            t["off_deg"],
            t["clipped"],
            slowest,
            tuple(left_out),
        )
        claim = TasksDieAway(step, c.dead_time)
        evidence = {"rung": c.rung, "dead_time_s": c.dead_time, "slowest_pole_1_s": slowest, **t}
        found.append(
            Statement(
                of_proof(holds), claim, holds, t["decay"] if holds else None, reason, "1/s",
                evidence=evidence,
            )
        )  # fmt: skip
    return found


def of_virgin_curve(bounds: VirginBounds, step: float) -> Statement:
    """How long a step [deg] from rest stays on the virgin curve, which has slope 0 and is left for good."""
    left = bounds.leaves
    latest = float(bounds.latest) if left else None
    return Statement(
        of_proof(left), LeavesVirginCurve(step), left, latest, VirginTimes(bounds), "s", "virgin"
    )
