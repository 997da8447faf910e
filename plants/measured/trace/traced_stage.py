"""The trace of a stage: the effects that a search keeps of what it found, and how much they leave."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from plants.measured.fitting.fit import Fit
from plants.measured.trace.judge import explained, many, not_logged, unexcited
from plants.measured.trace.ranking.backwards import makes_no_loop, with_a_loop
from plants.measured.trace.result import StageTrace
from plants.measured.trace.search.candidate import Candidate
from plants.measured.trace.search.choose import search, search_from_common
from plants.measured.trace.search.description import smooth_curves
from plants.measured.trace.search.learning import learn
from plants.measured.trace.search.rounds import EffectSearch
from plants.measured.trace.search.simplify import carried_over, from_command, simplest, started_anew
from plants.measured.trace.search.undetermined import (
    at_neutral,
    in_their_middle,
    without_bends,
    without_confounded,
)
from plants.measured.trace.stages.model import Model
from plants.measured.trace.stages.remainders import remainders

SLOW_NOISE = 100.0
"""Chi-square up to which a residual without structure, of which no effect takes a good part away, is
slow noise whose floor was taken too low."""

ALONE = (
    "it serves only the recordings that it was fitted on: without it, one that is left out is simulated "
    "better; record more"
)
"""Why an effect that a search found is not kept."""

REMAINS = 0.5
"""Share of its excess that effects may leave and still be adopted where not all is explained: each has shown
on rows left out that it serves, and a rig that lacks two things is simulated better with one of them."""


def trace_stage(declared: Model, fit: Fit, tell: Callable[[str], None], seed: int) -> StageTrace:
    """Search a stage of a declared model for effects, and keep of them what serves more than the recordings
    that they were fitted on."""
    stage = declared.stage
    logged = [n for n in stage.effects if not not_logged(declared, n)]

    def say(what: str) -> None:
        tell(f"{stage.name}: {what}")

    found = search(declared, logged, say, seed)
    kept = carried_over(started_anew(found.chosen), found.declared)
    if stage.parts > 1 and not explained(found):
        found, kept = search_from_common(found, kept, logged, say, seed)
    searched = found.chosen.model.effects
    found = replace(found, chosen=kept)
    alone = {n: ALONE for n in searched if n not in found.chosen.model.effects}
    if found.chosen.model.forms and (explained(found) or _calm(found.chosen) or helps(found, fit)):
        found = replace(found, chosen=simplest(found.chosen))
    clean = without_bends(without_confounded(at_neutral(in_their_middle(found.chosen))))
    found = replace(found, chosen=at_neutral(clean))  # what fitted again left them anywhere once more
    if not explained(found):  # last, since the others fit to the pressure that was measured
        found = replace(found, chosen=from_command(found.chosen))
    if found.chosen.model.forms and makes_no_loop(found.chosen.model):
        found = replace(found, chosen=Candidate(with_a_loop(found.chosen.model)))
    model, blind = found.chosen.model, unexcited(declared, found.rounds[0].ranking)
    borrowed = {n: why for r in found.rounds for n, why in r.borrowed.items()}
    blind = {**blind, **{n: why for n, why in (borrowed | alone).items() if n not in model.effects}}
    before, after = found.declared.examined, found.chosen.examined
    good = explained(found) or _calm(found.chosen)
    words = None if good else smooth_curves(remainders(model), _numeric(after.depends_on))
    return StageTrace(stage, found, before, after, good, blind, words)


def _calm(found: Candidate) -> bool:
    """Whether what is left is stationary noise of the sensor: however coloured, that is no missing effect."""
    return not found.examined.structured and found.model.chi2 < SLOW_NOISE and not many(found.model)


def _numeric(depends_on: Sequence[str]) -> list[str]:
    """The variables to describe a residual by: what it was found to depend on, time where it wanders."""
    return list(dict.fromkeys("time_s" if d == "time" else d for d in depends_on))


def with_learnt_block(stage: StageTrace) -> StageTrace:
    """The stage with a learnt block, where the angle is left unexplained and the block is worth it."""
    block = None if stage.explained or stage.stage.channel != "angle_deg" else learn(stage.search.chosen)
    if block is None:
        return stage
    words = smooth_curves(remainders(block.model), _numeric(block.examined.depends_on))
    return replace(stage, block=block, after=block.examined, description=words)


def adopted(stage: StageTrace, fit: Fit) -> StageTrace:
    """The stage, without effects where they neither explain it nor help, or leave no loop of a law that made
    one without them."""
    chosen, declared = stage.search.chosen.model, stage.search.declared.model
    idle = chosen.forms and not (stage.explained or helps(stage.search, fit))
    idle = idle or (makes_no_loop(chosen) and not makes_no_loop(declared))
    return stage.without_effects if idle else stage


def helps(found: EffectSearch, fit: Fit) -> bool:
    """Whether effects that do not explain all of a stage are worth having: with the hysteresis law they take
    away most of what chi-square of the declared model has above 1.  That a free run from the command falls on
    rows left out each of them had to show before it was taken."""
    return found.chosen.model.chi2 - 1.0 <= REMAINS * excess(found, fit)


def excess(found: EffectSearch, fit: Fit) -> float:
    """What chi-square of the declared model of a stage has above 1, under the law that was declared."""
    declared = found.declared.model
    error = fit.fit_rmse[declared.stage.channel] or 0.0
    return max(declared.chi2, (error / declared.stage.noise) ** 2) - 1.0
