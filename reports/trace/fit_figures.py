"""Figures of a trace: errors before and after, time series, the loop, and tuning again."""

from typing import TYPE_CHECKING, Any

import numpy as np

from design.synthesis.retune import Control
from plants.measured.campaigns.begin import measured
from plants.measured.fitting.free_run import FreeRun
from plants.measured.trace.result import Trace
from reports.shared.figures.fit import LOOP_SECONDS
from reports.shared.figures.style import (
    BLACK,
    BLUE,
    DASHED,
    GREY,
    PALE,
    POINTS,
    VERMILLION,
    WIDTH,
    new_figure,
    seen,
    styled,
)
from reports.shared.names import CHANNELS
from reports.shared.tables import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MEASURED: dict[str, Any] = {"color": BLACK, "linewidth": 0.9, "alpha": 0.7, "label": "measured"}
BEFORE: dict[str, Any] = {"color": VERMILLION, "linestyle": DASHED, "linewidth": 1.2, "label": "declared"}
AFTER: dict[str, Any] = {"color": BLUE, "linestyle": "-", "linewidth": 1.3, "label": "revised"}
BAND: dict[str, Any] = {"color": PALE, "alpha": 0.9, "linewidth": 0.0, "zorder": 0}
SPREAD = 1.96
"""Standard deviations of the noise that its bounds are drawn at: 95 % of it stays within."""


def draw_errors(trace: Trace) -> "Figure":
    """Errors before and after of each channel with their intervals, beside the noise floor."""
    channels = [c for c in CHANNELS if trace.before.get(c) is not None]
    with styled():
        figure, axes = new_figure(1, max(1, len(channels)), height=2.1)
        for panel, channel in zip(axes, channels, strict=False):
            _errors(panel, trace, channel)
    return figure


def _errors(axes: "Axes", trace: Trace, channel: str) -> None:
    words, unit = CHANNELS[channel]
    sides = (
        ("before", trace.before[channel], trace.before_interval.get(channel), VERMILLION, "s"),
        ("after", trace.after[channel], trace.after_interval.get(channel), BLUE, "o"),
    )
    noise = trace.noise.get(channel)
    ends = [x for _, value, interval, _, _ in sides for x in (value, *(interval or ())) if x is not None]
    top = max([*ends, 1.35 * (noise or 0.0)])
    lines = [] if noise is None else [noise]
    for y, (_, value, interval, colour, marker) in enumerate(sides):
        assert value is not None
        said, taken = number(value), [*lines, value]
        if interval is not None:  # often narrower than any mark: its ends stand in the label too
            low, high = interval
            reach = [[max(value - low, 0.0)], [max(high - value, 0.0)]]
            axes.errorbar(
                value, y, xerr=reach, ecolor=colour, elinewidth=1.4, capsize=7, capthick=1.4, fmt="none"
            )
            said, taken = f"{said} ({number(low)} to {number(high)})", [*taken, low, high]
        axes.plot(value, y, marker, color=colour, markersize=3.5)
        axes.text(_free(taken, top), y - 0.42, said, fontsize=8, va="center", color=colour)
    if noise is not None:
        axes.axvline(noise, color=GREY, linestyle=DASHED, linewidth=1.2, label="noise of the sensor")
        axes.text(_free(lines, top), 1.55, f"noise {number(noise)}", color=GREY, fontsize=8, va="center")
    axes.set_yticks(range(2), [s[0] for s in sides])
    axes.set(title=words, xlabel=f"Error, rms [{unit}]", xlim=(-0.04 * top, 1.1 * top), ylim=(1.85, -0.85))
    axes.grid(axis="y", visible=False)


def _free(taken: list[float], top: float) -> float:
    """Where a label begins that is to cross none of some places of an axis from 0 to `top`: in the widest
    gap.

    >>> round(_free([0.05, 0.47], 0.5), 3), _free([0.34], 0.45)
    (0.06, 0.0)
    """
    ends = sorted([0.0, *taken, 1.08 * top])
    gap = max(range(len(ends) - 1), key=lambda i: ends[i + 1] - ends[i])
    return ends[gap] + (0.02 * top if gap else 0.0)


def shown_run(trace: Trace, channel: str) -> FreeRun:
    """The recording to be drawn: of those held out, the one whose channel moves furthest."""
    runs = [r for r in trace.runs if measured(r.recording, channel) is not None]
    apart = [r for r in runs if r.role == "validate"] or runs
    return max(apart, key=lambda r: float(np.ptp(_truth(r, channel))))


def _truth(run: FreeRun, channel: str) -> Any:
    return measured(run.recording, channel)


def _sides(run: FreeRun, channel: str) -> tuple[Any, Any]:
    if channel == "pressure_kPa":
        return run.pressure_before, run.pressure
    return run.angle_before, run.angle


