"""The trace of a campaign: the residuals of the declared model, their cause, and the revised wrist.

Everything is fitted and chosen on the recordings that may be fitted on; the
errors before and after come from the others, simulated freely from the command.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.campaign import Campaign
from plants.measured.fitting.fit import Fit, fit_campaign, on_held_out
from plants.measured.fitting.stage import Stage
from plants.measured.trace.counting.middle import about_middle
from plants.measured.trace.declared import LOWER, base_fit, declared_model, stages_of
from plants.measured.trace.law import LawChoice, law_of_rig
from plants.measured.trace.result import StageTrace, Trace
from plants.measured.trace.revision.revised import revise
from plants.measured.trace.search.candidate import Candidate, carries_over, falls
from plants.measured.trace.search.worth import SHARE, enough
from plants.measured.trace.stages.between_rows import with_commands
from plants.measured.trace.stages.model import Model
from plants.measured.trace.start import Start, starting
from plants.measured.trace.suspect import check
from plants.measured.trace.traced_stage import adopted, helps, trace_stage, with_learnt_block
from plants.parameters.quantities import ParameterSet

Array = NDArray[np.float64]
RETRACED = 2
"""How often a campaign is traced again with what the command of a closed loop did between rows, by the model
that was found."""


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
    that lowers the error on rows left out.  either_way: the angle of a guessed rig that bends to one side is
    counted from the middle of its range, see `trace_for_design`.  Raises InputError where the recordings
    cannot be fitted at all.
    """
    from threadpoolctl import threadpool_limits

    # Small matrices: a second thread of linear algebra would only get in the way of the simulations.
    with threadpool_limits(1):
        return _trace(campaign, start, seed, progress or (lambda what, share: None), learning, either_way)


def trace_for_design(
    campaign: Campaign,
    start: ParameterSet | None = None,
    seed: int = 0,
    progress: Callable[[str, float], None] | None = None,
) -> tuple[Trace, ParameterSet]:
    """The trace of a campaign, and the plant that it revised as a design takes it.

    That of a rig that bends to one side is counted from the middle of the range of its log.  Where it cannot
    be, for a law or an effect that counts from where the rig rests, the log of a guessed rig is traced once
    more, counted from there.  Arguments and errors are those of `plants.measured.trace.trace.trace_campaign`.
    """
    trace = trace_campaign(campaign, start, seed, progress)
    if start is None and trace.law is None:  # that of the built-in motion, or a regulator's alone
        return trace, trace.revised
    plant = about_middle(trace.revised, trace.campaign, guessed=start is None)
    if plant is None and start is None:
        trace = trace_campaign(campaign, start, seed, progress, either_way=True)
    return trace, plant or trace.revised


def _trace(
    campaign: Campaign, given: ParameterSet | None, seed: int, tell: Callable[[str, float], None],
    learning: bool, either_way: bool,
) -> Trace:  # fmt: skip
    first = _first_stage(starting(campaign, given, either_way), seed, tell)
    for _ in range(RETRACED):
        timed = with_commands(first.begun, first.model)
        if timed is None:
            break
        # What is held out has no part in the first stage.
        same = all(a is b for a, b in zip(timed.campaign.fit, first.begun.campaign.fit, strict=True))
        first = first.judged_on(timed) if same else _first_stage(timed, seed, tell)
    return _traced(first, seed, tell, learning)


@dataclass(frozen=True)
class _FirstStage:
    """What is known of a campaign when its first stage is traced.

    remarks: on the campaign.  fit: of the declared wrist; law: the choice of its hysteresis law; base: the
    fit with that law.  start: starting values and bounds of the declared parameters.  stages: all that can
    be traced, of which `traced` is the first.
    """

    begun: Start
    remarks: tuple[str, ...]
    fit: Fit
    law: LawChoice | None
    base: Fit
    start: ParameterSet
    stages: tuple[Stage, ...]
    traced: StageTrace

    def judged_on(self, begun: Start) -> "_FirstStage":
        """The same of a campaign whose recordings to fit on are the same."""
        fit = on_held_out(self.fit, begun.campaign)
        base = fit if self.base is self.fit else on_held_out(self.base, begun.campaign)
        return replace(self, begun=begun, fit=fit, base=base)

    @property
    def model(self) -> Model:
        """Of the first stage, with the effects that are adopted."""
        return adopted(self.traced, self.fit).search.chosen.model


