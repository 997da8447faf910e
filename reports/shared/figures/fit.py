"""A fit as a figure, on held-out recordings, and for machines."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from plants.measured.fitting.fit import Fit
from plants.measured.fitting.free_run import FreeRun
from plants.measured.instrument.remark import habits
from plants.measured.trace.law import LawChoice
from plants.measured.trace.rig_fit import RigFit
from plants.parameters.correlation import ParameterCorrelation
from plants.parameters.quantities import Fitted
from reports.shared.figures.style import (
    BLACK,
    BLUE,
    DASHED,
    DOTTED,
    GREY,
    POINTS,
    VERMILLION,
    WIDTH,
    seen,
    styled,
)
from reports.shared.tables import listed, number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOOP_SECONDS = 20.0
"""How much of a recording is drawn in the plane of pressure and angle [s]."""


def shown_run(fit: Fit) -> FreeRun:
    """The recording to be drawn: of those held out, the one of the widest
    range; of all, where every recording took part."""
    runs = [r for r in fit.runs if r.role == "validate"] or list(fit.runs)
    best: FreeRun = max(runs, key=lambda r: float(np.ptp(_channel(r)[0])))
    return best


def _channel(run: FreeRun) -> tuple[Any, Any, Any, str]:
    """Measured, simulated after and before, and the label, of the angle, or else of the pressure."""
    if run.angle is not None and run.recording.angle is not None:
        return run.recording.angle, run.angle, run.angle_before, "Angle [deg]"
    return run.recording.pressure, run.pressure, run.pressure_before, "Pressure [kPa]"


def draw_fit(fit: Fit) -> "Figure":
    """Measured and simulated over time with the starting and the fitted set, the errors of both,
    and the loop in the plane of pressure and angle, on one recording (`shown_run`)."""
    run = shown_run(fit)
    measured, after, before, label = _channel(run)
    time = run.recording.time
    every = seen(len(time))
    loop = measured is run.recording.angle and run.recording.pressure is not None
    with styled():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(WIDTH, 6.7 if loop else 4.2), layout="constrained")
        rows = figure.add_gridspec(3 if loop else 2, 2, height_ratios=(3, 1.6, 3.2)[: 3 if loop else 2])
        signal = figure.add_subplot(rows[0, :])
        error = figure.add_subplot(rows[1, :], sharex=signal)
        took = "held out" if run.role == "validate" else "fitted to"
        signal.set(title=f"{run.recording.name} ({took})", ylabel=label)
        signal.plot(time[every], measured[every], label="measured", **_MEASURED)
        signal.plot(time[every], before[every], label="before", **_BEFORE)
        signal.plot(time[every], after[every], label="fitted", **_AFTER)
        signal.legend(loc="best", ncols=3)
        error.plot(time[every], (before - measured)[every], **_BEFORE)
        error.plot(time[every], (after - measured)[every], **_AFTER)
        error.axhline(0.0, color=GREY, linewidth=0.7)
        error.set(xlabel="Time [s]", ylabel=f"Error {label[label.index('[') :]}", xlim=(time[0], time[-1]))
        if loop:
            left = figure.add_subplot(rows[2, 0])
            right = figure.add_subplot(rows[2, 1], sharex=left, sharey=left)
            _loop(left, run, run.pressure_before, run.angle_before, _BEFORE, "before")
            _loop(right, run, run.pressure, run.angle, _AFTER, "fitted")
            left.set_ylabel(label)
    return figure


_MEASURED: dict[str, Any] = {"color": BLACK, "linewidth": 0.9, "linestyle": "-", "alpha": 0.75}
_BEFORE: dict[str, Any] = {"color": VERMILLION, "linestyle": DASHED, "linewidth": 1.2}
_AFTER: dict[str, Any] = {"color": BLUE, "linestyle": (0, DOTTED[1]), "linewidth": 2.0}


def _loop(axes: "Axes", run: FreeRun, pressure: Any, angle: Any, look: dict[str, Any], words: str) -> None:
    """Angle against pressure for the first seconds only: more loops than a few hide each other."""
    time, measured = run.recording.time, run.recording
    assert measured.pressure is not None
    assert measured.angle is not None
    first = slice(0, int(np.searchsorted(time, time[0] + LOOP_SECONDS)), max(1, len(time) // (2 * POINTS)))
    axes.plot(measured.pressure[first], measured.angle[first], label="measured", **_MEASURED)
    axes.plot(pressure[first], angle[first], label=words, **look)
    part = f", first {LOOP_SECONDS:g} s" if time[-1] - time[0] > LOOP_SECONDS else ""
    axes.set(title=f"Loop, {words}{part}", xlabel="Pressure [kPa]")
    axes.legend(loc="upper left")


def fit_record(fit: Fit) -> dict[str, Any]:
    """A fit: its data, the parameters that were fitted, its errors by channel, how the search went."""
    return {
        "campaign": fit.campaign.name,
        "sha256": fit.campaign.checksum,
        "axis": fit.campaign.axis,
        "parameters": {
            n: {"value": p.value, "unit": p.unit, "std_error": p.provenance.std_error}
            for n, p in fit.fitted.parameters.items()
            if isinstance(p.provenance, Fitted)
        },
        "correlation": correlation_record(fit.correlations),
        "before": {n: p.value for n, p in fit.before.parameters.items()},
        "noise_floor": fit.noise,
        "validate_rmse": fit.validate_rmse,
        "validate_rmse_before": fit.validate_rmse_before,
        "fit_rmse": fit.fit_rmse,
        "at_bounds": list(fit.at_bounds),
        "undetermined": list(fit.undetermined),
        "remarks": fit.remarks,
        "stages": {n: {"costs": list(e.costs), "agreeing": e.agreeing} for n, e in fit.stages.items()},
    }


def correlation_record(found: Sequence[ParameterCorrelation]) -> list[dict[str, Any]]:
    """Correlations of the errors of parameters, for JSON: an entry for those estimated together."""
    return [{"parameters": list(c.names), "matrix": c.matrix.round(4).tolist()} for c in found]


def start_record(found: RigFit) -> dict[str, Any]:
    """How a fit began, for JSON: whether from a guess, how the law was chosen, what the logger does."""
    held_out = {} if found.law is None else dict(found.law.held_out)
    return {
        "guessed": found.start.guessed,
        "law": {"name": found.fit.fitted.law.NAME, "held_out_rmse_deg": held_out},
        "instrument": habits(found.start.instrument),
    }


def law_sentence(law: LawChoice) -> str:
    """How a hysteresis law was chosen."""
    errors = sorted((law.with_effects or law.held_out).items(), key=lambda e: e[1])
    told = listed([f"{number(e)} deg with {n}" for n, e in errors])
    on = (
        "simulated from the command with the effects that each law needs"
        if law.with_effects
        else "with the measured pressure"
        if law.driven
        else "simulated from the command"
    )
    said = f"Hysteresis law: {law.name}, chosen on held-out blocks, where the angle error {on} is {told}."
    if errors[0][0] == law.name:
        return said
    if law.with_effects:
        return (
            f"{said} Another law replaces it only if its error is smaller for certain and by enough, and not "
            "larger on recordings that are left out whole."
        )
    if errors[0][0] in law.others:
        return f"{said} Another law replaces the declared one only if its error is 10 % smaller."
    return f"{said} The best fit of {errors[0][0]} makes no such loop; check that no columns are swapped."
