"""Models without what turned out to be needless: effects, and parameters of their forms."""

from collections.abc import Iterator, Sequence

import numpy as np

from plants.effects import EFFECTS
from plants.effects.effect import Effect
from plants.measured.trace.ranking.excitation import excitation
from plants.measured.trace.ranking.screening import Screen
from plants.measured.trace.search.candidate import WORTH, Candidate, carries_over, falls
from plants.measured.trace.search.refits import rank
from plants.measured.trace.search.together import fitted_with
from plants.measured.trace.search.worth import needed

SAME = 0.02
"""Forms of one effect whose chi-square is within this share of its excess are equally good; the one
with fewest parameters is taken."""


def pruned(now: Candidate, declared: Candidate) -> Candidate:
    """The model without effects that a later one made needless."""
    for name in now.model.effects:
        if len(now.model.forms) < 2:
            break
        less = Candidate(now.model.without(name).fitted())
        if not needed(name, less, now, declared):
            now = less
    return now


def carried_over(now: Candidate, declared: Candidate) -> Candidate:
    """The model without effects that serve only the recordings that they were fitted on: with them, those
    left out whole are simulated clearly worse, by a larger factor than those that fit are simulated better.
    Before an effect goes its other forms are tried: one that would not go for this may stay.

    Where the declared model leaves no structure, rows left out say nothing of an effect; see `worth_it`.
    """
    while now.model.forms and declared.examined.structured and now.over_recordings is not None:
        less = {name: Candidate(now.model.without(name).fitted()) for name in now.model.effects}
        better = [n for n, c in less.items() if _serves_itself(now, c)]
        if not better:
            break
        name = min(better, key=lambda n: _both(less[n]))
        others = _in_forms(now, name, [f for f in EFFECTS[name] if f not in now.model.forms])
        now = min((less[name], *(c for c in others if _may_stay(c, name, less[name]))), key=_both)
    return now


def _serves_itself(now: Candidate, less: Candidate) -> bool:
    """Whether recordings left out whole are simulated clearly worse than by a model with less, by a larger
    factor than those that fit are simulated better."""
    return carries_over(now, less) and _both(less) < _both(now)


def _may_stay(found: Candidate, name: str, less: Candidate) -> bool:
    """Whether a form of an effect is more than what the command does by itself, is not `contrived`,
    and would not go as the one did that it replaces."""
    asked = excitation(found.model.stage.playbacks)
    return not _serves_itself(found, less) and not any(rank(found.model, name, asked)[:2])


def _both(found: Candidate) -> float:
    """The product of the errors, over the noise, on recordings that fit and on those left out whole."""
    return float(np.sqrt(found.model.freely.chi2)) * (found.over_recordings or 1.0)


def started_anew(now: Candidate) -> Candidate:
    """A model that leaves something, with each effect of many minima fitted once more from its trial values,
    beside all others: it was when others were missing, which left it in a minimum that is not the lowest."""
    for form in now.model.forms:
        if form.RUGGED and now.lacks_something:
            now = min(now, *_in_forms(now, form.NAME, [form]), key=lambda c: c.model.chi2)
    return now


def simplest(now: Candidate) -> Candidate:
    """Each effect in the form with fewest parameters among those that do equally well."""
    for form in now.model.forms:
        simpler = [f for f in EFFECTS[form.NAME] if len(f.kinds()) < len(form.kinds())]
        for found in _in_forms(now, form.NAME, sorted(simpler, key=lambda f: len(f.kinds()))):
            if found.model.chi2 - now.model.chi2 < SAME * max(now.model.chi2 - 1.0, WORTH):
                now = found
                break
    return now


def _in_forms(now: Candidate, name: str, forms: Sequence[type[Effect]]) -> Iterator[Candidate]:
    """The model with an effect in each of some other forms, fitted one after the other."""
    rest = now.model.without(name)
    if not forms:
        return
    held = Screen(rest.fitted(6, 1e-3))
    for form in forms:
        yield Candidate(fitted_with(rest, held.rank(form)).fitted())


def from_command(now: Candidate) -> Candidate:
    """A model with effects, or of a rig that was guessed from its log, whose last fit is to a free run from
    the command, which is what it is judged by, where that error falls on rows left out: the pressure that
    was measured is not there in use."""
    stage = now.model.stage
    if stage.free_drives is None or not (now.model.forms or stage.guessed):
        return now
    free = Candidate(now.model.freely.fitted())
    return Candidate(now.model.with_values(free.model.values)) if falls(now, free) else now
