"""The effects that a stage names, with their parameters and what the data does not tell them from."""

from collections.abc import Mapping

from plants.measured.trace.experiments import sentence, separate
from plants.measured.trace.judge import alternatives
from plants.measured.trace.result import Named, StageTrace
from plants.measured.trace.stages.model import Model
from plants.parameters.quantities import ParameterSet


def named_effects(s: StageTrace, errors: Mapping[str, float | None], revised: ParameterSet) -> list[Named]:
    """Each effect of a stage with its parameters' values and standard errors in the revised set, the effects
    that this data does not tell from it, and the recording that would."""
    beside = alternatives(s.search)
    found = []
    mine = s.search.chosen.model
    for form in mine.forms:
        prefix = f"{form.NAME}."
        parameters = {
            n: (revised.values[prefix + n], kind.unit, errors.get(prefix + n))
            for n, kind in form.kinds().items()
        }
        others = {_other(mine, c.model): c.model for c in beside[form.NAME]}
        words = tuple(
            sentence(form.NAME, name, separate(mine.wrist, m.wrist, s.stage.channel, s.stage.noise))
            for name, m in others.items()
        )
        found.append(Named(form.NAME, form.FORM, form.STAGE, parameters, tuple(others), words))
    return found


def _other(one: Model, other: Model) -> str:
    """The effect that another model has instead."""
    return next(iter(set(other.effects) - set(one.effects)))
