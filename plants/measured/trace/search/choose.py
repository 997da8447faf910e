"""Choosing effects: refit the best few fully, judge on blocks left out, prefer fewer effects."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from plants.effects import EFFECTS
from plants.measured.trace.search.backwards import turns_back
from plants.measured.trace.search.candidate import WORTH, Candidate, carries_over, falls
from plants.measured.trace.search.excitation import Excitation, excitation
from plants.measured.trace.search.likelihood import demanded
from plants.measured.trace.search.screening import Ranked, Screen, screen
from plants.measured.trace.search.together import fitted_with
from plants.measured.trace.stages.model import Model

Array = NDArray[np.float64]
SHARE = 0.25
"""Least share of what chi-square has above 1 that an effect must take away."""

TRIFLE = 0.002
"""Least share, of what chi-square fell by so far, that a further effect must bring: the form of a strong
effect is never quite the rig's, and what it leaves invites others."""

SHORTLIST, FORMS = 6, 2
"""Effects that are refitted in each round, and of how many of their forms."""

FEWER, ONE = 3, 1
"""The same for models of a round that are not its best: what they lack stands high in their ranking, and of
the best that is found other forms are tried later."""

MOST = 3
"""Effects that a stage may be given; beyond that a description is more honest than a list of causes."""

SAME = 0.02
"""Forms of one effect whose chi-square is within this share of its excess are equally good; the one
with fewest parameters is taken."""

OTHER_FORM = 2.0
"""Times what one form of an effect brings that another may: an effect that brings less than the least over
this is not tried in its other forms."""

BEAM, BEAM_REACH = 2, 5.0
"""Models that a round starts from, and how much worse than the best the others may be."""

LEAVES = 0.1
"""Share that two effects tried together may leave, on rows left out, of what the declared model leaves above
the noise: of many pairs some fit nearly anything by half."""

ROUGH = 1e-4
"""Relative change of chi-square at which a candidate is fitted well enough to be compared."""


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
    tell = tell or (lambda what: None)
    first = Candidate(declared)
    now = first if present is None else present
    beam, rounds = [now], list[SearchRound]()
    asked = excitation(declared.stage.playbacks)
    while len(now.model.forms) < MOST and (not rounds or now.lacks_something):
        candidates, ranking, borrowed = _further(beam, now, names, asked, seed, tell)
        best = candidates[0] if candidates else None
        if best is not None and best.model.chi2 > 1.0 + WORTH and _promising(now, best, first):
            best = reformed(best, asked)
        taken = freed(best) if best is not None and worth_it(now, best, first) else None
        if taken is None and not now.model.forms:
            # Effects of a loop may help only together: each alone bends the others' parameters.
            some = [c for c in candidates if enough(now.model.chi2, c.model.chi2, first.model.chi2)][:BEAM]
            pairs = _further(some, now, names, asked, seed, tell)[0] if some else []
            candidates = [*pairs, *candidates]
            if pairs and _explain(pairs[0], first) and worth_it(now, pairs[0], first):
                taken = freed(pairs[0])
        rounds.append(SearchRound(now, ranking, tuple(candidates), taken, borrowed))
        if taken is None:
            break
        now = pruned(taken, first)
        others = [c for c in candidates[1:] if len(c.model.forms) < MOST]
        beam = [now, *(c for c in others if c.model.chi2 < BEAM_REACH * now.model.chi2)][:BEAM]
    return EffectSearch(tuple(rounds), now, first)


