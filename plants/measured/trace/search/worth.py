"""Whether an effect is worth adding to a model."""

from plants.effects import EFFECTS
from plants.measured.trace.search.candidate import WORTH, Candidate, falls
from plants.measured.trace.search.likelihood import demanded

SHARE = 0.25
"""Least share of what chi-square has above 1 that an effect must take away."""

TRIFLE = 0.002
"""Least share, of what chi-square fell by so far, that a further effect must bring: the form of a strong
effect is never quite the rig's, and what it leaves invites others."""

OTHER_FORM = 2.0
"""Times what one form of an effect brings that another may: an effect that brings less than the least over
this is not tried in its other forms."""

LEAVES = 0.2
"""Share that two effects tried together may leave, on rows left out, of what the declared model leaves above
the noise: of many pairs some fit nearly anything by half."""


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


def needed(name: str, less: Candidate, now: Candidate, declared: Candidate) -> bool:
    """Whether a model is to keep an effect, less: without it.

    It is where the effect would be worth adding again.  Where nothing was measured between regulator and
    joint, each is bent by what is left out of the other, and rows left out decide little: there an effect
    that nearly any rig has stays if enough is left without it, unless rows left out are the better for that.
    """
    if now.model.stage.parts > 1 and EFFECTS[name][0].COMMON:
        return enough(less.model.chi2, now.model.chi2, declared.model.chi2) and not falls(now, less)
    return worth_it(less, now, declared)


def enough(before: float, after: float, declared: float) -> bool:
    """Whether a chi-square per row falls by enough to be an effect and no imperfection of a form."""
    return before - after > max(WORTH, SHARE * (before - 1.0), TRIFLE * (declared - before))


def promising(before: Candidate, after: Candidate, declared: Candidate) -> bool:
    """Whether an effect could be enough in a form that brings `OTHER_FORM` times as much."""
    now = before.model.chi2
    return enough(now, now - OTHER_FORM * (now - after.model.chi2), declared.model.chi2)


def explain_all(pair: Candidate, declared: Candidate) -> bool:
    """Whether two effects leave next to nothing of what the declared model leaves on rows left out."""
    return pair.held_out - 1.0 <= LEAVES * (declared.held_out - 1.0)
