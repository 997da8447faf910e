"""Figure of a rig: a recording held out, measured and simulated, and what the model leaves."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.real_rigs.data import Rig
from plants.measured.campaigns.begin import measured
from plants.measured.fitting.fit import Fit
from plants.measured.residual.series.remainder import Remainder, remainder_of
from plants.measured.trace.result import StageTrace, Trace
from plants.measured.trace.stages.remainders import remainders
from reports.shared.figures.style import BLACK, BLUE, DASHED, GREY, PALE, VERMILLION, new_figure, styled
from reports.shared.tables import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
CHANNELS = (("angle_deg", "Angle", "deg"), ("pressure_kPa", "Pressure", "kPa"))
BINS = 16
"""Bins of equal numbers of rows for the band of the residual."""

VARIABLES = {
    "pressure_kPa": "Simulated pressure [kPa]",
    "pressure_rate_kPa_s": "Rate of the simulated pressure [kPa/s]",
    "angle_deg": "Simulated angle [deg]",
    "direction": "Direction of motion",
    "time_s": "Time since the start of the recording [s]",
    "since_reversal_s": "Time since the last reversal [s]",
    "work_kPa": "Travel of the simulated pressure [kPa]",
    "command_V": "Command [V]",
    "other_pressure_kPa": "Differential pressure of the neighbouring joint [kPa]",
    "pwm": "Duty of the pump [of 255]",
    "pwm_main": "Duty of the main pump [of 255]",
    "co_contraction": "Mean pressure of the two muscles [of full]",
}


def draw_rig(rig: Rig, fit: Fit, trace: Trace | None) -> "Figure":
    """What was measured on the widest recording held out beside free runs of the declared and the
    revised wrist, and the residual, on the recordings fitted, against what it depends on."""
    logged = [c for c in CHANNELS if measured(fit.campaign.validate[0], c[0]) is not None]
    with styled():
        figure, axes = new_figure(
            len(logged) + 1, height=2.1 * (len(logged) + 1) + 0.5, height_ratios=[1.0] * len(logged) + [1.15]
        )
        for i, (ax, (channel, name, unit)) in enumerate(zip(axes, logged, strict=False)):
            _signals(ax, fit, trace, channel, f"{name} [{unit}]")
            if i == 0:
                shown = _shown(fit, logged[0][0])
                ax.set_title(f"{fit.campaign.validate[shown].name}, held out")
                ax.legend(loc="upper left", bbox_to_anchor=(0.0, 1.0), ncols=3)
                low, high = ax.get_ylim()
                ax.set_ylim(low, high + 0.22 * (high - low))
        axes[len(logged) - 1].set_xlabel("Time [s]")
        _remainder(axes[-1], fit, trace)
        figure.suptitle(rig.title, x=0.01, ha="left", fontweight="bold", fontsize=11)
    return figure


def _shown(fit: Fit, channel: str) -> int:
    """The recording held out of the widest range."""
    spans = [float(np.ptp(v)) for r in fit.campaign.validate if (v := measured(r, channel)) is not None]
    return int(np.argmax(spans))


def _signals(ax: "Axes", fit: Fit, trace: Trace | None, channel: str, label: str) -> None:
    first = "angle_deg" if fit.campaign.stage == "wrist" else "pressure_kPa"
    i = _shown(fit, first)
    run = [r for r in fit.runs if r.role == "validate"][i]
    truth: Any = measured(run.recording, channel)
    time = run.recording.time - run.recording.time[0]
    declared: Any = run.pressure if channel == "pressure_kPa" else run.angle
    ax.plot(time, truth, color=BLACK, linewidth=1.0, label="measured")
    ax.plot(time, declared, color=VERMILLION, linestyle=DASHED, linewidth=1.4, label="declared, refitted")
    if trace is not None and trace.effects:
        played = [p for p in trace.runs if p.role == "validate"][i]
        revised: Any = played.pressure if channel == "pressure_kPa" else played.angle
        ax.plot(time, revised, color=BLUE, linestyle="-", linewidth=1.8, alpha=0.85, label="revised")
    ax.set(ylabel=label, xlim=(time[0], time[-1]))


def _remainder(ax: "Axes", fit: Fit, trace: Trace | None) -> None:
    """The residual of the last stage that is not explained, against what it depends on most."""
    stage = _stage(trace)
    left = _of_declared(fit) if stage is None else remainders(stage.model)
    variable = _variable(stage, left)
    at = np.concatenate([r.variables[variable] for r in left])
    value = np.concatenate([r.value for r in left])
    ax.plot(at, value, ".", color=PALE, markersize=2.5, zorder=1)
    edges = np.unique(np.quantile(at, np.linspace(0.0, 1.0, BINS + 1)))
    label = np.clip(np.searchsorted(edges, at, side="right") - 1, 0, max(len(edges) - 2, 0))
    rows = [value[label == k] for k in range(len(edges) - 1) if np.any(label == k)]
    middles = [float(np.median(at[label == k])) for k in range(len(edges) - 1) if np.any(label == k)]
    low, mid, high = (np.array([np.quantile(v, q) for v in rows]) for q in (0.1, 0.5, 0.9))
    ax.fill_between(middles, low, high, color=BLUE, alpha=0.22, linewidth=0, label="80 % of the rows")
    ax.plot(middles, mid, color=BLUE, label="median")
    ax.axhline(0.0, color=GREY, linewidth=0.7)
    unit = "kPa" if left[0].stage == "regulator" else "deg"
    what = "pressure" if unit == "kPa" else "angle"
    ax.set(xlabel=VARIABLES.get(variable, variable), ylabel=f"Error of the {what} [{unit}]")
    ax.set_title(f"Measured minus simulated, recordings fitted (noise {number(left[0].noise, 2)} {unit})")
    bottom, top = ax.get_ylim()
    ax.set_ylim(bottom, top + 0.22 * (top - bottom))
    ax.legend(loc="upper right", ncols=2)


def _stage(trace: Trace | None) -> StageTrace | None:
    if trace is None:
        return None
    return (trace.unexplained or list(trace.stages))[-1]


def _of_declared(fit: Fit) -> list[Remainder]:
    """The residual of the declared model in the last channel, where no trace was made."""
    wrist = fit.campaign.stage == "wrist"
    noise = fit.noise["angle_deg" if wrist else "pressure_kPa"] or 1.0
    return [
        remainder_of(r.recording, "wrist" if wrist else "regulator", r.pressure, r.angle, noise)
        for r in fit.runs
        if r.role == "fit"
    ]


def _variable(stage: StageTrace | None, left: Sequence[Remainder]) -> str:
    """The first variable that the residual was found to depend on; of one that only changes in size,
    the variable with which it does; else the pressure."""
    offered = [n for n in left[0].variables if all(n in r.variables for r in left)]
    if stage is None:
        return "pressure_kPa"
    named = ["time_s" if d == "time" else d for d in stage.after.depends_on]
    sized = [f.variable for f in stage.after.findings if f.test == "changing size"]
    shares = [f.variable for f in sorted(stage.after.findings, key=lambda f: -f.share)]
    return next((n for n in (*named, *sized, *shares) if n in offered), "pressure_kPa")