def _further(
    beam: Sequence[Candidate],
    now: Candidate,
    names: Sequence[str] | None,
    asked: Excitation,
    seed: int,
    tell: Callable[[str], None],
) -> tuple[list[Candidate], tuple[Ranked, ...], dict[str, str]]:
    """Candidates with one effect more than some models, the best first; the ranking beyond the first of
    these; effects that may be nothing but the command, with the reason."""
    found: list[Candidate] = []
    ranking: list[Ranked] = []
    for place, start in enumerate(beam):
        effects, forms = (SHORTLIST, FORMS) if place == 0 else (FEWER, ONE)
        tell(f"ranking effects beyond {', '.join(start.model.effects) or 'none'}")
        left = [n for n in names or start.model.stage.effects if n not in start.model.effects]
        ranked = screen(start.model, left, seed, now.lacks_something)
        ranking = ranking or ranked
        if now.lacks_something:
            found += refit(start.model, shortlist(ranked, effects), forms, asked)
    borrowed = {n: why for c in found for n, why in borrowed_in(c, asked).items()}
    kept = [c for c in found if not borrowed_in(c, asked) and not turns_back(c.model)]
    return distinct(sorted(kept, key=lambda c: c.model.chi2)), tuple(ranking), borrowed


def distinct(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The first candidate of each set of effects."""
    found: dict[frozenset[str], Candidate] = {}
    for c in candidates:
        found.setdefault(frozenset(c.model.effects), c)
    return list(found.values())


def borrowed_in(candidate: Candidate, asked: Excitation) -> dict[str, str]:
    """Effects of a candidate that may be nothing but the command, with the reason."""
    found = {e.NAME: e.borrowed(asked) for e in candidate.model.wrist.effects}
    return {n: why for n, why in found.items() if why is not None}


def freed(candidate: Candidate) -> Candidate:
    """The candidate fitted to the end, with the parameters that the declared model was too wrong to determine
    where rows left out are the better for them."""
    found = Candidate(candidate.model.fitted())
    if not found.model.fixed:
        return found
    all_of_them = Candidate(replace(found.model, fixed=()).fitted())
    return all_of_them if all_of_them.held_out < found.held_out else found


def reformed(now: Candidate, asked: Excitation) -> Candidate:
    """The same effects, each tried in its other forms."""
    for form in now.model.forms:
        rest = now.model.without(form.NAME)
        held = Screen(rest.fitted(6, 1e-3))
        others = [held.rank(f) for f in EFFECTS[form.NAME] if f is not form]
        for other in refit(rest, others, len(others)):
            if other.model.chi2 < now.model.chi2 and not any(rank(other.model, form.NAME, asked)[:2]):
                now = other
    return now


def worth_it(before: Candidate, after: Candidate, declared: Candidate) -> bool:
    """Whether an effect earns its place.

    In a residual that has structure, the error of a free run from the command has to fall on rows left out,
    by more than its uncertainty and by enough.  One without may be slow noise whose floor was taken too low,
    or an effect in recordings too short for the tests to see it: then it has to take a good part away and
    to make the rest likelier as noise, of any colour, by more than following slow noise for a while would.
    Rows left out say nothing there, since slow noise upsets the declared parameters on part of the data as
    much as a missing effect.  But the error of a free run must not rise where the stage is driven by what was
    measured.
    """
    if before.examined.structured:
        return falls(before, after) and enough(before.held_out, after.held_out, declared.held_out)
    if not enough(before.model.chi2, after.model.chi2, declared.model.chi2):
        return False
    if after.model.freely.chi2 > before.model.freely.chi2:
        return False
    more = max(1, len(after.model.names) - len(before.model.names))
    return after.log_likelihood - before.log_likelihood > demanded(more, after.model.stage.duration)


def _explain(pair: Candidate, declared: Candidate) -> bool:
    """Whether two effects leave next to nothing of what the declared model leaves on rows left out."""
    return pair.held_out - 1.0 <= LEAVES * (declared.held_out - 1.0)


def enough(before: float, after: float, declared: float) -> bool:
    """Whether a chi-square per row falls by enough to be an effect and no imperfection of a form."""
    return before - after > max(WORTH, SHARE * (before - 1.0), TRIFLE * (declared - before))


def _promising(before: Candidate, after: Candidate, declared: Candidate) -> bool:
    """Whether an effect could be enough in a form that brings `OTHER_FORM` times as much."""
    now = before.model.chi2
    return enough(now, now - OTHER_FORM * (now - after.model.chi2), declared.model.chi2)


def shortlist(ranking: Sequence[Ranked], effects: int = SHORTLIST) -> list[Ranked]:
    """All ranked forms of so many effects that explain most, beyond what chance would."""
    names: list[str] = []
    for r in ranking:
        if r.name not in names and r.drop > max(2.0 * r.chance, 0.2 * WORTH):
            names.append(r.name)
    return [r for r in ranking if r.name in names[:effects]]


def refit(
    model: Model, ranked: Sequence[Ranked], forms: int = FORMS, asked: Excitation | None = None
) -> list[Candidate]:
    """Each effect ranked, in the best of so many of its forms, fitted fully; the best first.  asked: forms
    that may be nothing but the command come after those that may not, as do loops that turn back."""
    best: dict[str, Model] = {}
    tried: dict[str, int] = {}
    for r in ranked:
        tried[r.name] = tried.get(r.name, 0) + 1
        if r.drop <= 0.0 or tried[r.name] > forms:
            continue
        m = fitted_with(model, r)
        if r.name not in best or rank(m, r.name, asked) < rank(best[r.name], r.name, asked):
            best[r.name] = m
    order = sorted(best.values(), key=lambda m: m.chi2)
    return sorted((Candidate(m.fitted(20, ROUGH)) for m in order[:3]), key=lambda c: c.model.chi2)


def rank(model: Model, name: str, asked: Excitation | None) -> tuple[bool, bool, float]:
    """By what forms of an effect are ordered, the best first."""
    borrowed = asked is not None and name in borrowed_in(Candidate(model), asked)
    return borrowed, turns_back(model), model.chi2


def from_command(now: Candidate) -> Candidate:
    """A model with effects whose last fit is to a free run from the command, which is what it is judged by,
    where that error falls on rows left out: the pressure that was measured is not there in use."""
    if not now.model.forms or now.model.stage.free_drives is None:
        return now
    free = Candidate(now.model.freely.fitted())
    return Candidate(now.model.with_values(free.model.values)) if falls(now, free) else now


def pruned(now: Candidate, declared: Candidate) -> Candidate:
    """The model without effects that a later one made needless."""
    for name in now.model.effects:
        if len(now.model.forms) < 2:
            break
        less = Candidate(now.model.without(name).fitted())
        if not worth_it(less, now, declared):
            now = less
    return now


def carried_over(now: Candidate, declared: Candidate) -> Candidate:
    """The model without effects that serve only the recordings that they were fitted on: with them, those
    left out whole are simulated clearly worse, by a larger factor than those that fit are simulated better.

    Where the declared model leaves no structure, rows left out say nothing of an effect; see `worth_it`.
    """
    while now.model.forms and declared.examined.structured and now.over_recordings is not None:
        less = [Candidate(now.model.without(name).fitted()) for name in now.model.effects]
        better = [c for c in less if carries_over(now, c) and _both(c) < _both(now)]
        if not better:
            break
        now = min(better, key=_both)
    return now


def _both(found: Candidate) -> float:
    """The product of the errors, over the noise, on recordings that fit and on those left out whole."""
    return float(np.sqrt(found.model.freely.chi2)) * (found.over_recordings or 1.0)


def simplest(now: Candidate) -> Candidate:
    """Each effect in the form with fewest parameters among those that do equally well."""
    for form in now.model.forms:
        rest = now.model.without(form.NAME)
        simpler = [f for f in EFFECTS[form.NAME] if len(f.kinds()) < len(form.kinds())]
        if not simpler:
            continue
        held = Screen(rest.fitted(6, 1e-3))
        for other in sorted(simpler, key=lambda f: len(f.kinds())):
            found = Candidate(fitted_with(rest, held.rank(other)).fitted())
            if found.model.chi2 - now.model.chi2 < SAME * max(now.model.chi2 - 1.0, WORTH):
                now = found
                break
    return now
