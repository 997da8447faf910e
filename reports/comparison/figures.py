"""Figures of a comparison: steps, worst values, the loop under the tuned controller."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from design.comparison.compare import PAPER, TUNED, Comparison
from design.comparison.rows import WITHOUT_DEAD_TIME
from plants.hysteresis import HysteresisLaw
from plants.wrist import Wrist
from reports.shared.figures.direct_labels import label_curves
from reports.shared.figures.point_labels import label_points
from reports.shared.figures.style import (
    BLACK,
    BLUE,
    DASHED,
    FAINT,
    GREY,
    PALE,
    VERMILLION,
    controller_line,
    new_figure,
    styled,
)  # fmt: skip
from reports.shared.names import WINDOW, name_of, title_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SOON = 2.5
"""How long a step is drawn large [s]: the tuned one is over then, the paper's is on its way."""

SOONER = 1.0
"""The same for the other designs, which are quicker."""

PIS = (TUNED, WITHOUT_DEAD_TIME, "robust PI", "convex-concave PI", "SIMC", "AMIGO", "Ziegler-Nichols", PAPER)
"""Controllers that are drawn together as PIs; all others are other designs."""


def step_responses(comparison: Comparison, motion: str) -> "Figure":
    """The step from rest: a column for PIs, one for the other designs, the recommended PI in both; angle,
    pressure and command of the first seconds, and in the last row the angle until the end.  In colour: the
    recommended PI, and in each column the one of the others that settles first within the limits; the rest is
    grey, with names at the curves."""
    columns = step_columns(comparison, motion)
    with styled():
        figure, axes = new_figure(4, len(columns), height=5.1, sharey="row", height_ratios=(5, 2.8, 2.8, 2.4))
        grid = np.array(axes).reshape(4, len(columns))
        chosen = {title: coloured(comparison, motion, names) for title, names in columns.items()}
        for column, (title, names) in zip(grid.T, columns.items(), strict=True):
            end = SOON if title == "PIs" else SOONER
            _responses(column, comparison, motion, names, end, chosen[title])
            column[0].set_title(title)
        labels = ("Angle [deg]", "Pressure\n[kPa]", "Command\n[V]", "Angle\n[deg]")
        for panel, label in zip(grid[:, 0], labels, strict=True):
            panel.set_ylabel(label, fontsize=8.5)
        handles: dict[str, Any] = {}
        for panel in (*grid[0], grid[2, 0]):
            lines, words = panel.get_legend_handles_labels()
            handles |= dict(zip(words, lines, strict=True))
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=2, handlelength=4.0)
        figure.suptitle(title_of(motion), x=0.01, ha="left", fontsize=10, fontweight="bold")
        for panel, (title, names) in zip(grid[0], columns.items(), strict=True):
            drawn = {n: comparison.steps[motion, n] for n in names}
            curves = {n: (t.time[::5], t.angle[::5, 0]) for n, t in drawn.items()}
            label_curves(panel, curves, {n: name_of(n) for n in names if n not in chosen[title]})
    return figure


def step_columns(comparison: Comparison, motion: str) -> dict[str, list[str]]:
    """The controllers of each column of a motion's steps, by its title: PIs, and the other designs beside the
    recommended PI."""
    named = [name for m, name in comparison.steps if m == motion]
    others = [n for n in named if n not in PIS]
    columns = {"PIs": [n for n in named if n in PIS]}
    return columns | ({"Other designs": [TUNED, *others]} if others else {})


def coloured(comparison: Comparison, motion: str, names: list[str]) -> list[str]:
    """The recommended PI, and of some others the one that settles first within the limits, if any does."""
    of = [s for s in comparison.standings if s.motion == motion and s.controller in names]
    others = [s for s in of if s.controller != TUNED and not s.breaks and np.isfinite(s.worst_settling_s)]
    return [TUNED, *(s.controller for s in sorted(others, key=lambda s: s.worst_settling_s)[:1])]


