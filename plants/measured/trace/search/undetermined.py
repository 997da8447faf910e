"""Parameters of effects, and of a law's curve, that the recordings say nothing about."""

from dataclasses import replace

import numpy as np

from plants.measured.fitting.estimate import corner_of, uncertainty
from plants.measured.trace.search.candidate import Candidate
from plants.measured.trace.stages.model import Model

FARTHEST, TRIED = 3.0, 200
"""Factor by which a threshold is moved at most, and values tried within."""

HALVINGS = 4
"""Steps, on a logarithmic scale, in which the nearest slope is looked for."""

ASIDE, SILENT = 0.1, 0.01
"""Share of the way to where it vanishes by which a parameter is moved to see whether recordings say anything
of it, and rise of the sum of squares, in rows, below which they do not: a square of the former, so that where
that sum is a parabola no more than one row is allowed all the way."""

SIGMAS = 2.0
"""Standard errors within which a slope of a law's curve is that of the middle."""

COSTS = 0.01
"""Share by which chi-square, or that of a free run on rows left out, may rise without a slope or a part of an
effect that is not needed."""

CONFOUNDED = 0.99
"""Correlation of the errors of two parameters beyond which the recordings tell their combination alone."""


def at_neutral(now: Candidate) -> Candidate:
    """The candidate with each parameter of an effect that the recordings do not determine at the value that
    it has where the effect vanishes, or at a typical one, and not where a trial happened to leave it; also
    those that the hysteresis law can do without.

    A campaign in which the pressure never falls says nothing of the speed of exhausting, and a free run of
    another recording would meet whatever was tried; a slope of the output curve beyond all that was
    recorded would be a branch that no loop has.  Not determined: the sum of squares rises by less than what
    chance makes of it, that of one row.  Where only a part of the way to that value is free, as beyond a rate
    that is fast enough, the parameter is at the end of that part: any other would be what rounding left.
    """
    found = now.model
    allowed = now.model.chi2 * (1.0 + 1.0 / now.model.residual.size)
    neutral = {n: v for n, v in now.model.wrist.hysteresis.NEUTRAL.items() if n in now.model.names}
    for form in now.model.forms:
        absent = form()
        neutral |= {f"{form.NAME}.{n}": float(getattr(absent, n)) for n in form.kinds()}
    for name, value in neutral.items():
        moved = found.with_values({name: value})
        found = moved if moved.chi2 < allowed else _nearest_free(found, name, value, allowed)
    return Candidate(found) if found is not now.model else now


def _nearest_free(model: Model, name: str, neutral: float, allowed: float) -> Model:
    """The model with a parameter as near to its neutral value as a mean square allows where the recordings
    say nothing of it around its own value; as it is elsewhere."""
    far, near = model.values[name], neutral
    aside = model.with_values({name: far + ASIDE * (neutral - far)})
    if aside.chi2 > model.chi2 * (1.0 + SILENT / model.residual.size):
        return model
    found = model
    for _ in range(2 * HALVINGS):
        tried = model.with_values({name: 0.5 * (near + far)})
        if tried.chi2 < allowed:
            found, far = tried, tried.values[name]
        else:
            near = tried.values[name]
    return found


def in_their_middle(now: Candidate) -> Candidate:
    """The candidate with each threshold of an effect in the middle of the values at which the recordings are
    simulated alike: nothing tells these apart, and the largest error that one may have is least there.

    A latch that took up a change of 4 kPa, and none of 2, is as wide as either or anything between.
    """
    found = now.model
    allowed = found.chi2 * (1.0 + 1.0 / found.residual.size)
    for form in found.forms:
        if form.THRESHOLD is None:
            continue
        name = f"{form.NAME}.{form.THRESHOLD}"
        value = found.values[name]
        tried = value * np.geomspace(1.0 / FARTHEST, FARTHEST, TRIED)
        stage = found.stage
        off = stage.simulate({**found.values, name: tried}, found.forms) - stage.target[:, None]
        other = np.flatnonzero(np.mean((off / stage.noise) ** 2, axis=0) > allowed)
        below, above = other[tried[other] < value], other[tried[other] > value]
        if len(below) and len(above):  # else no recording asked for a change that was ignored, or taken up
            middle = 0.5 * float(tried[below[-1] + 1] + tried[above[0] - 1])
            moved = found.with_values({name: middle})
            found = moved if moved.chi2 < allowed else found
    return Candidate(found) if found is not now.model else now


def without_confounded(now: Candidate) -> Candidate:
    """The candidate with each parameter of an effect that the recordings do not tell from others, and which
    is within some standard errors of the value where a part of the effect vanishes, at that value, one after
    the other, the least certain first, and the rest fitted again; unless the error of a free run on rows left
    out is lower with it.

    Of a creep as quick as the lag, say, the recordings tell the product with the weights of the plays alone.
    Each has a large standard error, and a design for all of them would be one for slopes of the loop that no
    recording allows.
    """
    neutral = {f"{f.NAME}.{n}": float(getattr(f(), n)) for f in now.model.forms for n in f.kinds()}
    kept = set[str]()
    while True:
        model = now.model
        told = uncertainty(model.problem, model.vector, model.bounds, corner_of(model.residual))
        tied = np.max(np.abs(told.correlation - np.eye(len(model.names))), axis=1, initial=0.0) > CONFOUNDED
        off = {
            n: abs(model.values[n] - neutral[n]) / e if e else 0.0
            for n, e, both in zip(model.names, told.std_errors, tied, strict=True)
            if both and n in neutral and n not in kept
        }
        least = min(off, key=lambda n: off[n], default=None)
        if least is None or off[least] > SIGMAS:
            break
        less = replace(model.with_values({least: neutral[least]}), fixed=(*model.fixed, least)).fitted()
        without = Candidate(less)
        vanishes = np.isclose(less.without(least.partition(".")[0]).chi2, less.chi2, rtol=1e-6)
        if not vanishes and _free(without) <= (1.0 + COSTS) * _free(now):
            now = without
        else:  # a whole effect is for the search to judge
            kept.add(least)
    return now


def _free(found: Candidate) -> float:
    """Chi-square per row of a free run from the command on rows left out."""
    return float(np.mean(found.left_out.free**2))


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
