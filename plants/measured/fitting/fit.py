"""Fitting the declared wrist to a campaign: regulator on the pressure, then the wrist on the angle.

Where no pressure was logged both stages are fitted together on the angle.
Residuals are free-run simulations from the command, so that the error counted
is the one that a user of the model will see.
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from plants.errors import InputError, InputWarning
from plants.hysteresis import with_values
from plants.measured.campaigns.begin import Begin, at_rest, first_begin, like_fitted, measured
from plants.measured.campaigns.campaign import Campaign
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.determined import estimate_determined
from plants.measured.fitting.estimate import Estimate
from plants.measured.fitting.free_run import FreeRun, rmse
from plants.measured.fitting.problem import FitProblem
from plants.measured.fitting.stage import Stage
from plants.measured.residual.stillness import noise_of_campaign
from plants.parameters.correlation import ParameterCorrelation, all_pairs
from plants.parameters.quantities import REGULATOR_NAMES, ParameterSet, loop_names
from plants.wrist import Wrist

Array = NDArray[np.float64]
Errors = dict[str, float | None]
Role = Literal["fit", "validate"]
CHANNELS = ("pressure_kPa", "angle_deg")
EXPLAINED = 1.2
"""A model whose error is below this many times the noise explains a channel (chi-square 1.5 a row)."""


@dataclass(frozen=True)
class Fit:
    """A wrist fitted to a campaign.

    before, fitted: the starting and the fitted parameter set.  noise: floor of
    each channel, from the data.  fit_rmse, validate_rmse, validate_rmse_before:
    errors of free runs by channel, None where a channel was not logged.
    stages: how each estimate went.  at_bounds: parameters that ran into a bound.
    undetermined: parameters that the recordings say nothing about; they keep
    their starting value and its provenance.  begins: where the recordings to
    fit on start, None where at rest.  correlations: of the errors of parameters
    that were estimated together and have a standard error.
    """

    campaign: Campaign
    before: ParameterSet
    fitted: ParameterSet
    noise: Errors
    fit_rmse: Errors
    validate_rmse: Errors
    validate_rmse_before: Errors
    runs: tuple[FreeRun, ...]
    stages: dict[str, Estimate]
    at_bounds: tuple[str, ...] = ()
    undetermined: tuple[str, ...] = ()
    begins: tuple[Begin, ...] | None = None
    no_loop: str | None = None
    correlations: tuple[ParameterCorrelation, ...] = ()

    @property
    def ratios(self) -> dict[str, float]:
        """Error on the held-out recordings over the noise, by channel."""
        pairs = {c: (self.validate_rmse[c], self.noise[c]) for c in CHANNELS}
        return {c: error / noise for c, (error, noise) in pairs.items() if error is not None and noise}

    @property
    def remarks(self) -> list[str]:
        """What there is to say of the fit, in sentences; none where it explains the recordings."""
        said = []
        if self.no_loop:
            said.append(
                f"The law {self.fitted.law.NAME} does not describe this loop; the best fit: {self.no_loop}."
            )
        if self.undetermined:
            said.append(
                "Not determined by these recordings, kept at their starting values: "
                f"{', '.join(self.undetermined)}."
            )
        if self.at_bounds:
            said.append(f"At a bound, so without a standard error: {', '.join(self.at_bounds)}.")
        high = {c: r for c, r in self.ratios.items() if r > EXPLAINED}
        if high:
            errs = " and ".join(f"the {c.split('_')[0]} by {r:.2g}" for c, r in high.items())
            also = all((self.fit_rmse[c] or 0.0) > EXPLAINED * (self.noise[c] or 0.0) for c in high)
            cause = "the model lacks something that this rig has"
            if said or not also:
                cause = "the recordings do not settle whether an effect is missing or parameters are off"
            said.append(f"Errors exceed the noise, {errs} times: {cause}.")
        return said


def fit_campaign(
    campaign: Campaign,
    start: ParameterSet,
    starts: int = 6,
    seed: int = 0,
    progress: Callable[[str, float], None] | None = None,
    apart: bool = True,
) -> Fit:
    """Fit the declared wrist to the fit recordings of a campaign.

    `start` gives the starting values, bounds and what is not fitted; `starts` is
    the number of starting points of each stage, the first being `start`, the
    others drawn around it with `seed`.  Where the best parameters make no loop, `Fit.no_loop`
    says why; with `apart` they are fitted once more, within bounds where they make one.  Raises InputError
    where the recordings hold no motion to fit on.  Warns, with InputWarning, where they do not start
    at rest though the campaign says so.
    """
    tell = progress or (lambda stage, share: None)
    noise = _noise(campaign)
    _check_motion(campaign)
    begins = _begins(campaign.fit, campaign, start)
    with_pressure = tuple(r.pressure is not None for r in campaign.fit)
    plan: list[tuple[str, tuple[str, ...], str]] = []
    if any(with_pressure):
        plan.append(("regulator", REGULATOR_NAMES, "pressure_kPa"))
    if campaign.stage == "wrist":
        of_loop = loop_names(start.parameters, campaign.start == "rest")
        plan.append(("wrist", of_loop if any(with_pressure) else (*REGULATOR_NAMES, *of_loop), "angle_deg"))

    values: dict[str, float] = dict(start.values)
    errors: Errors = {}
    stages: dict[str, Estimate] = {}
    undetermined: list[str] = []
    together: list[ParameterCorrelation] = []
    for number, (stage, names, channel) in enumerate(plan):
        tell(stage, number / len(plan))
        used = [i for i, r in enumerate(campaign.fit) if measured(r, channel) is not None]
        asked = Stage(
            "regulator" if stage == "regulator" else "whole", channel, noise[channel] or 1.0,
            tuple(Playback(campaign.fit[i], start.rig.sample_time) for i in used), names, start.rig,
            begins=None if begins is None else tuple(begins[i] for i in used),
        )  # fmt: skip
        free = () if begins is None else _free(channel, any(with_pressure))
        problem = FitProblem(asked, (), names, values, free=free)
        problem, found, blind = estimate_determined(problem, start, starts, seed)
        stages[stage] = found
        undetermined += blind
        values |= {n: float(found.x[i]) for i, n in enumerate(problem.names)}
        errors |= {n: found.std_errors[i] for i, n in enumerate(problem.names)}
        size = len(problem.names)
        together.append(ParameterCorrelation(problem.names, found.correlation[:size, :size]))
        if begins is not None:
            for i, begin in zip(used, problem.begins_at(found.x) or (), strict=True):
                begins[i] = begin
    tell("done", 1.0)
    loop, ends = with_values(values), tuple(v * values["gain"] for v in start.rig.command_range)
    trouble = loop.problem(*ends) if campaign.stage == "wrist" else None
    if trouble:
        _check_sign(campaign)
    if trouble and apart:
        kept = loop.kept_apart(*ends)
        if kept:
            again = start.within(kept, values)
            inside = fit_campaign(campaign, again, starts, seed, progress, apart=False)
            return replace(inside, before=start, no_loop=trouble)
    bounds = {n: (p.low, p.high) for n, p in start.parameters.items()}
    edges = tuple(n for n in errors if min(abs(values[n] - b) for b in bounds[n]) < 1e-3 * np.ptp(bounds[n]))
    errors |= dict.fromkeys(edges)
    origin = f"{campaign.name} (sha256 {campaign.checksum[:12]})"
    correlations = tuple(c.of(n for n in errors if errors[n] is not None) for c in together)
    fitted = replace(start, axis=campaign.axis).fitted({n: values[n] for n in errors}, errors, origin)
    fitted = replace(fitted, correlation=all_pairs(correlations))
    runs = tuple(_runs(campaign, start, fitted, begins))
    if campaign.stage == "wrist" and _no_better_than_a_constant(runs):
        _check_sign(campaign)
    return Fit(
        campaign, start, fitted, noise,
        _errors(runs, "fit"), _errors(runs, "validate"), _errors(runs, "validate", before=True), runs, stages,
        edges, tuple(undetermined), None if begins is None else tuple(begins), trouble,
        correlations,
    )  # fmt: skip


def on_held_out(fit: Fit, campaign: Campaign) -> Fit:
    """The fit with its errors on other held-out recordings [deg, kPa]: those of a campaign whose recordings
    to fit on are the same."""
    runs = tuple(_runs(campaign, fit.before, fit.fitted, fit.begins))
    return replace(
        fit, campaign=campaign, runs=runs, validate_rmse=_errors(runs, "validate"),
        validate_rmse_before=_errors(runs, "validate", before=True),
    )  # fmt: skip


def _noise(campaign: Campaign) -> Errors:
    """Noise floor of each channel over all recordings, None where it was not logged."""
    return {c: noise_of_campaign(campaign.recordings, c) for c in CHANNELS}


def _check_motion(campaign: Campaign) -> None:
    # A wrist that does not start at rest moves without a command that does.
    if campaign.start == "rest" and all(np.ptp(r.command) == 0.0 for r in campaign.fit):
        raise InputError(
            f"{campaign.name}: the command never moves in the recordings to fit on; add one that moves"
        )
    for channel in CHANNELS:
        logged = [v for r in campaign.fit if (v := measured(r, channel)) is not None]
        if logged and all(np.ptp(v) == 0.0 for v in logged):
            raise InputError(
                f"{campaign.name}: {channel} never changes in the recordings to fit on; "
                "check the sensor, or leave the column out"
            )


def _check_sign(campaign: Campaign) -> None:
    """Refuse an angle that falls as the pressure rises: no loop of this kind does."""
    runs = [(r.command if r.pressure is None else r.pressure, r.angle) for r in campaign.fit]
    signs = [
        np.corrcoef(x, y)[0, 1] for x, y in runs if y is not None and np.ptp(x) > 0.0 and np.ptp(y) > 0.0
    ]
    if signs and max(signs) < 0.0:
        raise InputError(
            f"{campaign.name}: the angle falls as the pressure rises; map angle_deg with scale = -1, or the "
            "command and pressure of the muscle that raises it"
        )


def _no_better_than_a_constant(runs: Sequence[FreeRun]) -> bool:
    """Whether a fit misses the angle by more than its own spread over the recordings fitted."""
    error = rmse(runs, "angle_deg", role="fit")
    angles = [a for r in runs if r.role == "fit" and (a := measured(r.recording, "angle_deg")) is not None]
    return error is not None and error > float(np.std(np.concatenate(angles)))


def _begins(recordings: Sequence[Recording], campaign: Campaign, start: ParameterSet) -> list[Begin] | None:
    """First guess of where recordings start; None where they start at rest."""
    rest = start.values["rest_pressure"]
    if campaign.start == "unknown":
        return [first_begin(r, rest, start.rig) for r in recordings]
    for r in recordings:
        if not at_rest(r, rest, start.rig):
            begin = first_begin(r, rest, start.rig)
            warnings.warn(
                f"{campaign.name}/{r.name}: starts at {begin.pressure:.4g} kPa and {begin.angle:.3g} deg, "
                f"not at rest at {rest:.4g} kPa and {start.rig.zero.rest:g} deg; "
                'set start = "unknown", or map the column with an offset',
                InputWarning,
                stacklevel=3,
            )
    return None


def _free(channel: str, pressure_known: bool) -> tuple[str, ...]:
    """What a stage estimates of the start of a recording."""
    if channel == "pressure_kPa":
        return ("pressure",)
    return ("angle",) if pressure_known else ("pressure", "angle")


def _runs(
    campaign: Campaign, start: ParameterSet, fitted: ParameterSet, begins: Sequence[Begin] | None
) -> list[FreeRun]:
    """Every recording beside its simulations; where the start is unknown, from the estimated
    start for recordings that were fitted, from the first rows for those held out."""
    apart = (
        None
        if begins is None
        else [like_fitted(r, start.values["rest_pressure"], start.rig, begins) for r in campaign.validate]
    )
    roles: tuple[tuple[Role, tuple[Recording, ...], Sequence[Begin] | None], ...] = (
        ("fit", campaign.fit, begins),
        ("validate", campaign.validate, apart),
    )
    found = []
    for role, recordings, starts in roles:
        for i, recording in enumerate(recordings):
            wrists = [Wrist.from_values(p.values, rig=p.rig) for p in (fitted, start)]
            states = [None if starts is None else starts[i].state(w.hysteresis) for w in wrists]
            sides = [
                Playback(recording, start.rig.sample_time).play(w, s)
                for w, s in zip(wrists, states, strict=True)
            ]
            angles = [None, None] if campaign.stage == "regulator" else [angle for _, angle in sides]
            found.append(FreeRun(recording, role, sides[0][0], angles[0], sides[1][0], angles[1]))
    return found


def _errors(runs: Sequence[FreeRun], role: str, before: bool = False) -> Errors:
    return {c: rmse(runs, c, before, role) for c in CHANNELS}
