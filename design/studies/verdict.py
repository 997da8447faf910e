"""What a comparison concludes of each motion, as values."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from design.comparison.compare import PAPER, TUNED, Comparison
from design.synthesis.answer import Refusal


class Rank(Enum):
    """How the tuned PI stands to the paper's over the whole range of its gains."""

    AHEAD = "ahead"
    BEHIND = "behind"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Settling:
    """How long the tuned PI takes for the worst task [s], and the paper's over the range of its gains, from
    `paper_low` to `paper_high` [s]; breaking: others that break a limit."""

    tuned: float
    paper_low: float
    paper_high: float
    breaking: tuple[str, ...]

    @property
    def rank(self) -> Rank:
        """A rank only where the whole range of the paper's gains agrees."""
        if self.tuned < self.paper_low:
            return Rank.AHEAD
        return Rank.BEHIND if self.tuned > self.paper_high else Rank.UNDECIDED


Verdict = Refusal | Settling
"""Why no gains meet every limit on a motion, or how long its worst task takes."""


def verdicts(comparison: Comparison, refusals: Mapping[str, Refusal]) -> dict[str, Verdict]:
    """The verdict on each motion."""
    motions = dict.fromkeys(s.motion for s in comparison.standings)
    return {m: refusals[m] if m in refusals else _settling(comparison, m) for m in motions}


def _settling(comparison: Comparison, motion: str) -> Settling:
    of = {n: [r for r in comparison.rows if (r.motion, r.controller) == (motion, n)] for n in (TUNED, PAPER)}
    return Settling(
        max(r.high["settling_time_s"] for r in of[TUNED]),
        max(r.low["settling_time_s"] for r in of[PAPER]),
        max(r.high["settling_time_s"] for r in of[PAPER]),
        tuple(
            s.controller
            for s in comparison.standings
            if s.motion == motion and s.controller not in (TUNED, PAPER) and s.breaks
        ),
    )
