"""The decisions of a search for effects."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from plants.measured.trace.ranking.screening import Ranked
from plants.measured.trace.search.candidate import Candidate


@dataclass(frozen=True)
class SearchRound:
    """One decision: the model before it, the ranking, candidates that were refitted fully (best
    first), and which was taken, None where the search ended; borrowed: effects that may be nothing but the
    command, with the reason, which were not candidates."""

    before: Candidate
    ranking: tuple[Ranked, ...]
    candidates: tuple[Candidate, ...]
    taken: Candidate | None
    borrowed: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class EffectSearch:
    """All decisions for one stage, and where they led."""

    rounds: tuple[SearchRound, ...]
    chosen: Candidate
    declared: Candidate