def _first_stage(begun: Start, seed: int, tell: Callable[[str, float], None]) -> _FirstStage:
    """A campaign as far as what its commands did between rows can be told."""
    campaign = begun.campaign
    remarks = check(campaign)
    tell("fitting the declared wrist", 0.0)
    fit = fit_campaign(campaign, begun.parameters, begun.starts, seed, apart=not begun.guessed)
    tell("choosing the hysteresis law", 0.1)
    law = law_of_rig(begun, fit, seed)
    base = base_fit(fit, law)
    start = base.fitted if base is not fit else begun.parameters
    stages = tuple(stages_of(campaign, base, begun.guessed))
    declared = declared_model(stages[0], start, base, base.fitted.values, None)
    if base is fit:
        base = fit = _once_more(campaign, start, fit, declared, seed)
    traced = trace_stage(declared, base, _part(tell, 0.15), seed)
    return _FirstStage(begun, remarks, fit, law, base, start, stages, traced)


def _traced(first: _FirstStage, seed: int, tell: Callable[[str, float], None], learning: bool) -> Trace:
    begun, fit, law, base = first.begun, first.fit, first.law, first.base
    campaign, traced = begun.campaign, [first.traced]
    for stage in first.stages[1:]:
        values = {**base.fitted.values, **{n: v for s in traced for n, v in s.model.found.items()}}
        declared = declared_model(stage, first.start, base, values, traced[0].search.chosen)
        if base is fit:
            base = fit = _once_more(campaign, first.start, fit, declared, seed)
        traced.append(trace_stage(declared, base, _part(tell, 0.55), seed))
    if law is not None and not traced[-1].explained:
        law, traced[-1] = _under_others(campaign, fit, law, traced, _part(tell, 0.8), seed)
        base = base_fit(fit, law)
    tell("judging", 0.9)
    named = revise(campaign, fit, base, tuple(traced), first.remarks, law, begun.instrument)
    if not learning:
        return named
    tell("learning what is left", 0.92)
    stages = tuple(map(with_learnt_block, named.stages))
    if all(s.block is None for s in stages):
        return replace(named, learning=True)
    whole = revise(campaign, fit, base, stages, named.remarks, law, begun.instrument)
    return replace(whole, named_only=named.after, learning=True)


def _under_others(
    campaign: Campaign, fit: Fit, law: LawChoice, traced: Sequence[StageTrace], tell: Callable[[str], None],
    seed: int,
) -> tuple[LawChoice, StageTrace]:  # fmt: skip
    """The last stage under each of the laws, where that which was chosen before effects were looked for
    leaves it unexplained, and the choice: another than that only with effects that are adopted, if on rows
    left out the error of a free run is lower for certain and as much goes as an effect must take away, and as
    much again for each effect that it needs more, and no recording left out whole says clearly otherwise.
    The laws alone have been compared before."""
    before, found = traced[:-1], {law.name: traced[-1]}
    for name in law.others:
        base = base_fit(fit, law.taking(name))
        values = {**base.fitted.values, **{n: v for s in before for n, v in s.model.found.items()}}
        regulator = before[0].search.chosen if before else None
        declared = declared_model(stages_of(campaign, base, True)[-1], base.fitted, base, values, regulator)
        found[name] = trace_stage(declared, base, tell, seed)
    errors, best = {n: _free_error(s) for n, s in found.items()}, law.name
    for name in law.others:
        now, other = (found[n].search.chosen for n in (best, name))
        adopted = other.model.forms and (found[name].explained or helps(found[name].search, fit))
        best = name if adopted and _better(now, other) else best
    return replace(law if best == law.name else law.taking(best), with_effects=errors), found[best]


def _better(now: Candidate, other: Candidate) -> bool:
    """Whether another law is, with the effects of both."""
    more = max(0, len(other.model.forms) - len(now.model.forms))
    left = now.held_out
    for _ in range(more):
        left -= SHARE * (left - 1.0)
    on_blocks = falls(now, other) and enough(left, other.held_out, now.held_out)
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
