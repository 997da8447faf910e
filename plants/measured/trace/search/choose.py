"""Choosing effects: refit the best few fully, judge on blocks left out, prefer fewer effects."""

from collections.abc import Callable, Sequence

from plants.measured.trace.ranking.excitation import excitation
from plants.measured.trace.search.candidate import WORTH, Candidate, carries_over, falls
from plants.measured.trace.search.common import (
    common_at_least,
    common_effects,
    common_instead,
    only_together,
)
from plants.measured.trace.search.refits import Scope, freed, further, rather_common, reformed
from plants.measured.trace.search.rounds import EffectSearch, SearchRound
from plants.measured.trace.search.simplify import carried_over, pruned
from plants.measured.trace.search.worth import enough, promising, worth_it
from plants.measured.trace.stages.model import Model

MOST = 3
"""Effects that a stage may be given; beyond that a description is more honest than a list of causes.  One of
several parts that has some to begin with may be given as many for each part."""

NEXT = 3
"""Candidates of a round that are tried in other forms where the best of them is not worth it."""

BEAM, BEAM_REACH = 2, 5.0
"""Models that a round starts from, and how much worse than the best the others may be."""


def search(
    declared: Model,
    names: Sequence[str] | None = None,
    tell: Callable[[str], None] | None = None,
    seed: int = 0,
    present: Candidate | None = None,
) -> EffectSearch:
    """Add effects, of those named, to a fitted declared model, or to `present`, which has some already, while
    each is worth it.

    The best few models of a round are all carried to the next: the first effect
    is chosen while another is still missing, which may pass for it.  Forms need not be the `simplest` yet.
    Raises nothing for a residual that no effect explains: the search just ends.
    """
    first = Candidate(declared)
    now = first if present is None else present
    asked, stage = excitation(declared.stage.playbacks), declared.stage
    scope = Scope(first, names or stage.effects, asked, seed, tell or (lambda what: None))
    beam, rounds, undone = [now], list[SearchRound](), list[set[str]]()
    most = MOST if present is None else MOST * stage.parts
    while len(now.model.forms) < most and (not rounds or now.lacks_something):
        candidates, ranking, borrowed = further(scope, beam, now.lacks_something)
        candidates = rather_common(now, candidates) if candidates else []
        best = candidates[0] if candidates else None
        if best is not None and best.model.chi2 > 1.0 + WORTH and promising(now, best, first):
            best = reformed(best, asked)
        taken = freed(best) if best is not None and worth_it(now, best, first) else None
        if taken is None and not now.model.forms:
            taken, candidates = only_together(scope, candidates)
        if taken is None:
            taken = _in_other_forms(scope, now, candidates[1:NEXT]) or common_at_least(now, candidates)
        rounds.append(SearchRound(now, ranking, tuple(candidates), taken, borrowed))
        if taken is None:
            break
        less, added = pruned(taken, first), set(taken.model.effects)
        # What was pruned once and is taken again stays: rules that disagree would go on for ever.
        now = taken if added in undone else less
        undone += [added] if less is not taken else []
        others = [c for c in candidates[1:] if len(c.model.forms) < most]
        beam = [now, *(c for c in others if c.model.chi2 < BEAM_REACH * now.model.chi2)][:BEAM]
    if (exchange := common_instead(scope, now)) is not None:
        rounds.append(exchange)
        now = now if exchange.taken is None else pruned(exchange.taken, first)
    return EffectSearch(tuple(rounds), now, first)


def _in_other_forms(scope: Scope, now: Candidate, others: Sequence[Candidate]) -> Candidate | None:
    """The first of some candidates beyond a model that is worth it once each of its effects was tried in its
    other forms; None for none, or for a model without an effect.

    A form that was chosen while another effect was missing may be the wrong one beside it: a lag of a tube
    that stands in for a dead band leaves it little to explain.
    """
    if not now.model.forms or not now.lacks_something:
        return None
    for c in others:
        found = reformed(c, scope.asked)
        if found is not c and worth_it(now, found, scope.declared):
            return freed(found)
    return None


def search_from_common(
    alone: EffectSearch, one_by_one: Candidate, names: Sequence[str], tell: Callable[[str], None], seed: int
) -> tuple[EffectSearch, Candidate]:
    """The search once more, from effects that nearly any rig has, and what it found that is `carried_over`;
    of the search for one effect after the other, `alone`, the same where that is clearly better on rows or
    recordings left out."""
    first = alone.declared
    scope = Scope(first, names, excitation(first.model.stage.playbacks), seed, tell)
    common = common_effects(scope, alone.rounds[0].ranking)
    if common.taken is None:
        return alone, one_by_one
    found = search(first.model, names, tell, seed, common.taken)
    together = carried_over(found.chosen, first)
    on_blocks = falls(together, one_by_one) and enough(together.held_out, one_by_one.held_out, first.held_out)
    rounds = (common, *found.rounds)
    if on_blocks or carries_over(together, one_by_one):
        return EffectSearch((*rounds, *alone.rounds), alone.chosen, first), one_by_one
    return EffectSearch((*alone.rounds, *rounds), found.chosen, first), together