def _responses(
    column: Any, comparison: Comparison, motion: str, names: list[str], end: float, coloured: list[str]
) -> None:
    """The four panels of some controllers, the first three until `end` [s]."""
    angle, pressure, command, late = column
    for place, name in enumerate(names):
        t, look = comparison.steps[motion, name], {"color": FAINT, "linewidth": 1.0}
        if name in coloured:
            look = controller_line(name, place) | {"zorder": 4 - 0.1 * place, "label": name_of(name)}
        every: dict[str, Any] = {"zorder": 2, "gid": name_of(name), **look}
        soon = slice(0, int(np.searchsorted(t.time, end)) + 1, 5)
        for panel, values in ((angle, t.angle), (pressure, t.pressure), (command, t.command)):
            panel.plot(t.time[soon], values[soon, 0], **every)
        late.plot(t.time[::10], t.angle[::10, 0], **every)
    step, bounds = comparison.rig.task.step, comparison.rig.command_range
    for panel in (angle, late):
        panel.axhline(step, color=BLACK, linewidth=0.8, zorder=1)
    for panel in (angle, pressure, command):
        panel.set_xlim(0.0, end)
        panel.tick_params(labelbottom=panel is command)
    for bound in bounds:
        words = "range of the command" if bound == bounds[0] else ""
        command.axhline(bound, color=BLACK, linewidth=0.8, linestyle=DASHED, label=words)
    command.set_ylim(bounds[0] - 0.2, bounds[1] + 0.2)
    command.set_xlabel("Time [s]")
    near = 0.35 * step
    late.set(xlim=(0.0, WINDOW), ylim=(step - near, step + near), xlabel="Time, all of it [s]")


