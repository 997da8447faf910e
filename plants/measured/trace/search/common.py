"""Effects that are found together only: where each alone bends the parameters of the others, or where nothing
was measured between two parts of a rig."""

from collections.abc import Sequence
from dataclasses import replace

from plants.effects import EFFECTS
from plants.measured.trace.ranking.screening import Ranked, Screen
from plants.measured.trace.search.candidate import Candidate, carries_over, falls, tied
from plants.measured.trace.search.refits import FORMS, Scope, distinct, freed, further, reformed
from plants.measured.trace.search.rounds import SearchRound
from plants.measured.trace.search.simplify import pruned
from plants.measured.trace.search.together import fitted_with
from plants.measured.trace.search.worth import enough, explain_all, worth_it

BEAM = 2
"""Effects that are tried with one more each."""


def common_effects(scope: Scope, ranking: Sequence[Ranked]) -> SearchRound:
    """A round that begins a stage of several parts: effects that nearly any rig has, fitted together, and
    each of them replaced by another effect; ranking: of effects beyond the declared model.

    One after the other they are not found: without a dead time and the rates of a valve, what a joint does
    is given another name.
    """
    scope.tell("fitting what nearly any rig has")
    declared = scope.declared
    model = declared.model
    for name in (n for n in scope.names if EFFECTS[n][0].COMMON):
        held = Screen(model)
        best = sorted((held.rank(f) for f in EFFECTS[name]), key=lambda r: -r.drop)[:FORMS]
        model = min((fitted_with(model, r) for r in best), key=lambda m: m.chi2)
    together = pruned(freed(Candidate(model)), declared)
    less = [Candidate(together.model.without(n).fitted()) for n in together.model.effects]
    others, _, borrowed = further(scope, less, declared.lacks_something)
    found = distinct(sorted([together, *others], key=lambda c: c.model.chi2))
    taken = together if together.model.forms and worth_it(declared, together, declared) else None
    return SearchRound(declared, tuple(ranking), tuple(found), taken, borrowed)


def common_instead(scope: Scope, now: Candidate) -> SearchRound | None:
    """A round in which each effect that few rigs have is replaced by one that nearly any has; None for a
    model without the first, or where the law was given.  Taken is the best of these, unless this data tells
    the model from it (`tied`).

    An effect that was chosen while another was missing may have passed for it: in one recording a drift of
    the sensor follows what creeps.
    """
    rare = [n for n in now.model.effects if not EFFECTS[n][0].COMMON]
    left = [n for n in scope.names if EFFECTS[n][0].COMMON and n not in now.model.effects]
    if not rare or not left or not now.model.stage.guessed:
        return None
    less = [Candidate(now.model.without(n).fitted()) for n in rare]
    found, ranking, borrowed = further(replace(scope, names=left), less, wanted=True)
    best = freed(reformed(found[0], scope.asked)) if found else None
    taken = best if best is not None and tied(now.model, best.model) else None
    return SearchRound(now, ranking, tuple(found), taken, borrowed)


def only_together(scope: Scope, candidates: list[Candidate]) -> tuple[Candidate | None, list[Candidate]]:
    """The effects that are taken where none is by itself, None for none, and all candidates, those with most
    effects first.

    Effects of a loop may help only together: each alone bends the others' parameters.
    """
    declared = scope.declared
    before = declared.model.chi2
    some = [c for c in candidates if enough(before, c.model.chi2, before)][:BEAM]
    pairs = further(scope, some, declared.lacks_something)[0] if some else []
    if pairs and explain_all(pairs[0], declared) and worth_it(declared, pairs[0], declared):
        return freed(pairs[0]), [*pairs, *candidates]
    return None, [*pairs, *candidates]


def common_at_least(now: Candidate, candidates: Sequence[Candidate]) -> Candidate | None:
    """The best candidate beyond a model that adds only what nearly any rig has, where the rig was guessed
    from its log and recordings left out whole are clearly better simulated with it; None for none.

    Of a rig that no model describes to its noise an effect that is there takes a small share.
    """
    if not now.model.stage.guessed:
        return None
    for c in candidates:
        added = set(c.model.effects) - set(now.model.effects)
        if added and all(EFFECTS[n][0].COMMON for n in added) and falls(now, c) and carries_over(now, c):
            return freed(c)
    return None
