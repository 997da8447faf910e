"""Models without what turned out to be needless: effects, and parameters of their forms."""

import numpy as np

from plants.effects import EFFECTS
from plants.measured.trace.ranking.screening import Screen
from plants.measured.trace.search.candidate import WORTH, Candidate, carries_over, falls
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


def from_command(now: Candidate) -> Candidate:
    """A model with effects whose last fit is to a free run from the command, which is what it is judged by,
    where that error falls on rows left out: the pressure that was measured is not there in use."""
    if not now.model.forms or now.model.stage.free_drives is None:
        return now
    free = Candidate(now.model.freely.fitted())
    return Candidate(now.model.with_values(free.model.values)) if falls(now, free) else now
