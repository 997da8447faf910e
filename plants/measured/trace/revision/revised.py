"""The revised plant of a campaign: its parameters and their errors, and how it does on every recording."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plants.effects.wrist.learnt_block import LearntBlock
from plants.measured.campaigns.begin import Begin, like_fitted
from plants.measured.campaigns.campaign import Campaign
from plants.measured.campaigns.playback import Playback
from plants.measured.fitting.estimate import EstimateErrors, corner_of, uncertainty
from plants.measured.fitting.fit import CHANNELS, Fit
from plants.measured.fitting.free_run import FreeRun, rmse
from plants.measured.fitting.stage import begun
from plants.measured.guess.rig import UNSEEN
from plants.measured.instrument.remark import Remark
from plants.measured.trace.counting.middle import with_reachable_step
from plants.measured.trace.declared import begin_of
from plants.measured.trace.judge import many
from plants.measured.trace.law import LawChoice
from plants.measured.trace.result import StageTrace, Trace
from plants.measured.trace.revision.errors import intervals
from plants.measured.trace.revision.named import named_effects
from plants.measured.trace.revision.size import (
    MATTERS,
    NAMED,
    explained_share,
    remainder,
    remainders_of,
    span,
)
from plants.measured.trace.stages.model import Model
from plants.measured.trace.traced_stage import adopted, excess
from plants.measured.trace.two_rigs import rigs_differ
from plants.parameters.correlation import ParameterCorrelation, all_pairs
from plants.wrist import Wrist

AT_BOUND = 1e-6
"""Share of the range between its bounds within which a parameter is at one of them."""


def revise(
    campaign: Campaign, fit: Fit, base: Fit, stages: tuple[StageTrace, ...], remarks: tuple[str, ...],
    law: LawChoice | None, instrument: tuple[Remark, ...],
) -> Trace:  # fmt: skip
    """The declared plant with what was found of its stages, simulated on every recording.

    base: the fit that was revised: the declared one, or of another hysteresis law."""
    changed = base is not fit
    stages, dropped = _without_what_takes_little(stages, fit)
    forms = tuple(f for s in stages for f in s.model.forms)
    values, errors, together = _parameters(stages, base) if forms or changed else ({}, {}, ())
    for block in (s.block.model for s in stages if s.block is not None):
        values |= {n: v for n, v in block.values.items() if n.startswith(f"{LearntBlock.NAME}.")}
    origin = f"{campaign.name} (sha256 {campaign.checksum[:12]})"
    revised = base.fitted.revised(forms, values, errors, origin) if values else fit.fitted
    runs = tuple(_played(fit, base.begins, Wrist.of(revised), changed))
    alone = _played(fit, base.begins, Wrist.of(base.fitted), changed) if changed and forms else []
    effects = tuple(n for s in stages for n in named_effects(s, errors, revised))
    before = fit.validate_rmse
    after = {c: rmse(runs, c) for c in CHANNELS} if values else before
    stages = tuple(
        # A learnt block names no cause: what was unexplained without it stays so.
        s if s.explained or s.block else replace(s, explained=not _matters(s, fit, runs))
        for s in stages
    )
    whole = all(s.explained for s in stages)
    said = "explained" if effects or changed else "nothing-missing"
    together = together if values else fit.correlations
    revised = replace(revised, remainder=remainders_of(runs, fit.noise), correlation=all_pairs(together))
    if law is not None:
        revised = with_reachable_step(revised)
    assumed = [] if law is None else _scale_assumed(campaign)
    return Trace(
        campaign, fit, said if whole else "unexplained", stages, effects, revised, runs, before, after,
        intervals(runs, before=True), intervals(runs),
        tuple(dict.fromkeys((*remarks, *dropped, *rigs_differ(stages), *_seen_together(stages), *assumed))),
        law, instrument, together, law_alone={c: rmse(alone, c) for c in CHANNELS} if alone else {},
    )  # fmt: skip


def _seen_together(stages: Sequence[StageTrace]) -> list[str]:
    """The remark on effects of a stage of several parts of the rig, between which nothing was logged."""
    named = [f.NAME for s in stages if s.stage.parts > 1 for f in s.model.forms]
    if not named:
        return []
    return [
        f"No pressure was logged: that {', '.join(named)} {'is' if len(named) == 1 else 'are'} of the "
        "regulator or of the joint is told from the angle alone; a recording with the pressure would test it."
    ]


def _scale_assumed(campaign: Campaign) -> list[str]:
    """The remark on the pressures of a guessed rig of which none was logged."""
    if any(r.pressure is not None for r in campaign.fit):
        return []
    unit = campaign.units.pressure
    return [
        f"No pressure was logged: that of the plant is on an assumed scale, {UNSEEN:g} {unit} over the range "
        "of the command; only ratios of pressures and angles per command are measured."
    ]


def _without_what_takes_little(
    stages: tuple[StageTrace, ...], fit: Fit
) -> tuple[tuple[StageTrace, ...], list[str]]:
    """The stages, without effects where they neither explain one nor help; and the remark that says so."""
    kept = tuple(adopted(s, fit) for s in stages)
    idle = [s for s, k in zip(stages, kept, strict=True) if k is not s]
    if not idle:
        return stages, []
    tried = ", ".join(f.NAME for s in idle for f in s.model.forms)
    return kept, [f"Tried and not adopted, since more than half of what is left stays: {tried}."]


def _parameters(
    stages: Sequence[StageTrace], base: Fit
) -> tuple[dict[str, float], dict[str, float | None], tuple[ParameterCorrelation, ...]]:
    """Values of what was fitted in each stage, standard errors, and how these errors correlate."""
    values: dict[str, float] = {}
    errors: dict[str, float | None] = {}
    correlations = []
    for s in stages:
        model = s.search.chosen.model
        values |= model.found
        kept = (n for n in model.wrist.hysteresis.NEUTRAL if n in model.fixed)
        values |= {n: model.values[n] for n in kept if n not in base.undetermined}
        found = errors_of(model)
        values |= {n: e for n, e in zip(model.names, at_bounds(model), strict=True) if e is not None}
        own = dict(zip(model.names, found.std_errors, strict=True))
        errors |= own
        told = ParameterCorrelation(model.names, found.correlation)
        correlations.append(told.of(n for n, e in own.items() if e is not None))
    return values, errors, tuple(correlations)


def _matters(stage: StageTrace, fit: Fit, runs: Sequence[FreeRun]) -> bool:
    """Whether what is left of a stage matters: by its share of the range, or because no cause was found for
    most of what the declared model leaves; in recordings that it was fitted on, or in held-out ones."""
    if many(stage.model):
        return True
    channel, noise = stage.stage.channel, stage.stage.noise
    left = max(stage.model.chi2 - 1.0, 0.0)
    large = noise * left**0.5 > MATTERS * span(fit.runs, channel)
    if large or left > (1.0 - NAMED) * excess(stage.search, fit):
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
    kept = [s if e is None else None for s, e in zip(found.std_errors, at_bounds(model), strict=True)]
    return replace(found, std_errors=kept)


def at_bounds(model: Model) -> list[float | None]:
    """The bound at which each parameter of a model lies, None for one that lies at none: a minimum at a bound
    is found a rounding error beside it."""
    x, low, high = model.bounds
    near = np.where(x - low < high - x, low, high)
    return [
        float(b) if abs(b - v) < AT_BOUND * (h - a) else None
        for v, a, h, b in zip(x, low, high, near, strict=True)
    ]


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
                else like_fitted(run.recording, rest, wrist.rig, begins)
            )
        after = run.pressure, run.angle
        if wrist.effects or changed:
            pressure, angle = Playback(run.recording, wrist.rig.sample_time).play(wrist, begun(wrist, begin))
            after = pressure, None if run.angle is None else angle
        found.append(FreeRun(run.recording, run.role, *after, run.pressure, run.angle))
    return found
