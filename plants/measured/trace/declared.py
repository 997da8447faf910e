"""The declared model of a stage, fitted as well as it can be before anything is said to be missing."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plants.measured.residual.series.denoised import denoised
from plants.measured.stage import begun
from plants.measured.trace.search.choose import Candidate
from plants.measured.trace.stages.model import Model
from plants.simulation.open_loop import open_loop
from plants.wrist import Wrist

Array = NDArray[np.float64]
NEARLY = 1.05
"""A regulator whose chi-square per row is above this is not simulated well enough to drive the wrist."""

PARTS = 4
"""Recordings, the longest, whose own best fits a fit to all is started from."""

LOWER = 0.9
"""A minimum is another one if its chi-square is lower than this share of the first's."""


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
        pressure = open_loop(
            wrist, playback.commands, begun(wrist, begin), begin=float(playback.recording.time[0])
        ).pressure
        simulated.append(pressure)
        if playback.recording.pressure is not None:
            left = playback.recording.pressure - pressure[playback.rows]
            there = denoised(left, regulator.model.stage.noise)
            pressure = pressure + np.interp(np.arange(len(pressure)), playback.rows, there)
        drives.append(pressure)
    free = tuple(simulated)
    driven = (
        replace(stage, drives=tuple(drives), free_drives=free) if put_back else replace(stage, drives=free)
    )
    return replace(declared, stage=driven)
