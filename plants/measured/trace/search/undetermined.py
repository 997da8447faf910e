"""Parameters of effects, and of a law's curve, that the recordings say nothing about."""

from dataclasses import replace

import numpy as np

from plants.measured.estimate import corner_of, uncertainty
from plants.measured.trace.search.candidate import Candidate
from plants.measured.trace.stages.model import Model

HALVINGS = 4
"""Steps, on a logarithmic scale, in which the nearest slope is looked for."""

SIGMAS = 2.0
"""Standard errors within which a slope of a law's curve is that of the middle."""

COSTS = 0.01
"""Share by which chi-square may rise with a slope that is not needed."""


def at_neutral(now: Candidate) -> Candidate:
    """The candidate with each parameter of an effect that the recordings do not determine at the value that
    it has where the effect vanishes, or at a typical one, and not where a trial happened to leave it; also
    those that the hysteresis law can do without.

    A campaign in which the pressure never falls says nothing of the speed of exhausting, and a free run of
    another recording would meet whatever was tried; a slope of the output curve beyond all that was recorded
    would be a branch that no loop has.  Not determined: the sum of squares rises by less than what chance
    makes of it, that of one row.
    """
    found = now.model
    allowed = now.model.chi2 * (1.0 + 1.0 / now.model.residual.size)
    neutral = {n: v for n, v in now.model.wrist.hysteresis.NEUTRAL.items() if n in now.model.names}
    for form in now.model.forms:
        absent = form()
        neutral |= {f"{form.NAME}.{n}": float(getattr(absent, n)) for n in form.kinds()}
    for name, value in neutral.items():
        moved = found.with_values({name: value})
        if moved.chi2 < allowed:
            found = moved
    return Candidate(found) if found is not now.model else now


def without_bends(now: Candidate) -> Candidate:
    """The candidate with each slope of its hysteresis law's curve that is within its standard error of the
    middle's as near to that as the recordings allow, one after the other, the least certain first, and the
    rest fitted again.

    Such a slope is one that the recordings do not tell from those of the plays that it weighs.  Its interval
    would be a branch of many times the slope of the others, which no gains hold.
    """
    neutral, found = now.model.wrist.hysteresis.NEUTRAL, now.model
    allowed = (1.0 + COSTS) * now.model.chi2
    for _ in neutral:
        errors = uncertainty(found.problem, found.vector, found.bounds, corner_of(found.residual)).std_errors
        off = {
            n: abs(found.values[n] - neutral[n]) / e if e else 0.0
            for n, e in zip(found.names, errors, strict=True)
            if n in neutral
        }
        least = min(off, key=lambda n: off[n], default=None)
        if least is None or off[least] > SIGMAS:
            break
        found = _straightened(found, least, neutral[least], allowed)
    return Candidate(found) if found is not now.model else now


def _straightened(model: Model, name: str, neutral: float, allowed: float) -> Model:
    """The model with a slope kept where it is nearest to the neutral one at a chi-square that is allowed."""

    def kept(value: float) -> Model:
        return replace(model.with_values({name: value}), fixed=(*model.fixed, name))

    found = kept(neutral).fitted(20, 1e-5)
    if found.chi2 <= allowed:
        return found
    found, near, far = kept(model.values[name]), neutral, model.values[name]
    for _ in range(HALVINGS):
        middle = float(np.sqrt(near * far))
        tried = kept(middle).fitted(20, 1e-5)
        if tried.chi2 <= allowed:
            found, far = tried, middle
        else:
            near = middle
    return found