def draw_series(trace: Trace, channel: str) -> "Figure":
    """Measured, declared and revised over time on one recording (`shown_run`), and the errors of both
    with the bounds of the noise."""
    run = shown_run(trace, channel)
    words, unit = CHANNELS[channel]
    time, truth, (before, after) = run.recording.time, _truth(run, channel), _sides(run, channel)
    every = seen(len(time))
    noise = SPREAD * (trace.noise.get(channel) or 0.0)
    sides = [(before, BEFORE), (after, AFTER)][: 2 if trace.differs else 1]
    with styled():
        heights = (3.0, *(1.5 for _ in sides))
        figure, (signal, *residuals) = new_figure(
            len(heights), 1, height=0.9 * sum(heights), sharex=True, height_ratios=heights
        )
        took = "held out" if run.role == "validate" else "fitted to"
        signal.set(title=f"{run.recording.name} ({took})", ylabel=f"{words} [{unit}]")
        signal.plot(time[every], truth[every], **MEASURED)
        for simulated, look in sides:
            signal.plot(time[every], simulated[every], **look)
        # Below all panels: a recording that fills its panel leaves no room for it there.
        figure.legend(*signal.get_legend_handles_labels(), loc="outside lower center", ncols=3)
        for panel, (simulated, look) in zip(residuals, sides, strict=True):
            if panel is not residuals[0]:
                panel.sharey(residuals[0])  # one scale for before and after
            panel.axhspan(-noise, noise, **BAND)
            left = (truth - simulated)[every]
            panel.plot(time[every], left, **{**look, "linewidth": 0.8, "linestyle": "-"})
            panel.set_ylabel(f"Residual,\n{look['label']} [{unit}]")
        residuals[-1].set(xlabel="Time [s]", xlim=(time[0], time[-1]))
    return figure


def loop_run(trace: Trace) -> FreeRun | None:
    """The recording whose loop is drawn; None where angle or pressure was not logged."""
    both = [r for r in trace.runs if r.recording.angle is not None and r.recording.pressure is not None]
    if not both or trace.campaign.stage != "wrist":
        return None
    apart = [r for r in both if r.role == "validate"] or both
    return max(apart, key=lambda r: float(np.ptp(_truth(r, "angle_deg"))))


def draw_loop(trace: Trace) -> "Figure | None":
    """Angle over pressure for the first seconds of one recording, beside the declared and the revised
    wrist; None where angle or pressure was not logged."""
    run = loop_run(trace)
    if run is None:
        return None
    time, truth = run.recording.time, run.recording
    first = slice(0, int(np.searchsorted(time, time[0] + LOOP_SECONDS)), max(1, len(time) // (2 * POINTS)))
    sides = [(run.pressure_before, run.angle_before, BEFORE), (run.pressure, run.angle, AFTER)]
    with styled():
        figure, axes = new_figure(1, 2 if trace.differs else 1, height=3.5, sharex=True, sharey=True,
                                  width=WIDTH if trace.differs else 4.2)  # fmt: skip
        for panel, (pressure, angle, look) in zip(axes, sides, strict=False):
            assert angle is not None
            assert truth.pressure is not None
            assert truth.angle is not None
            beneath = {**MEASURED, "linewidth": 3.0, "alpha": 0.3}
            panel.plot(truth.pressure[first], truth.angle[first], **beneath)
            panel.plot(pressure[first], angle[first], **look)
            panel.set(title=f"Measured and {look['label']}", xlabel="Pressure [kPa]")
            panel.legend(loc="upper left")
        axes[0].set_ylabel("Angle [deg]")
    return figure


def draw_control(control: Control) -> "Figure | None":
    """The step under the PI of the declared and of the revised plant; None where neither could be tuned."""
    sides = [control.declared] if control.same else [control.declared, control.revised]
    shown = [(s, s.judged.response) for s in sides if s.judged is not None]
    if not shown:
        return None
    looks = {
        "declared": {**BEFORE, "linewidth": 1.6, "label": "tuned on the declared plant"},
        "revised": {**AFTER, "linewidth": 1.9, "label": "tuned on the revised plant"},
    }
    with styled():
        figure, (angle, command) = new_figure(2, 1, height=4.6, sharex=True, height_ratios=(3, 2))
        step, band = control.task.step, control.task.band
        angle.axhspan(step * (1.0 - band), step * (1.0 + band), **BAND)
        angle.axhline(step, color=BLACK, linewidth=0.7)
        for side, r in shown:
            every = seen(len(r.time))
            angle.plot(r.time[every], r.angle[every], **looks[side.plant])
            command.plot(r.time[every], r.command[every], **looks[side.plant])
        angle.set(ylabel="Angle [deg]", title=f"A step of {step:g} deg from rest")
        command.set(xlabel="Time [s]", ylabel="Command [V]", xlim=(0.0, float(shown[0][1].time[-1])))
        angle.legend(loc="lower right")
    return figure
