"""What samples say of each requirement, as statements."""

from dataclasses import dataclass

from design.robustness.samples.monte_carlo import Samples, Violations
from design.robustness.statement import Claim, Reason, Statement
from design.status import Status

LEVEL = 0.05
"""Share of cases that may break a requirement before the statement about it no longer holds; chosen."""


@dataclass(frozen=True)
class RarelyBroken(Claim):
    """A requirement, in words, is broken in at most a share `level` of cases."""

    words: str
    level: float


@dataclass(frozen=True)
class Counted(Reason):
    """How many cases broke it; noisy: the sensor's noise moves what is limited too; uncounted: cases out of
    reach, which were left out."""

    violations: Violations
    noisy: bool
    uncounted: int


def statements(samples: Samples, level: float = LEVEL) -> list[Statement]:
    """One statement a requirement: it is broken in at most a share `level` of cases.

    holds: True only where the whole interval is below the level, False where all of it is above, None
    where the level lies within and more samples are needed.  value [%]: upper end of the interval, what
    the samples do not refute.
    """
    found = []
    for v in (*samples.violations, samples.beyond):
        noisy = v.requirement == "total_variation_V" and samples.task.conditions.noise > 0.0
        uncounted = 0 if v is samples.beyond else len(samples) - v.trials
        found.append(statement(v, noisy, uncounted, level))
    return found


def statement(v: Violations, noisy: bool, uncounted: int, level: float = LEVEL) -> Statement:
    """The statement about one requirement; noisy, uncounted: as `Counted`."""
    holds = True if v.high < level else False if v.low > level else None
    evidence = {
        "requirement": v.requirement, "limit": v.limit, "violations": v.count, "samples": v.trials,
        "probability": v.probability if v.trials else None, "interval": [v.low, v.high], "level": level,
    }  # fmt: skip
    claim, reason = RarelyBroken(v.words, level), Counted(v, noisy, uncounted)
    return Statement(Status.SAMPLED, claim, holds, 100 * v.high, reason, "%", evidence=evidence)
