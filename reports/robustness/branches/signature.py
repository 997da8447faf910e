"""The loop on every branch in one figure: Nyquist, |S|, step by branch and rate, steps by initial state."""

from typing import TYPE_CHECKING, Any

import numpy as np

from design.margins import winds_not
from design.studies.shown.branch_steps import BranchSteps
from design.synthesis.requirements import Limits
from plants.wrist import STARTS, Wrist
from reports.robustness.branches.figures import frequencies, overlaid
from reports.robustness.branches.linear_step import branch_step
from reports.shared.figures.style import (
    BLACK,
    DOTTED,
    GREY,
    PALE,
    VERMILLION,
    controller_line,
    new_figure,
    seen,
    styled,
)
from reports.shared.tables import spaced

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TIME = np.linspace(0.0, 3.0, 301)
"""Times [s] at which steps of the linear loop are drawn."""

COMPARED = ("these gains", "SIMC")
"""What stands in the small multiples, and in colour where all PIs are drawn."""


def signature(wrist: Wrist, found: BranchSteps, limits: Limits) -> "Figure":
    """Small multiples: Nyquist with the circle of the limit on Ms, |S|, and the step of the linear loop on
    every branch, then the simulated step, of the gains that are judged and of SIMC's."""
    names = [n for n in COMPARED if n in found.controllers]
    loops = {n: overlaid(wrist, found.controllers[n]) for n in names}
    branches, omega = list(loops[names[0]]), frequencies(wrist)
    columns = max(len(branches), len(STARTS))
    with styled():
        figure, axes = new_figure(4, columns, height=7.2, sharey="row")
        grid = np.array(axes).reshape(4, columns)
        for column in range(columns):
            for panel, shown in zip(grid[:, column], (branches, branches, branches, STARTS), strict=True):
                panel.set_visible(column < len(shown))
                panel.tick_params(labelsize=7)
        for column, branch in enumerate(branches):
            for name in names:
                L = loops[name][branch].at(omega)
                grid[0, column].plot(L.real, L.imag, **_look(name))
                grid[1, column].plot(omega, np.abs(1.0 / (1.0 + L)), **_look(name))
                if winds_not(L[None])[0]:
                    y = branch_step(loops[name][branch], found.controllers[name], omega, TIME)
                    grid[2, column].plot(TIME, y * wrist.rig.task.step, **_look(name))
            _nyquist(grid[0, column], limits.Ms)
            grid[0, column].set_title(branch.replace(", ", "\n"), fontsize=7.5)
            _sensitivity(grid[1, column], limits.Ms)
            _step_axes(grid[2, column], wrist.rig.task.step)
        for column, start in enumerate(STARTS):
            _steps(grid[3, column], found, names, column, wrist.rig.task.step)
            grid[3, column].set_title(f"from {spaced(start)}", fontsize=7.5)
        for panel, label in zip(
            grid[:, 0], ("Im L [1]", "|S| [1]", "Linear [deg]", "Angle [deg]"), strict=True
        ):
            panel.set_ylabel(label)
        figure.legend(*grid[1, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _look(name: str) -> dict[str, Any]:
    return controller_line("tuned" if name == COMPARED[0] else name) | {"label": name, "linewidth": 1.4}


def _nyquist(axes: "Axes", Ms: float | None) -> None:
    from matplotlib.patches import Circle

    if Ms is not None:
        axes.add_patch(Circle((-1.0, 0.0), 1.0 / Ms, facecolor=PALE, edgecolor=GREY, linewidth=0.7, zorder=1))
    axes.plot(-1.0, 0.0, "+", color=BLACK, ms=7, mew=1.3)
    axes.set(xlim=(-1.7, 0.3), ylim=(-1.5, 0.5), aspect="equal", xticks=(-1, 0), yticks=(-1, 0))
    axes.set_xlabel("Re L [1]", fontsize=7.5)


def _sensitivity(axes: "Axes", Ms: float | None) -> None:
    if Ms is not None:
        axes.axhline(Ms, color=VERMILLION, linestyle=DOTTED, linewidth=1.1, label=f"limit: Ms {Ms:g}")
    axes.set(xscale="log", xlim=(0.1, 200.0), ylim=(0.0, 3.2), xticks=(1.0, 100.0), yticks=(0, 1, 2, 3))
    axes.minorticks_off()
    axes.xaxis.set_major_formatter(lambda v, _: f"{v:g}")
    axes.set_xlabel("ω [rad/s]", fontsize=7.5)


def _steps(axes: "Axes", found: BranchSteps, names: list[str], lane: int, step: float) -> None:
    for name in names:
        t = found.steps[name].trajectory
        assert t is not None
        every = seen(len(t.time), 300)
        axes.plot(t.time[every], t.angle[every, lane], **_look(name))
    _step_axes(axes, step)


def _step_axes(axes: "Axes", step: float) -> None:
    axes.axhline(step, color=BLACK, linewidth=0.7)
    axes.set(xlim=(0.0, 3.0), ylim=(-2.0, 1.6 * step), xticks=(0, 1, 2, 3))
    axes.set_xlabel("Time [s]", fontsize=7.5)
