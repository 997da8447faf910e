"""Figures of robustness: the plane of the gains, the envelope of the samples, the worst scenario."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from design.evaluation.metrics import SETTLING_BAND
from design.evaluation.runner import PlayedTask
from design.robustness.gain_plane import GainPlane
from design.robustness.samples.monte_carlo import Envelopes
from design.robustness.samples.worst import Worst
from design.synthesis.requirements import Limits
from reports.shared.figures.style import (
    BLACK,
    BLUE,
    DASH_DOT,
    DASHED,
    DOTTED,
    GREEN,
    GREY,
    LONG,
    ORANGE,
    PALE,
    SKY,
    VERMILLION,
    new_figure,
    seen,
    styled,
)  # fmt: skip

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CERTIFIED: tuple[dict[str, Any], ...] = (
    {"facecolor": "#bfe3d6", "hatch": "", "edgecolor": GREEN},
    {"facecolor": "#dceef8", "hatch": "", "edgecolor": SKY},
)
"""Fill of the region of each rung, the one that is proved for the widest class first."""

MARKERS = ("*", "D", "s", "^", "v", "o")


def draw_gain_plane(plane: GainPlane, limits: Limits, marks: Mapping[str, tuple[float, float]]) -> "Figure":
    """Regions of the gains: unstable on some branch (grey), certified by each rung (filled), the limits
    on Ms, overshoot and delay margin as lines, the gains that were chosen as marks."""
    from matplotlib.patches import Patch

    with styled():
        figure, (axes,) = new_figure(height=5.4)
        axes.set(xscale="log", yscale="log", xlabel="Kp [kPa/deg]", ylabel="Ki [kPa/(deg s)]")
        axes.grid(False)
        handles: list[Any] = []
        unstable = (~plane.stable).T.astype(float)
        if unstable.any():
            axes.contourf(plane.Kp, plane.Ki, unstable, levels=[0.5, 1.5], colors=[PALE], hatches=["xxx"])
            words = "linear loop unstable on some branch"
            handles.append(Patch(facecolor=PALE, edgecolor=GREY, hatch="xxx", linewidth=0.0, label=words))
        # The rung for the narrower class reaches further: it is drawn first, beneath.
        for (rung, found), look in reversed(list(zip(plane.certified.items(), CERTIFIED, strict=False))):
            if found.any():
                _filled(axes, plane, found, look)
            handles.append(Patch(label=f"certified: {rung}" + ("" if found.any() else " (nowhere)"), **look))
        handles += _limit_lines(axes, plane, limits)
        for (words, (Kp, Ki)), marker in zip(marks.items(), MARKERS, strict=False):
            (shown,) = axes.plot(
                Kp, Ki, linestyle="none", marker=marker, ms=15 if marker == "*" else 7.5, zorder=6,
                markerfacecolor=ORANGE if marker == "*" else "white", markeredgecolor=BLACK, label=words,
            )  # fmt: skip
            handles.append(shown)
        axes.set(xlim=(plane.Kp[0], plane.Kp[-1]), ylim=(plane.Ki[0], plane.Ki[-1]))
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(lambda v, _: f"{v:g}")
        figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure


def _filled(axes: "Axes", plane: GainPlane, found: Any, look: Mapping[str, Any]) -> None:
    values = found.T.astype(float)
    axes.contourf(plane.Kp, plane.Ki, values, levels=[0.5, 1.5], colors=[look["facecolor"]])
    axes.contour(plane.Kp, plane.Ki, values, levels=[0.5], colors=[look["edgecolor"]], linewidths=1.0)


def _limit_lines(axes: "Axes", plane: GainPlane, limits: Limits) -> list[Any]:
    """Lines where a limit is just held, and what stands for them in a legend."""
    from matplotlib.lines import Line2D

    looks: dict[str, tuple[str, dict[str, Any]]] = {
        "Ms": ("Ms = {:g}", {"colors": BLUE, "linestyles": [(0, DASHED[1])]}),
        "overshoot_percent": (
            "overshoot {:g} %, simulated",
            {"colors": VERMILLION, "linestyles": [(0, LONG[1])]},
        ),
        "delay_margin_s": ("delay margin {:g} s", {"colors": BLACK, "linestyles": [(0, DOTTED[1])]}),
    }
    handles = []
    for name, (words, look) in looks.items():
        limit = limits.named.get(name)
        if limit is None:
            continue
        field = np.nan_to_num(plane.field(name), posinf=1e6).T
        if field.min() <= limit <= field.max():
            axes.contour(plane.Kp, plane.Ki, field, levels=[limit], linewidths=1.6, **look)
        handles.append(
            Line2D([], [], color=look["colors"], linestyle=look["linestyles"][0], label=words.format(limit))
        )
    return handles


def draw_envelopes(bands: Envelopes, reference: float, band: float = SETTLING_BAND) -> "Figure":
    """The middle of the samples over time and the band that holds 90 % of them, in the direction of the
    step; beneath, the same about the reference, with the settling band, a share of it."""
    with styled():
        figure, (whole, near) = new_figure(2, 1, height=4.8, sharex=True, height_ratios=(3, 2))
        every = seen(len(bands.time), 400)
        for axes in (whole, near):
            axes.fill_between(
                bands.time[every], bands.low[every], bands.high[every], color="#cfe3f2", label="5 % to 95 %"
            )
            axes.plot(bands.time, bands.low, color=BLUE, linewidth=0.7)
            axes.plot(bands.time, bands.high, color=BLUE, linewidth=0.7)
            axes.plot(bands.time, bands.middle, color=BLUE, label="median")
            axes.axhline(reference, color=BLACK, linewidth=0.9, linestyle=DASHED, label="reference")
        whole.set(ylabel="Angle [deg]", title=f"{bands.cases} of the cases")
        whole.legend(loc="lower right")
        room = 4.0 * band * reference
        for side in (-1.0, 1.0):
            near.axhline(reference * (1.0 + side * band), color=GREY, linewidth=0.9, linestyle=DOTTED)
        near.text(
            0.995, reference * (1.0 + band), f"±{100 * band:g} %", ha="right", va="bottom",
            transform=near.get_yaxis_transform(), fontsize=8.5, color=GREY,
        )  # fmt: skip
        near.set(
            ylabel="Angle [deg]", xlabel="Time [s]", ylim=(reference - room, reference + room),
            xlim=(0.0, bands.time[-1]),
        )  # fmt: skip
    return figure


def draw_worst(worst: Worst, played: PlayedTask) -> "Figure":
    """The worst scenario that was found, as it was played: reference and angle, and the command."""
    t = played.trajectory
    assert t is not None
    with styled():
        figure, (angle, command) = new_figure(2, 1, height=4.6, sharex=True, height_ratios=(3, 2))
        angle.step(
            t.time, played.reference[:, 0], where="post", color=BLACK, linestyle=DASHED, linewidth=1.0,
            label="reference",
        )  # fmt: skip
        angle.plot(t.time, t.angle[:, 0], color=BLUE, label="angle")
        angle.plot(
            t.time, t.static_angle[:, 0], color=VERMILLION, linestyle=DASH_DOT, linewidth=1.0,
            label="static angle of the loop",
        )  # fmt: skip
        begins = sum(worst.case.task.holds[:-1])
        for axes in (angle, command):
            axes.axvspan(begins, t.time[-1], color="#f3f3f3", zorder=0)
        angle.text(
            begins, 1.01, "judged from here", transform=angle.get_xaxis_transform(), va="bottom",
            fontsize=8.5, color=GREY,
        )  # fmt: skip
        angle.legend(loc="best")
        angle.set_ylabel("Angle [deg]")
        command.plot(t.time, t.command[:, 0], color=BLUE)
        for bound in worst.case.wrist.rig.command_range:
            words = "range of the command" if bound == worst.case.wrist.rig.command_range[0] else ""
            command.axhline(bound, color=GREY, linewidth=0.8, linestyle=DASHED, label=words)
        command.legend(loc="best")
        command.set(xlabel="Time [s]", ylabel="Command [V]", xlim=(0.0, t.time[-1]))
    return figure
