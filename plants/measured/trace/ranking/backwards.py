"""Loops that turn back, or are none: a joint follows its pressure, so that no branch has a negative slope.

Plays beside a loop and curves of its branches may be fitted such that the sum falls somewhere as the pressure
rises.  That stands in for something else, and a controller with an integrator is unstable there.
"""

from dataclasses import replace

from plants.linearisation import slopes_with_effects
from plants.measured.guess.rough_models import extent
from plants.measured.trace.stages.model import Model

ROUNDING = 0.01
"""Share of the largest slope by which one may lie below zero, as a fitted curve does where it is flat."""


def turns_back(model: Model) -> bool:
    """Whether a branch of a model's loop falls as the pressure rises, within the pressures of the recordings
    it is fitted to."""
    stage, wrist = model.stage, model.wrist
    if stage.name == "regulator":
        return False
    commanded = [wrist.regulator.gain * p.recording.command for p in stage.playbacks]
    found = slopes_with_effects(wrist, extent(stage.drives or commanded)).values()
    return min(map(min, found)) < -ROUNDING * max(map(max, found))


def makes_no_loop(model: Model) -> bool:
    """Whether the hysteresis law of a model, without its effects, makes no loop in the range of the command:
    where friction beside it takes up the whole width, lines cross.  A file with such a law is refused."""
    if model.stage.name == "regulator":
        return False
    return model.wrist.hysteresis.problem(*model.wrist.reach) is not None


def with_a_loop(model: Model) -> Model:
    """The model, fitted where its law makes a loop, in the bounds that the law gives; as it is where it makes
    one, or the law gives none."""
    kept = model.wrist.hysteresis.kept_apart(*model.wrist.reach) if makes_no_loop(model) else {}
    if not kept:
        return model
    start = model.start.within(kept, model.values)
    values = {**model.values, **{n: start.parameters[n].value for n in kept}}
    return replace(model, start=start, values=values).fitted()
