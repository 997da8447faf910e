"""Where certificates, predictions and samples seem to contradict each other, as values;
`reports.robustness.disagreements` says how both can be true."""

from dataclasses import dataclass

from design.robustness.assess import Assessment
from design.robustness.certificates.certificate import Certificate
from design.robustness.certificates.sampled.words import Word
from design.robustness.samples.monte_carlo import Violations


@dataclass(frozen=True)
class StableYetUnproved:
    """Linear theory calls the loop stable on each branch, and no rung proves it between them; word: that
    shows why none can, where one was found; settled: samples, where all of them did, else 0."""

    word: Word | None
    settled: int


@dataclass(frozen=True)
class MarginYetUnproved:
    """A delay margin [s] that is predicted, and no certificate with a smaller dead time [s]."""

    margin: float
    dead_time: float


@dataclass(frozen=True)
class MarginsYetBroken:
    """Every predicted margin is held, and samples break a requirement, worst of all this one; dead_time [s]:
    up to which the samples have on top."""

    worst: Violations
    dead_time: float


@dataclass(frozen=True)
class RareYetFound:
    """A requirement that hardly any sample breaks, and a scenario that does."""

    violations: Violations


@dataclass(frozen=True)
class CyclesRefuted:
    """Limit cycles that are predicted, and how many of them the simulator does not have."""

    predicted: int
    refuted: int


Disagreement = StableYetUnproved | MarginYetUnproved | MarginsYetBroken | RareYetFound | CyclesRefuted


def disagreements(a: Assessment) -> list[Disagreement]:
    """Each seeming contradiction; empty where the three kinds agree."""
    return [*_switching(a), *_late(a), *_overshoot(a), *_rare(a), *_cycles(a)]


def _switching(a: Assessment) -> list[StableYetUnproved]:
    if not a.stable or a.other_law or any(c.holds for c in _switched(a) if c.dead_time == 0.0):
        return []
    unsettled = [v for v in a.cases.violations if v.requirement == "settles"]
    settled = unsettled[0].trials if unsettled and not unsettled[0].count else 0
    return [StableYetUnproved(a.word, settled)]


def _switched(a: Assessment) -> list[Certificate]:
    """The rungs about loops whose slope changes at will."""
    return [c for c in a.ladder if not c.remembers]


def _late(a: Assessment) -> list[MarginYetUnproved]:
    margin = min(float(row["delay_margin_s"]) for row in a.margins)
    proved = {c.dead_time for c in _switched(a) if c.holds}
    late = dict.fromkeys(c.dead_time for c in a.ladder if c.dead_time > 0.0)
    return [MarginYetUnproved(margin, d) for d in late if margin > d and 0.0 in proved and d not in proved]


def _overshoot(a: Assessment) -> list[MarginsYetBroken]:
    judged = [s for s in a.predictions if s.holds is not None]
    broken = [v for v in a.cases.violations if v.count]
    if not judged or not broken or not all(s.holds for s in judged):
        return []
    return [MarginsYetBroken(max(broken, key=lambda v: v.count), a.conditions.dead_time)]


def _rare(a: Assessment) -> list[RareYetFound]:
    return [
        RareYetFound(v)
        for v in a.cases.violations
        if v.requirement in a.worst.violated and v.count <= 0.01 * v.trials
    ]


def _cycles(a: Assessment) -> list[CyclesRefuted]:
    refuted = sum(not c.confirmed for c in a.cycles)
    return [CyclesRefuted(len(a.cycles), refuted)] if refuted else []
