"""The stages of a campaign, and the declared model of each, fitted as well as it can be before anything is
said to be missing."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.begin import Begin, first_rows, measured
from plants.measured.campaigns.campaign import Campaign
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.fit import Fit
from plants.measured.fitting.stage import Stage, begun
from plants.measured.residual.series.denoised import denoised
from plants.measured.trace.law import LawChoice
from plants.measured.trace.revision.size import MATTERS, span
from plants.measured.trace.search.candidate import Candidate
from plants.measured.trace.stages.model import Model
from plants.parameters.quantities import ParameterSet, loop_names
from plants.simulation.open_loop import pressed
from plants.wrist import Wrist

Array = NDArray[np.float64]
NEARLY = 1.05
"""A regulator whose chi-square per row is above this is not simulated well enough to drive the wrist."""

PARTS = 4
"""Recordings, the longest, whose own best fits a fit to all is started from."""

LOWER = 0.9
"""A minimum is another one if its chi-square is lower than this share of the first's."""


FORM = 0.5 * MATTERS
"""Share of the range of the angle that the form of a law may leave which was chosen from the log.  No rig has
quite that form, and what is left of so little is followed by effects that it does not have.  Where no
pressure was logged, the form of the regulator may leave as much."""


def base_fit(fit: Fit, law: LawChoice | None) -> Fit:
    """The fit that is revised: that of the declared wrist, or one of another hysteresis law."""
    if law is None or law.name == fit.fitted.law.NAME:
        return fit
    return replace(fit, fitted=law.parameters, undetermined=(), begins=law.begins[law.name])


def stages_of(campaign: Campaign, fit: Fit, guessed: bool = False) -> list[Stage]:
    """What can be traced of a campaign one after the other; of the fit, noise and where recordings begin.
    guessed: whether the rig was, from the log, and its hysteresis law chosen."""

    def made(name: str, channel: str) -> Stage:
        used = [i for i, r in enumerate(campaign.fit) if measured(r, channel) is not None]
        begins = None if fit.begins is None else tuple(fit.begins[i] for i in used)
        if begins is not None:
            begins = tuple(begin_of(campaign.fit[i], b) for i, b in zip(used, begins, strict=True))
        floor = fit.noise[channel] or 1.0
        rig = fit.before.rig
        played = tuple(Playback(campaign.fit[i], rig.sample_time) for i in used)
        loop = loop_names(fit.fitted.parameters, campaign.start == "rest")
        stage = Stage(
            name, channel, floor, played, loop, rig, None, begins, guessed=guessed,  # type: ignore[arg-type]
        )  # fmt: skip
        left = guessed and channel == "angle_deg"
        return replace(stage, form=FORM * stage.parts * span(fit.runs, channel)) if left else stage

    pressure = any(r.pressure is not None for r in campaign.fit)
    stages = [made("regulator", "pressure_kPa")] if pressure else []
    if campaign.stage == "wrist":
        stages.append(made("wrist" if pressure else "whole", "angle_deg"))
    return stages


def begin_of(recording: Recording, found: Begin) -> Begin:
    """Where a recording starts, of the fit of the declared wrist: at the first rows of what was logged, as
    one that is held out does.  What the fit made of that makes up for what the declared wrist lacks."""
    pressure, angle = first_rows(recording)
    if recording.pressure is not None:
        found = replace(found, pressure=pressure)
    return found if recording.angle is None else replace(found, angle=angle)


def declared_model(
    stage: Stage, start: ParameterSet, base: Fit, values: Mapping[str, float], before: Candidate | None
) -> Model:
    """The model of a stage without effects, fitted; before: what was chosen for the regulator, which drives
    a wrist."""
    fixed = tuple(n for n in base.undetermined if n in stage.declared)
    declared = Model(stage, start, values, fixed=fixed)
    return refitted(declared) if before is None or stage.name != "wrist" else driven(declared, before)


def refitted(declared: Model) -> Model:
    """The declared model by least squares, where it leaves more than the noise.

    A loop whose branch is only just left, or just not, has minima beside the lowest, and what a wrong
    one leaves passes for an effect.  What fits all recordings fits each, so that the best fit of a
    recording by itself is a start from which the lowest is found.
    """
    if declared.chi2 <= NEARLY:
        return declared
    best = declared.fitted()
    if best.chi2 > NEARLY:
        for start in _parts(best):
            found = start.fitted()
            if found.chi2 < LOWER * best.chi2:
                best = found
    return best


def _parts(model: Model) -> Iterator[Model]:
    """The model fitted to single recordings."""
    edges = model.stage.edges
    if len(edges) < 3:
        return
    for i in np.argsort(-np.diff(edges), kind="stable")[:PARTS]:
        rows = np.zeros(edges[-1], bool)
        rows[edges[i] : edges[i + 1]] = True
        yield model.fitted(20, 1e-5, rows)


def driven(declared: Model, regulator: Candidate) -> Model:
    """The declared wrist, fitted under the pressure that drives it.

    That is the simulated pressure, and where it does not quite reach the noise, the same with what it
    leaves put back.  But a residual without structure may be slow noise of the sensor, which the wrist
    never saw: its loop would turn at every wave of it.  A pressure that was there moves the angle,
    so the drive is taken that explains the angle better.
    """
    if regulator.model.chi2 <= NEARLY:
        return refitted(_under(declared, regulator, False))
    put_back = refitted(_under(declared, regulator, True))
    if regulator.examined.structured:
        return put_back
    simulated = refitted(_under(declared, regulator, False))
    return simulated if simulated.chi2 < put_back.chi2 else put_back


def _under(declared: Model, regulator: Candidate, put_back: bool) -> Model:
    """The declared wrist driven by the regulator's pressure [kPa] of every ms, as it is simulated, or
    with what that leaves of the measured pressure put back, denoised."""
    stage = declared.stage
    wrist = Wrist.from_values(declared.values, regulator.model.forms, declared.stage.rig)
    simulated, drives = [], []
    for i, playback in enumerate(stage.playbacks):
        begin = None if stage.begins is None else stage.begins[i]
        first = float(playback.recording.time[0])
        pressure = pressed(wrist, playback.commands, begun(wrist, begin), begin=first)
        simulated.append(pressure)
        if playback.recording.pressure is not None:
            # Between renewed values there is nothing to denoise but straight lines.
            fresh = playback.recording.fresh("pressure_kPa")
            rows = playback.rows[fresh]
            left = playback.recording.pressure[fresh] - pressure[rows]
            there = denoised(left, regulator.model.stage.noise)
            pressure = pressure + np.interp(np.arange(len(pressure)), rows, there)
        drives.append(pressure)
    free = tuple(simulated)
    driven = (
        replace(stage, drives=tuple(drives), free_drives=free) if put_back else replace(stage, drives=free)
    )
    return replace(declared, stage=driven)
