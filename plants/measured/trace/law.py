"""Which hysteresis law describes the loop: chosen on rows left out, before effects are looked for.

Each law is fitted from the pressure as it was measured to the angle, so that what the regulator lacks has no
part in the choice; where no pressure was logged, from the command.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from plants.hysteresis import LAWS
from plants.measured.campaigns.begin import Begin
from plants.measured.campaigns.campaign import Campaign
from plants.measured.campaigns.playback import Playback
from plants.measured.fitting.determined import remembered
from plants.measured.fitting.fit import Fit
from plants.measured.fitting.stage import Stage
from plants.measured.guess.regressors import smooth_pressure
from plants.measured.guess.rig import guessed_set
from plants.measured.trace.search.candidate import Candidate
from plants.measured.trace.stages.model import Model
from plants.measured.trace.start import Start
from plants.parameters.quantities import ParameterSet, loop_names

Array = NDArray[np.float64]
BETTER = 0.9
"""Another law is taken if its error on rows left out is below this share of the declared law's."""

STARTS = 4
"""Fits of each law: one from the guess, the others from where it wanders."""

BEGUN, ENDED = 10, 2
"""Evaluations after which these are compared, and how many of them are followed to the end."""


@dataclass(frozen=True)
class LawChoice:
    """The law that was chosen, its parameter set with values fitted to the loop, and the error on rows left
    out [deg] of each law that was tried, by name.

    begins: where the recordings to fit on start under each law, None at rest.  others: parameter sets of the
    laws that were not chosen but make a loop, by name; with_effects: errors as held_out, in a free run from
    the command and with the effects that each law needs, where they decided.  driven: whether the pressure
    was logged, which drives the loop in held_out.
    """

    name: str
    parameters: ParameterSet
    held_out: Mapping[str, float]
    begins: Mapping[str, tuple[Begin, ...] | None]
    others: Mapping[str, ParameterSet] = field(default_factory=dict)
    with_effects: Mapping[str, float] = field(default_factory=dict)
    driven: bool = True

    def taking(self, name: str) -> "LawChoice":
        """The choice of another of the laws."""
        known = {self.name: self.parameters, **self.others}
        return replace(self, name=name, parameters=known.pop(name), others=known)


def law_of_rig(begun: Start, fit: Fit, seed: int = 0) -> LawChoice | None:
    """The choice of a law where it is open, None where it was given or no angle was logged."""
    return (
        choose_law(begun.campaign, fit, seed) if begun.guessed and begun.campaign.stage == "wrist" else None
    )


def choose_law(campaign: Campaign, fit: Fit, seed: int = 0) -> LawChoice:
    """The law with the least error on blocks left out, the declared one where no other is clearly better."""
    declared = fit.fitted.law.NAME
    found: dict[str, tuple[Model, float]] = {}
    for name in LAWS:
        start = _start(campaign, fit, name)
        model = _best(_remembered(_model(campaign, fit, start)), seed)
        found[name] = (model, model.stage.noise * float(np.sqrt(Candidate(model).held_out)))
    makes = [n for n, (m, _) in found.items() if not m.wrist.hysteresis.problem(*_ends(m, fit))] or [declared]
    best = min(makes, key=lambda n: found[n][1])
    loops = fit.no_loop is None
    if declared in found and loops and found[best][1] > BETTER * found[declared][1]:
        best = declared
    origin = f"{campaign.name} (sha256 {campaign.checksum[:12]})"
    sets = {n: fit.fitted if n == declared else _fitted(found[n][0], origin) for n in {*makes, best}}
    begins = {n: _begins(campaign, fit, m) for n, (m, _) in found.items()}
    errors = {n: e for n, (_, e) in found.items()}
    driven = any(m.stage.drives is not None for m, _ in found.values())
    return LawChoice(best, sets.pop(best), errors, begins, sets, driven=driven)


def _remembered(model: Model) -> Model:
    """The model with each recording on the virgin curve or off it, as fits better: under another law that was
    another question."""
    if model.stage.begins is None:
        return model
    return replace(model, stage=replace(model.stage, begins=remembered(model.problem, model.vector)))


def _begins(campaign: Campaign, fit: Fit, model: Model) -> tuple[Begin, ...] | None:
    """Where the recordings to fit on start, under the law of the model those with an angle."""
    if fit.begins is None or model.stage.begins is None:
        return fit.begins
    of_law = iter(model.stage.begins)
    return tuple(
        b if r.angle is None else next(of_law) for r, b in zip(campaign.fit, fit.begins, strict=True)
    )


def _fitted(model: Model, origin: str) -> ParameterSet:
    values = {n: model.values[n] for n in model.names}
    return model.start.fitted(values, dict.fromkeys(values), origin)


def _start(campaign: Campaign, fit: Fit, law: str) -> ParameterSet:
    """Values and bounds to fit a law from: the guess, under the regulator that was fitted."""
    guess = guessed_set(campaign, law, fit.fitted.rig)
    known = {n: p for n, p in fit.fitted.parameters.items() if n in ("gain", "k_fast", "k_slow", "e0")}
    if campaign.start == "rest":
        known["rest_pressure"] = fit.fitted.parameters["rest_pressure"]
    return replace(guess, parameters={**guess.parameters, **known})


def _model(campaign: Campaign, fit: Fit, start: ParameterSet) -> Model:
    """The law alone, driven by what was measured of the pressure."""
    used = [i for i, r in enumerate(campaign.fit) if r.angle is not None]
    driven = all(campaign.fit[i].pressure is not None for i in used)
    played = tuple(Playback(campaign.fit[i], start.rig.sample_time) for i in used)
    begins = None if fit.begins is None else tuple(fit.begins[i] for i in used)
    stage = Stage(
        "wrist" if driven else "whole", "angle_deg", fit.noise["angle_deg"] or 1.0, played,
        loop_names(start.parameters, campaign.start == "rest"), start.rig,
        tuple(map(_measured, played)) if driven else None, begins,
    )  # fmt: skip
    return Model(stage, start, start.values)


def _measured(playback: Playback) -> Array:
    """The measured pressure [kPa] at every sample of the model."""
    smooth = smooth_pressure(playback.recording)
    return np.interp(np.arange(playback.rows[-1] + 1), playback.rows, smooth)


def _best(model: Model, seed: int) -> Model:
    """The best of fits from some starts around the guess: all begun, the best ended."""
    start, low, high = model.bounds
    rng = np.random.default_rng(seed)
    near = [
        np.clip(start * np.exp(0.7 * rng.standard_normal(start.size)), low, high) for _ in range(STARTS - 1)
    ]
    begun = [model.at(x).fitted(BEGUN, 1e-3) for x in (start, *near)]
    begun.sort(key=lambda m: m.chi2)
    return min((m.fitted() for m in begun[:ENDED]), key=lambda m: m.chi2)


def _ends(model: Model, fit: Fit) -> tuple[float, ...]:
    """Pressures [kPa] at the ends of the command's range."""
    return tuple(sorted(v * model.values["gain"] for v in fit.fitted.rig.command_range))
