"""Candidates: models with one effect more, those that rank best fitted fully."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from plants.effects import EFFECTS
from plants.measured.trace.ranking.backwards import turns_back
from plants.measured.trace.ranking.excitation import Excitation
from plants.measured.trace.ranking.screening import Ranked, Screen, screen
from plants.measured.trace.search.candidate import WORTH, Candidate, carries_over
from plants.measured.trace.search.together import fitted_with
from plants.measured.trace.stages.model import Model

SHORTLIST, FORMS = 6, 2
"""Effects that are refitted in each round, and of how many of their forms."""

FEWER, ONE = 3, 1
"""The same for models of a round that are not its best: what they lack stands high in their ranking, and of
the best that is found other forms are tried later."""

ROUGH = 1e-4
"""Relative change of chi-square at which a candidate is fitted well enough to be compared."""


@dataclass(frozen=True)
class Scope:
    """What a search may use: the declared model, names of the effects that may be added to it, what was asked
    of the rig, the seed of the ranking, and whom to tell what is being done."""

    declared: Candidate
    names: Sequence[str]
    asked: Excitation
    seed: int
    tell: Callable[[str], None]


def further(
    scope: Scope, beam: Sequence[Candidate], wanted: bool
) -> tuple[list[Candidate], tuple[Ranked, ...], dict[str, str]]:
    """Candidates with one effect more than some models, the best first, none where they are not `wanted`;
    the ranking beyond the first of these; effects that may be nothing but the command, with the reason."""
    found: list[Candidate] = []
    ranking: list[Ranked] = []
    for place, start in enumerate(beam):
        effects, forms = (SHORTLIST, FORMS) if place == 0 else (FEWER, ONE)
        scope.tell(f"ranking effects beyond {', '.join(start.model.effects) or 'none'}")
        left = [n for n in scope.names if n not in start.model.effects]
        ranked = screen(start.model, left, scope.seed, wanted)
        ranking = ranking or ranked
        if wanted:
            found += refit(start.model, shortlist(ranked, effects), forms, scope.asked)
            found += _common_too(start.model, ranked, found, scope.asked) if place == 0 else []
    borrowed = {n: why for c in found for n, why in borrowed_in(c, scope.asked).items()}
    kept = [c for c in found if not borrowed_in(c, scope.asked) and not contrived(c.model)]
    return distinct(sorted(kept, key=lambda c: c.model.chi2)), tuple(ranking), borrowed


def _common_too(
    model: Model, ranked: Sequence[Ranked], found: Sequence[Candidate], asked: Excitation
) -> list[Candidate]:
    """The effects beyond chance that nearly any rig has, refitted as well if they are not among the best, of
    a rig whose law was chosen from the log: whether they are `rather_common` is for whole recordings to say.
    """
    tried = {n for c in found for n in c.model.effects}
    names = [n for n in dict.fromkeys(r.name for r in shortlist(ranked)) if EFFECTS[n][0].COMMON]
    left = [n for n in names if n not in tried] if model.stage.guessed else []
    return [c for n in left for c in refit(model, [r for r in ranked if r.name == n], FORMS, asked)]


def rather_common(now: Candidate, candidates: Sequence[Candidate]) -> list[Candidate]:
    """Candidates beyond a model, with one that adds only what nearly any rig has before a best one that adds
    something else, where recordings left out whole are clearly better simulated by it.

    What drifts with time, or steps at a moment of a recording, follows much in the recordings that it is
    fitted on, a creep too.
    """
    best, *others = candidates

    def common(c: Candidate) -> bool:
        return all(EFFECTS[n][0].COMMON for n in c.model.effects if n not in now.model.effects)

    if now.model.stage.guessed and not common(best):
        for c in others:
            if len(c.model.effects) <= len(best.model.effects) and common(c) and carries_over(best, c):
                return [c, *(o for o in candidates if o is not c)]
    return list(candidates)


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
    """By what forms of an effect are ordered, the best first: whether the effect may be nothing but the
    command, whether the model is `contrived`, chi-square."""
    borrowed = asked is not None and name in borrowed_in(Candidate(model), asked)
    return borrowed, contrived(model), model.chi2


def contrived(model: Model) -> bool:
    """Whether a loop turns back, or an effect does nearly what the declared wrist does without it: it stands
    in for something else."""
    return turns_back(model) or any(e.redundant(model.wrist) for e in model.wrist.effects)


def borrowed_in(candidate: Candidate, asked: Excitation) -> dict[str, str]:
    """Effects of a candidate that may be nothing but the command, with the reason."""
    found = {e.NAME: e.borrowed(asked) for e in candidate.model.wrist.effects}
    return {n: why for n, why in found.items() if why is not None}


def distinct(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The first candidate of each set of effects."""
    found: dict[frozenset[str], Candidate] = {}
    for c in candidates:
        found.setdefault(frozenset(c.model.effects), c)
    return list(found.values())


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