def loop_trajectories(comparison: Comparison, wrists: Mapping[str, Wrist]) -> "Figure":
    """The tuned step of each motion in the plane of pressure and angle, between lines 1 and 2."""
    motions = [m for m in wrists if (m, TUNED) in comparison.steps]
    with styled():
        figure, both = new_figure(1, len(motions), height=3.8)
        for axes, motion in zip(both, motions, strict=True):
            t, loop = comparison.steps[motion, TUNED], wrists[motion].hysteresis
            pressure, angle, static = t.pressure[:, 0], t.angle[:, 0], t.static_angle[:, 0]
            low, high = float(pressure.min()) - 28.0, float(pressure.max()) + 8.0
            p = np.array([low, high])
            axes.plot(p, loop.ascending(p), color=GREY, linestyle=DASHED, linewidth=1.0)
            axes.plot(p, loop.descending(p), color=GREY, linestyle=DASHED, linewidth=1.0)
            axes.axhline(comparison.rig.task.step, color=BLACK, linewidth=0.8)
            axes.plot(pressure, static, color=VERMILLION, linestyle=DASHED, label="static angle of the loop")
            axes.plot(pressure, angle, color=BLUE, linewidth=2.0, label="angle")
            axes.set(
                title=title_of(motion), xlabel="Pressure [kPa]", xlim=(low, high),
                ylim=(-3.5, max(float(angle.max()), float(static.max())) + 3.5),
            )  # fmt: skip
            _line_names(axes, loop, low, high)
        both[0].set_ylabel("Angle [deg]")
        figure.legend(*both[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        for axes, motion in zip(both, motions, strict=True):
            t = comparison.steps[motion, TUNED]
            _mark_times(axes, t.time, t.pressure[:, 0], t.angle[:, 0])
    return figure


def _mark_times(axes: "Axes", time: Any, pressure: Any, angle: Any) -> None:
    """Dots at some instants on the path, labelled with their times."""
    seen: list[tuple[float, float]] = []
    named: dict[str, tuple[float, float]] = {}
    for instant in (0.1, 0.2, 0.5, 1.0):
        i = int(np.searchsorted(time, instant))
        here = (float(pressure[i]) / 8.0, float(angle[i]) / 1.2)  # in sizes of a label
        if any(np.hypot(here[0] - x, here[1] - y) < 1.0 for x, y in seen):
            continue
        seen.append(here)
        axes.plot(pressure[i], angle[i], "o", color=BLUE, markerfacecolor="white", ms=4.5)
        named[f"{instant:g} s"] = (float(pressure[i]), float(angle[i]))
    label_points(axes, named)


def _line_names(axes: "Axes", loop: HysteresisLaw, low: float, high: float) -> None:
    bottom, top = axes.get_ylim()
    for name, y, pressure, dx, side in (
        ("line 1", bottom + 0.06 * (top - bottom), loop.ascending_pressure, 4, "left"),
        ("line 2", 0.62 * top, loop.descending_pressure, -4, "right"),
    ):
        x = float(pressure(y))
        if low < x < high:
            axes.annotate(
                name, (x, y), (dx, 0), textcoords="offset points", fontsize=8.5, color=GREY, ha=side,
                va="center",
            )  # fmt: skip


def worst_values(comparison: Comparison) -> "Figure":
    """Worst settling time and overshoot of each controller over the tasks of a motion, as dots; the
    bar is what the paper's PI takes over the range of its gains, the line the limit."""
    motions = list({s.motion: None for s in comparison.standings})
    columns = (
        ("settling_time_s", "Worst settling time [s]", None),
        ("overshoot_percent", "Worst overshoot [% of the step]", comparison.limits.overshoot_percent),
    )
    most = max(sum(s.motion == m for s in comparison.standings) for m in motions)
    with styled():
        figure, axes = new_figure(
            len(motions), 2, height=0.75 + (0.4 + 0.19 * most) * len(motions), sharey="row", sharex="col"
        )
        for row, motion in enumerate(motions):
            for column, (metric, label, limit) in enumerate(columns):
                panel = axes[2 * row + column]
                _dots(panel, comparison, motion, metric)
                if limit is not None:
                    words = f"limit {limit:g} %"
                    panel.axvline(limit, color=VERMILLION, linestyle=DASHED, linewidth=1.2, label=words)
                if row == len(motions) - 1:
                    panel.set_xlabel(label)
            axes[2 * row].set_title(title_of(motion))
        axes[0].set_xlim(0.0, WINDOW * 1.13)
        axes[1].set_xlim(left=-0.02 * axes[1].get_xlim()[1])  # whole dots at zero
        figure.legend(*axes[1].get_legend_handles_labels(), loc="outside lower right")
    return figure


def _dots(axes: "Axes", comparison: Comparison, motion: str, metric: str) -> None:
    names = [s.controller for s in comparison.standings if s.motion == motion]
    axes.grid(axis="y", visible=False)
    for position, name in enumerate(names):
        rows = [r for r in comparison.rows if (r.motion, r.controller) == (motion, name)]
        low, value, high = (max(getattr(r, k)[metric] for r in rows) for k in ("low", "metrics", "high"))
        look = controller_line(name, position)
        end = WINDOW * 1.06 if not np.isfinite(high) else high
        if high > low:
            bar: dict[str, Any] = {"color": PALE, "linewidth": 8, "solid_capstyle": "butt", "zorder": 1}
            axes.plot([low, end], [position, position], **bar)
        at, marker = (value, "o") if np.isfinite(value) else (WINDOW * 1.06, ">")
        axes.plot(at, position, marker, color=look["color"], ms=6, zorder=3)
        digits = 2 if metric.endswith("_s") else 1
        words = f"{value:.{digits}f}" if np.isfinite(value) else f"> {WINDOW:g}"
        column: dict[str, Any] = {"transform": axes.get_yaxis_transform(), "ha": "right", "va": "center"}
        axes.text(1.16, position, words, fontsize=8.5, **column)
        if not np.isfinite(high) and high > low:
            axes.plot(end, position, ">", color=GREY, ms=6, zorder=2)
    axes.set_yticks(range(len(names)), [name_of(n) for n in names])
    axes.set_ylim(len(names) - 0.4, -0.75)
