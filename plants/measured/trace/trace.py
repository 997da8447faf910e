"""The trace of a campaign: what the declared wrist leaves, what causes it, and the revised wrist.

Everything is fitted and chosen on the recordings that may be fitted on; the
errors before and after come from the others, simulated freely from the command.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaign import Campaign
from plants.measured.estimate import HUBER, standard_errors
from plants.measured.fit import CHANNELS, Fit, fit_campaign
from plants.measured.free_run import FreeRun, rmse, squares
from plants.measured.playback import Playback
from plants.measured.problem import first_begin, measured
from plants.measured.trace.declared import LOWER, driven, refitted
from plants.measured.trace.errors import intervals
from plants.measured.trace.experiments import sentence, separate
from plants.measured.trace.judge import alternatives, explained, not_logged, unexcited
from plants.measured.trace.result import Named, StageTrace, Trace
from plants.measured.trace.search.choose import search
from plants.measured.trace.search.learnt import learn
from plants.measured.trace.stages.model import Model
from plants.measured.trace.stages.remainders import begun, remainders
from plants.measured.trace.stages.stage import Stage
from plants.measured.trace.suspect import check
from plants.measured.trace.two_rigs import rigs_differ
from plants.parameters.quantities import ParameterSet, loop_names
from plants.wrist import Wrist

Array = NDArray[np.float64]
SLOW_NOISE = 100.0
"""Chi-square up to which a remainder without structure, of which no effect takes a good part away, is
slow noise whose floor was taken too low."""

REMAINS = 0.25
"""Share of its excess that an effect may leave and still be adopted where not all is explained."""


def trace_campaign(
    campaign: Campaign,
    start: ParameterSet,
    seed: int = 0,
    progress: Callable[[str, float], None] | None = None,
) -> Trace:
    """Find what the declared wrist lacks of a rig, from its recordings.

    `start` gives starting values and bounds of the declared parameters.  Raises
    InputError where the recordings cannot be fitted at all.
    """
    from threadpoolctl import threadpool_limits

    # Small matrices: a second thread of linear algebra would only get in the way of the simulations.
    with threadpool_limits(1):
        return _trace(campaign, start, seed, progress or (lambda what, share: None))


def _trace(campaign: Campaign, start: ParameterSet, seed: int, tell: Callable[[str, float], None]) -> Trace:
    remarks = check(campaign)
    tell("fitting the declared wrist", 0.0)
    fit = fit_campaign(campaign, start, starts=3, seed=seed)
    values: dict[str, float] = dict(fit.fitted.values)
    traced: list[StageTrace] = []
    for stage in _stages(campaign, fit):
        share = 0.15 + 0.4 * len(traced)
        declared = Model(stage, start, values, fixed=_fixed(stage, fit))
        declared = driven(declared, traced[0]) if stage.name == "wrist" else refitted(declared)
        fit = _once_more(campaign, start, fit, declared, seed)
        found = _trace_stage(declared, fit, _part(tell, share), seed)
        values |= {n: found.model.values[n] for n in found.model.names}
        traced.append(found)
    tell("judging", 0.95)
    return _result(campaign, fit, tuple(traced), remarks)


def _part(tell: Callable[[str, float], None], share: float) -> Callable[[str], None]:
    return lambda what: tell(what, share)


def _stages(campaign: Campaign, fit: Fit) -> list[Stage]:
    """What can be traced one after the other."""

    def made(name: str, channel: str) -> Stage:
        used = [i for i, r in enumerate(campaign.fit) if measured(r, channel) is not None]
        begins = None if fit.begins is None else tuple(fit.begins[i] for i in used)
        floor = fit.noise[channel] or 1.0
        rig = fit.before.rig
        played = tuple(Playback(campaign.fit[i], rig.sample_time) for i in used)
        return Stage(name, channel, floor, played, loop_names(fit.fitted.parameters), rig, None, begins)  # type: ignore[arg-type]

    pressure = any(r.pressure is not None for r in campaign.fit)
    stages = [made("regulator", "pressure_kPa")] if pressure else []
    if campaign.stage == "wrist":
        stages.append(made("wrist" if pressure else "whole", "angle_deg"))
    return stages


def _fixed(stage: Stage, fit: Fit) -> tuple[str, ...]:
    return tuple(n for n in fit.undetermined if n in stage.declared)


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
    model, blind = found.chosen.model, unexcited(declared, found.rounds[0].ranking)
    before, after = found.declared.examined, found.chosen.examined
    # Stationary sensor noise, however coloured, is not a missing effect.
    good = explained(found) or (not after.structured and model.chi2 < SLOW_NOISE)
    learnt = None if good else learn(remainders(model), _numeric(after.depends_on))
    return StageTrace(stage, found, before, after, good, blind, learnt)


def _numeric(depends_on: Sequence[str]) -> list[str]:
    """The variables to describe a remainder by: what it was found to depend on, time where it wanders."""
    return list(dict.fromkeys("time_s" if d == "time" else d for d in depends_on))


def _result(campaign: Campaign, fit: Fit, stages: tuple[StageTrace, ...], remarks: tuple[str, ...]) -> Trace:
    forms = tuple(f for s in stages for f in s.model.forms)
    values: dict[str, float] = {}
    errors: dict[str, float | None] = {}
    for s in stages:
        if forms:
            values |= {n: s.model.values[n] for n in s.model.names}
            errors |= _errors(s.model)
    origin = f"{campaign.name} (sha256 {campaign.checksum[:12]})"
    revised = fit.fitted.revised(forms, values, errors, origin) if forms else fit.fitted
    runs = tuple(_played(fit, Wrist.of(revised)))
    effects = tuple(n for s in stages for n in _named(s, errors, revised))
    whole = all(s.explained for s in stages)
    if forms and not whole and not _helps(stages, runs, campaign.stage):
        tried = ", ".join(f.NAME for f in forms)
        remarks = (
            *remarks,
            f"Tried and not adopted: {tried}. It takes away too little of what is left, or makes free runs "
            "from the command worse on a recording that it was fitted on.",
        )
        revised, effects = fit.fitted, ()
        runs = tuple(_played(fit, Wrist.of(revised)))
    before = fit.validate_rmse
    after = {c: rmse(runs, c) for c in CHANNELS} if effects else before
    verdict = ("explained" if effects else "nothing-missing") if whole else "unexplained"
    return Trace(
        campaign, fit, verdict, stages, effects, revised, runs, before, after,
        intervals(runs, before=True), intervals(runs),
        (*remarks, *rigs_differ(stages)),
    )  # fmt: skip


def _errors(model: Model) -> dict[str, float | None]:
    """Standard errors of the parameters, None for one that lies at a bound or is not determined."""
    corner = HUBER * max(1.0, 1.4826 * float(np.median(np.abs(model.residual))))
    found = standard_errors(model.problem, model.vector, model.bounds, corner)
    x, low, high = model.bounds
    at_edge = np.minimum(x - low, high - x) < 1e-6 * (high - low)
    return {n: None if e else s for n, s, e in zip(model.names, found, at_edge, strict=True)}


def _played(fit: Fit, wrist: Wrist) -> list[FreeRun]:
    """Every recording beside the free runs of both wrists."""
    found = []
    fitted_begins = iter(fit.begins or ())
    for run in fit.runs:
        begin = None
        if fit.begins is not None:
            rest = fit.before.values["rest_pressure"]
            begin = next(fitted_begins) if run.role == "fit" else first_begin(run.recording, rest)
        after = run.pressure, run.angle
        if wrist.effects:
            pressure, angle = Playback(run.recording, wrist.rig.sample_time).play(wrist, begun(wrist, begin))
            after = pressure, None if run.angle is None else angle
        found.append(FreeRun(run.recording, run.role, *after, run.pressure, run.angle))
    return found


def _helps(stages: Sequence[StageTrace], runs: Sequence[FreeRun], stage: str) -> bool:
    """Whether effects that do not explain all are worth having: they take away most of what chi-square
    has above 1, and no recording that they were fitted on is worse for them in a free run from the
    command, which is how the plant will be used."""
    for s in stages:
        excess = s.search.declared.model.chi2 - 1.0
        if s.model.forms and s.model.chi2 - 1.0 > REMAINS * excess:
            return False
    channel = "pressure_kPa" if stage == "regulator" else "angle_deg"
    before, after = (squares(runs, channel, earlier, "fit") for earlier in (True, False))
    each = all(a.mean() <= 1.02 * b.mean() for a, b in zip(after, before, strict=True))
    return each and sum(a.sum() for a in after) < 0.9 * sum(b.sum() for b in before)


def _named(s: StageTrace, errors: Mapping[str, float | None], revised: ParameterSet) -> list[Named]:
    beside = alternatives(s.search)
    found = []
    for form in s.model.forms:
        prefix = f"{form.NAME}."
        parameters = {
            n: (revised.values[prefix + n], kind.unit, errors[prefix + n]) for n, kind in form.kinds().items()
        }
        others = {_other(s.model, c.model): c.model for c in beside[form.NAME]}
        mine = s.model.wrist
        words = tuple(
            sentence(form.NAME, name, separate(
                mine, m.wrist, s.stage.channel, s.stage.noise
            ))
            for name, m in others.items()
        )  # fmt: skip
        found.append(Named(form.NAME, form.FORM, form.STAGE, parameters, tuple(others), words))
    return found


def _other(one: Model, other: Model) -> str:
    """The effect that another model has instead."""
    return next(iter(set(other.effects) - set(one.effects)))


__all__ = ["Named", "StageTrace", "Trace", "remainders", "trace_campaign"]
