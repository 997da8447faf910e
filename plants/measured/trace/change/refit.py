"""The structure that a trace found, fitted to another campaign of the same rig: the same parameters, effects
that are no longer needed and effects that are needed beside."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from plants.errors import InputError
from plants.measured.campaigns.campaign import Campaign
from plants.measured.fitting.fit import fit_campaign
from plants.measured.instrument.logger import corrected, counted_from
from plants.measured.instrument.remark import Remark, zero_of
from plants.measured.trace.change.two_steps import std_errors
from plants.measured.trace.declared import driven, stages_of
from plants.measured.trace.judge import alternatives, not_logged
from plants.measured.trace.result import Named, Trace
from plants.measured.trace.search.candidate import WORTH, Candidate, falls
from plants.measured.trace.search.choose import MOST, search
from plants.measured.trace.search.simplify import simplest
from plants.measured.trace.stages.between_rows import with_command
from plants.measured.trace.stages.model import Model
from plants.wrist import Wrist


@dataclass(frozen=True)
class StageRefit:
    """A stage in both campaigns.

    old: the model that the trace chose.  same: its structure on the new campaign.  new: that without effects
    which the new campaign does not need, and with those that it needs beside.  old_errors, new_errors:
    standard errors of the parameters of the old and the new model by name, None for one that is not
    determined.  beside: of each effect that came, others that the new campaign does not tell from it.
    """

    old: Model
    same: Model
    new: Model
    old_errors: Mapping[str, float | None]
    new_errors: Mapping[str, float | None]
    beside: Mapping[str, tuple[str, ...]]

    @property
    def came(self) -> tuple[Named, ...]:
        """Effects that only the new campaign needs."""
        return tuple(
            Named(
                f.NAME, f.FORM, f.STAGE,
                {
                    n: (self.new.values[f"{f.NAME}.{n}"], kind.unit, self.new_errors[f"{f.NAME}.{n}"])
                    for n, kind in f.kinds().items()
                },
                self.beside.get(f.NAME, ()), (),
            )
            for f in self.new.forms
            if f.NAME not in self.old.effects
        )  # fmt: skip

    @property
    def went(self) -> tuple[str, ...]:
        """Effects that the new campaign does not need any more."""
        return tuple(n for n in self.old.effects if n not in self.new.effects)

    @property
    def full(self) -> bool:
        """Whether more is left than noise, and no effect could be added to those that are there."""
        return len(self.new.forms) >= MOST * self.new.stage.parts and Candidate(self.new).lacks_something


def check_comparable(old: Campaign, new: Campaign) -> None:
    """Raise InputError, in a line, for campaigns of different motions, with different channels, whose
    parameters would be others, and for one that is given twice."""
    if old.axis != new.axis:
        raise InputError(
            f"{new.name}: is of {new.axis!r}, {old.name} of {old.axis!r}; give two campaigns of one motion"
        )
    if old.checksum == new.checksum:
        raise InputError(f"{new.name}: holds the same recordings as {old.name}; give a later campaign")
    if _logged(old) != _logged(new):
        raise InputError(
            f"{new.name}: its recordings to fit on log {_logged(new)}, those of {old.name} {_logged(old)}; "
            "give campaigns with the same channels"
        )


def seen_alike(old: Trace, campaign: Campaign) -> tuple[Campaign, tuple[Remark, ...]]:
    """Another campaign without its logger's habits, its channels counted from where those of a trace are, and
    the jumps of its commands at the times at which the traced plant leaves least.

    Raises InputError as `check_comparable` does.
    """
    check_comparable(old.campaign, campaign)
    campaign, remarks = corrected(campaign)
    campaign, plant = counted_from(campaign, zero_of(old.instrument)), Wrist.of(old.revised)
    fit, validate = (tuple(with_command(r, plant) for r in of) for of in (campaign.fit, campaign.validate))
    return replace(campaign, fit=fit, validate=validate), remarks


def _logged(campaign: Campaign) -> str:
    pressure = any(r.pressure is not None for r in campaign.fit)
    return " and ".join(
        [*(["pressure"] if pressure else []), *(["angle"] if campaign.stage == "wrist" else [])]
    )


def refit(
    old: Trace, campaign: Campaign, changed: bool, seed: int = 0,
    progress: Callable[[str, float], None] | None = None,
) -> tuple[StageRefit, ...]:  # fmt: skip
    """Each stage of a trace, fitted to another campaign from where the trace ended.

    campaign: as `seen_alike` gives it.  changed: whether effects are looked for that went or came; else the
    structure is kept.  Raises InputError where the recordings cannot be fitted at all.
    """
    from threadpoolctl import threadpool_limits

    tell = progress or (lambda what, share: None)
    with threadpool_limits(1):
        declared = old.stages[0].model.start
        moved = {n: replace(p, value=old.revised.values[n]) for n, p in declared.parameters.items()}
        tell("fitting the declared wrist", 0.0)
        fit = fit_campaign(campaign, replace(declared, parameters=moved), 1, seed)
        found: list[StageRefit] = []
        before: Candidate | None = None
        for number, (stage, traced) in enumerate(zip(stages_of(campaign, fit), old.stages, strict=True)):
            tell(f"fitting the {traced.name}", 0.3 + 0.35 * number)
            model, first = replace(traced.model, stage=stage), tuple(found[:1])
            if before is not None:
                model = driven(model.with_values(before.model.found), before)
            same = Candidate(model.fitted())
            before, beside = _chosen(same, seed) if changed else (same, {})
            was, now = traced.model.fitted(), before.model  # at the same least squares
            found.append(
                StageRefit(
                    was, same.model, now, std_errors(was, *(f.old for f in first)),
                    std_errors(now, *(f.new for f in first)), beside,
                )
            )  # fmt: skip
    return tuple(found)


def _chosen(same: Candidate, seed: int) -> tuple[Candidate, dict[str, tuple[str, ...]]]:
    """The structure with effects that came, where it leaves more than the noise, and without those that
    went; of those that came, what they are not told from."""
    now, beside = same, dict[str, tuple[str, ...]]()
    if same.lacks_something:
        logged = [n for n in same.model.stage.effects if not not_logged(same.model, n)]
        found = search(_bare(same.model), logged, seed=seed, present=same)
        now = same if found.chosen is same else simplest(found.chosen)
        others = alternatives(replace(found, chosen=now))
        beside = {
            n: tuple(dict.fromkeys(e for c in of for e in c.model.effects if e not in now.model.effects))
            for n, of in others.items()
        }
    for name in same.model.effects:
        if name in now.model.effects:
            less = Candidate(now.model.without(name).fitted())
            now = now if needs(less, now) else less
    return now, beside


def _bare(model: Model) -> Model:
    """The model without any effect, fitted."""
    if not model.forms:
        return model
    for name in model.effects:
        model = model.without(name)
    return model.fitted()


def needs(without: Candidate, with_it: Candidate) -> bool:
    """Whether an effect that was there still is: without it the error of a free run rises on rows left out,
    for certain, and by more than an imperfection of a form would."""
    return falls(without, with_it) and without.held_out - with_it.held_out > WORTH
