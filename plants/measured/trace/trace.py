"""The trace of a campaign: the residuals of the declared model, their cause, and the revised wrist.

Everything is fitted and chosen on the recordings that may be fitted on; the
errors before and after come from the others, simulated freely from the command.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plants.effects.wrist.learnt_block import LearntBlock
from plants.measured.begin import Begin, like_fitted
from plants.measured.campaign import Campaign
from plants.measured.estimate import EstimateErrors, corner_of, uncertainty
from plants.measured.fit import CHANNELS, Fit, fit_campaign
from plants.measured.free_run import FreeRun, rmse
from plants.measured.instrument.remark import Remark
from plants.measured.playback import Playback
from plants.measured.stage import begun
from plants.measured.trace.counting.middle import with_reachable_step
from plants.measured.trace.declared import LOWER, base_fit, begin_of, declared_model, stages_of
from plants.measured.trace.errors import intervals
from plants.measured.trace.experiments import sentence, separate
from plants.measured.trace.judge import alternatives, explained, many, not_logged, unexcited
from plants.measured.trace.law import LawChoice, law_of_rig
from plants.measured.trace.result import Named, StageTrace, Trace
from plants.measured.trace.search.candidate import Candidate, carries_over, falls
from plants.measured.trace.search.choose import (
    EffectSearch,
    carried_over,
    enough,
    from_command,
    search,
    simplest,
)
from plants.measured.trace.search.description import smooth_curves
from plants.measured.trace.search.learning import learn
from plants.measured.trace.search.undetermined import at_neutral, without_bends
from plants.measured.trace.size import MATTERS, NAMED, explained_share, remainder, remainders_of, span
from plants.measured.trace.stages.between_rows import with_commands
from plants.measured.trace.stages.model import Model
from plants.measured.trace.stages.remainders import remainders
from plants.measured.trace.start import Start, starting
from plants.measured.trace.suspect import check
from plants.measured.trace.two_rigs import rigs_differ
from plants.parameters.correlation import ParameterCorrelation, all_pairs
from plants.parameters.quantities import ParameterSet
from plants.wrist import Wrist

Array = NDArray[np.float64]
SLOW_NOISE = 100.0
"""Chi-square up to which a residual without structure, of which no effect takes a good part away, is
slow noise whose floor was taken too low."""

ALONE = (
    "it serves only the recordings that it was fitted on: without it, one that is left out is simulated "
    "better; record more"
)
"""Why an effect that a search found is not kept."""

RETRACED = 2
"""How often a campaign is traced again with what the command of a closed loop did between rows, by the model
that was found."""

REMAINS = 0.25
"""Share of its excess that an effect may leave and still be adopted where not all is explained."""


def trace_campaign(
    campaign: Campaign,
    start: ParameterSet | None = None,
    seed: int = 0,
    progress: Callable[[str, float], None] | None = None,
    learning: bool = False,
    either_way: bool = False,
) -> Trace:
    """Find the effects that the declared wrist lacks, from recordings of a rig.

    `start` gives starting values and bounds of the declared parameters; where it is not given they are those
    of the built-in motion of that name, or, for any other, guessed from the log, and the hysteresis law is
    chosen.  learning: what no effect explains of the angle is learnt, and added to the revised plant where
    that lowers the error on rows left out.  either_way: a design follows, so that the angle of a guessed rig
    that bends to one side is counted from the middle of its range.  Raises InputError where the recordings
    cannot be fitted at all.
    """
    from threadpoolctl import threadpool_limits

    # Small matrices: a second thread of linear algebra would only get in the way of the simulations.
    with threadpool_limits(1):
        return _trace(campaign, start, seed, progress or (lambda what, share: None), learning, either_way)


def _trace(
    campaign: Campaign, given: ParameterSet | None, seed: int, tell: Callable[[str, float], None],
    learning: bool, either_way: bool,
) -> Trace:  # fmt: skip
    begun = starting(campaign, given, either_way)
    found = _traced(begun, seed, tell, learning)
    for _ in range(RETRACED):
        timed = with_commands(begun, found.stages[0].search.chosen.model)
        if timed is None:
            break
        begun = timed
        found = _traced(begun, seed, tell, learning)
    return found


def _traced(begun: Start, seed: int, tell: Callable[[str, float], None], learning: bool) -> Trace:
    campaign = begun.campaign
    remarks = check(campaign)
    tell("fitting the declared wrist", 0.0)
    fit = fit_campaign(campaign, begun.parameters, begun.starts, seed, apart=not begun.guessed)
    tell("choosing the hysteresis law", 0.1)
    law = law_of_rig(begun, fit, seed)
    base = base_fit(fit, law)
    start = base.fitted if base is not fit else begun.parameters
    values: dict[str, float] = dict(base.fitted.values)
    traced: list[StageTrace] = []
    for stage in stages_of(campaign, base):
        share = 0.15 + 0.4 * len(traced)
        declared = declared_model(stage, start, base, values, traced[0].search.chosen if traced else None)
        if base is fit:
            base = fit = _once_more(campaign, start, fit, declared, seed)
        found = _trace_stage(declared, base, _part(tell, share), seed)
        values |= {n: found.model.values[n] for n in found.model.names}
        traced.append(found)
    if law is not None and not traced[-1].explained:
        law, traced[-1] = _under_others(campaign, fit, law, traced, _part(tell, 0.8), seed)
        base = base_fit(fit, law)
    tell("judging", 0.9)
    named = _result(campaign, fit, base, tuple(traced), remarks, law, begun.instrument)
    if not learning:
        return named
    tell("learning what is left", 0.92)
    stages = tuple(map(_learnt, named.stages))
    if all(s.block is None for s in stages):
        return replace(named, learning=True)
    whole = _result(campaign, fit, base, stages, named.remarks, law, begun.instrument)
    return replace(whole, named_only=named.after, learning=True)


def _under_others(
    campaign: Campaign, fit: Fit, law: LawChoice, traced: Sequence[StageTrace], tell: Callable[[str], None],
    seed: int,
) -> tuple[LawChoice, StageTrace]:  # fmt: skip
    """The last stage under each of the laws, where that which was chosen before effects were looked for
    leaves it unexplained, and the choice: another than that only with effects that are adopted, if on rows
    left out the error of a free run is lower for certain and as much goes as an effect must take away, and no
    recording left out whole says clearly otherwise.  The laws alone have been compared before."""
    before, found = traced[:-1], {law.name: traced[-1]}
    for name in law.others:
        base = base_fit(fit, law.taking(name))
        values = dict(base.fitted.values)
        for s in before:
            values |= {n: s.model.values[n] for n in s.model.names}
        regulator = before[0].search.chosen if before else None
        declared = declared_model(stages_of(campaign, base)[-1], base.fitted, base, values, regulator)
        found[name] = _trace_stage(declared, base, tell, seed)
    errors, best = {n: _free_error(s) for n, s in found.items()}, law.name
    for name in law.others:
        now, other = (found[n].search.chosen for n in (best, name))
        adopted = other.model.forms and (found[name].explained or _helps(found[name].search, fit))
        best = name if adopted and _better(now, other) else best
    return replace(law if best == law.name else law.taking(best), with_effects=errors), found[best]


def _better(now: Candidate, other: Candidate) -> bool:
    """Whether another law is, with the effects of both."""
    on_blocks = falls(now, other) and enough(now.held_out, other.held_out, now.held_out)
    return on_blocks and not carries_over(other, now)


def _free_error(stage: StageTrace) -> float:
    """Error of a free run on rows left out, in the unit of the channel."""
    return stage.stage.noise * float(np.sqrt(np.mean(stage.search.chosen.left_out.free**2)))


def _part(tell: Callable[[str, float], None], share: float) -> Callable[[str], None]:
    return lambda what: tell(what, share)


def _once_more(campaign: Campaign, start: ParameterSet, fit: Fit, declared: Model, seed: int) -> Fit:
    """The fit, from the values of a declared model that found a lower minimum if there is one."""
    channel = declared.stage.channel
    error, noise = fit.fit_rmse[channel], declared.stage.noise
    if error is None or declared.chi2 >= LOWER * (error / noise) ** 2:
        return fit
    moved = {n: replace(p, value=declared.values[n]) for n, p in start.parameters.items()}
    again = fit_campaign(campaign, replace(start, parameters=moved), 1, seed)
    return again if (again.fit_rmse[channel] or 0.0) ** 2 < LOWER * error**2 else fit


def _trace_stage(declared: Model, fit: Fit, tell: Callable[[str], None], seed: int) -> StageTrace:
    stage = declared.stage
    logged = [n for n in stage.effects if not not_logged(declared, n)]
    found = search(declared, logged, lambda what: tell(f"{stage.name}: {what}"), seed)
    searched = found.chosen.model.effects
    found = replace(found, chosen=carried_over(found.chosen, found.declared))
    alone = {n: ALONE for n in searched if n not in found.chosen.model.effects}
    if found.chosen.model.forms and (explained(found) or _calm(found.chosen) or _helps(found, fit)):
        found = replace(found, chosen=simplest(found.chosen))
    if not explained(found):
        found = replace(found, chosen=from_command(found.chosen))
    found = replace(found, chosen=without_bends(at_neutral(found.chosen)))
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


def _learnt(stage: StageTrace) -> StageTrace:
    """The stage with a learnt block, where the angle is left unexplained and the block is worth it."""
    block = None if stage.explained or stage.stage.channel != "angle_deg" else learn(stage.search.chosen)
    if block is None:
        return stage
    words = smooth_curves(remainders(block.model), _numeric(block.examined.depends_on))
    return replace(stage, block=block, after=block.examined, description=words)


def _numeric(depends_on: Sequence[str]) -> list[str]:
    """The variables to describe a residual by: what it was found to depend on, time where it wanders."""
    return list(dict.fromkeys("time_s" if d == "time" else d for d in depends_on))


def _result(
    campaign: Campaign, fit: Fit, base: Fit, stages: tuple[StageTrace, ...], remarks: tuple[str, ...],
    law: LawChoice | None, instrument: tuple[Remark, ...],
) -> Trace:  # fmt: skip
    """base: the fit that was revised: the declared one, or of another hysteresis law."""
    changed = base is not fit
    forms = tuple(f for s in stages for f in s.model.forms)
    dropped = [
        s for s in stages if s.search.chosen.model.forms and not (s.explained or _helps(s.search, fit))
    ]
    if dropped:
        tried = ", ".join(f.NAME for s in dropped for f in s.model.forms)
        remarks = (
            *remarks,
            f"Tried and not adopted, since too little of what is left goes with it: {tried}.",
        )
        stages = tuple(s.without_effects if s in dropped else s for s in stages)
        forms = tuple(f for s in stages for f in s.model.forms)
    values: dict[str, float] = {}
    errors: dict[str, float | None] = {}
    correlations: list[ParameterCorrelation] = []
    for s in stages:
        if forms or changed:
            named = s.search.chosen.model
            values |= {n: named.values[n] for n in named.names}
            kept = (n for n in named.wrist.hysteresis.NEUTRAL if n in named.fixed)
            values |= {n: named.values[n] for n in kept if n not in base.undetermined}
            found = errors_of(named)
            of = dict(zip(named.names, found.std_errors, strict=True))
            errors |= of
            of_stage = ParameterCorrelation(named.names, found.correlation)
            correlations += [of_stage.of(n for n, e in of.items() if e is not None)]
    for block in (s.block.model for s in stages if s.block is not None):
        values |= {n: v for n, v in block.values.items() if n.startswith(f"{LearntBlock.NAME}.")}
    origin = f"{campaign.name} (sha256 {campaign.checksum[:12]})"
    revised = base.fitted.revised(forms, values, errors, origin) if values else fit.fitted
    runs = tuple(_played(fit, base.begins, Wrist.of(revised), changed))
    effects = tuple(n for s in stages for n in _named(s, errors, revised))
    before = fit.validate_rmse
    after = {c: rmse(runs, c) for c in CHANNELS} if values else before
    stages = tuple(
        # A learnt block names no cause: what was unexplained without it stays so.
        s if s.explained or s.block else replace(s, explained=not _matters(s, fit, runs))
        for s in stages
    )
    whole = all(s.explained for s in stages)
    said = "explained" if effects or changed else "nothing-missing"
    together = tuple(correlations) if values else fit.correlations
    revised = replace(revised, remainder=remainders_of(runs, fit.noise), correlation=all_pairs(together))
    if law is not None:
        revised = with_reachable_step(revised)
    return Trace(
        campaign, fit, said if whole else "unexplained", stages, effects, revised, runs, before, after,
        intervals(runs, before=True), intervals(runs),
        tuple(dict.fromkeys((*remarks, *rigs_differ(stages)))), law, instrument,
        together,
    )  # fmt: skip


def _matters(stage: StageTrace, fit: Fit, runs: Sequence[FreeRun]) -> bool:
    """Whether what is left of a stage matters: by its share of the range, or because no cause was found for
    most of what the declared model leaves; in recordings that it was fitted on, or in held-out ones."""
    if many(stage.model):
        return True
    channel, noise = stage.stage.channel, stage.stage.noise
    left = max(stage.model.chi2 - 1.0, 0.0)
    large = noise * left**0.5 > MATTERS * span(fit.runs, channel)
    if large or left > (1.0 - NAMED) * _excess(stage.search, fit):
        return True
    held_out = remainder(runs, channel, noise)
    named = explained_share(fit.validate_rmse[channel], rmse(runs, channel), noise)
    return held_out is not None and (
        held_out.share_of_range > MATTERS or (named is not None and named < NAMED)
    )


def errors_of(model: Model) -> EstimateErrors:
    """Standard errors of the parameters of a model, in the order of its names, None for one that lies at a
    bound or is not determined; and their correlation."""
    found = uncertainty(model.problem, model.vector, model.bounds, corner_of(model.residual))
    x, low, high = model.bounds
    at_edge = np.minimum(x - low, high - x) < 1e-6 * (high - low)
    kept = [None if e else s for s, e in zip(found.std_errors, at_edge, strict=True)]
    return replace(found, std_errors=kept)


def _played(fit: Fit, begins: Sequence[Begin] | None, wrist: Wrist, changed: bool) -> list[FreeRun]:
    """Every recording beside the free runs of both wrists; begins: where those to fit on start under the law
    of the revised one; changed: whether that is another one."""
    found = []
    fitted_begins = iter(begins or ())
    for run in fit.runs:
        begin = None
        if begins is not None:
            rest = fit.before.values["rest_pressure"]
            fitted = run.role == "fit"
            begin = (
                begin_of(run.recording, next(fitted_begins))
                if fitted
                else like_fitted(run.recording, rest, begins)
            )
        after = run.pressure, run.angle
        if wrist.effects or changed:
            pressure, angle = Playback(run.recording, wrist.rig.sample_time).play(wrist, begun(wrist, begin))
            after = pressure, None if run.angle is None else angle
        found.append(FreeRun(run.recording, run.role, *after, run.pressure, run.angle))
    return found


def _helps(found: EffectSearch, fit: Fit) -> bool:
    """Whether effects that do not explain all of a stage are worth having: with the hysteresis law they take
    away most of what chi-square of the declared model has above 1.  That a free run from the command falls on
    rows left out each of them had to show before it was taken."""
    return found.chosen.model.chi2 - 1.0 <= REMAINS * _excess(found, fit)


def _excess(found: EffectSearch, fit: Fit) -> float:
    """What chi-square of the declared model of a stage has above 1, under the law that was declared."""
    declared = found.declared.model
    error = fit.fit_rmse[declared.stage.channel] or 0.0
    return max(declared.chi2, (error / declared.stage.noise) ** 2) - 1.0


def _named(s: StageTrace, errors: Mapping[str, float | None], revised: ParameterSet) -> list[Named]:
    beside = alternatives(s.search)
    found = []
    mine = s.search.chosen.model
    for form in mine.forms:
        prefix = f"{form.NAME}."
        parameters = {
            n: (revised.values[prefix + n], kind.unit, errors[prefix + n]) for n, kind in form.kinds().items()
        }
        others = {_other(mine, c.model): c.model for c in beside[form.NAME]}
        words = tuple(
            sentence(form.NAME, name, separate(
                mine.wrist, m.wrist, s.stage.channel, s.stage.noise
            ))
            for name, m in others.items()
        )  # fmt: skip
        found.append(Named(form.NAME, form.FORM, form.STAGE, parameters, tuple(others), words))
    return found


def _other(one: Model, other: Model) -> str:
    """The effect that another model has instead."""
    return next(iter(set(other.effects) - set(one.effects)))


__all__ = ["Named", "StageTrace", "Trace", "remainders", "trace_campaign"]
