"""The break-even map: settling time and IAE of feedforwards, as ratios to a plain PI's, over each error."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from design.comparison.break_even import METRICS, BreakEven, BreakEvenCurve
from reports.shared.figures.style import BLACK, GREY, controller_line, new_figure, styled
from reports.shared.names import name_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOWEST, HIGHEST = 0.12, 6.0
"""Ratios that are drawn; what lies beyond, or does not settle, is an arrow at the edge."""

ARROWS = 8
"""About how many arrows stand for a stretch of a curve beyond the axis."""

AXIS_WORDS = {
    "loop width": "wider than\nmodelled [%]",
    "slope": "steeper than\nmodelled [%]",
    "starting memory": "error, share of\nthe loop height [%]",
    "dead time": "not modelled\n[ms]",
}
TITLES = {"starting memory": "Initial angle"}
"""Titles of columns that differ from the kind of error."""
METRIC_WORDS = {
    "settling": "Worst settling time,\nratio to the PI alone [1]",
    "IAE": "Mean IAE,\nratio to the PI alone [1]",
}


def break_even_figure(found: BreakEven, title: str = "") -> "Figure":
    """One column for each kind of error, settling above and IAE below; shaded where a feedforward does worse
    than the plain PI, a mark where its curve gets there."""
    kinds = list(dict.fromkeys(c.kind for c in found.curves))
    names = list(dict.fromkeys(c.controller for c in found.curves))
    with styled():
        figure, axes = new_figure(2, len(kinds), height=4.6, sharex="col", sharey=True)
        for row, metric in enumerate(METRICS):
            for column, kind in enumerate(kinds):
                here = [found.of(kind, name) for name in names]
                _panel(axes[row * len(kinds) + column], here, metric)
        for column, kind in enumerate(kinds):
            axes[len(kinds) + column].set_xlabel(AXIS_WORDS[kind])
            axes[column].set_title(TITLES.get(kind, kind.capitalize()), fontsize=8.8)
        for row, metric in enumerate(METRICS):
            axes[row * len(kinds)].set_ylabel(METRIC_WORDS[metric])
        handles = axes[0].get_legend_handles_labels()[0]
        figure.legend(handles=handles, loc="outside lower center", ncols=len(names))
        if title:
            figure.suptitle(title, x=0.01, ha="left", fontsize=10, fontweight="bold")
    return figure


def _panel(axes: "Axes", curves: Sequence[BreakEvenCurve], metric: str) -> None:
    """Ratios of some controllers over one kind of error."""
    axes.set(yscale="log", ylim=(LOWEST, HIGHEST))
    axes.set_yticks([0.2, 0.5, 1.0, 2.0, 5.0], labels=["0.2", "0.5", "1", "2", "5"])
    axes.minorticks_off()
    axes.axhspan(1.0, HIGHEST, color="#f3ece4", zorder=0)
    axes.axhline(1.0, color=BLACK, linewidth=0.9)
    for place, curve in enumerate(curves):
        line, scale = controller_line(curve.controller, place), 1000.0 if curve.kind == "dead time" else 100.0
        ratio = curve.ratio(metric)
        shown = np.where((ratio > HIGHEST) | (ratio < LOWEST), np.nan, ratio)
        axes.plot(scale * curve.errors, shown, **line, label=name_of(curve.controller))
        for beyond, edge, arrow in (
            (ratio > HIGHEST, HIGHEST / 1.12, "^"),
            (ratio < LOWEST, LOWEST * 1.12, "v"),
        ):
            at = scale * curve.errors[beyond]
            at = at[:: max(1, at.size // ARROWS)]
            axes.plot(at, np.full(at.size, edge), arrow, color=line["color"], ms=5, zorder=5)
        for error in curve.break_even(metric):
            if error is not None:
                axes.plot(
                    scale * error, 1.0, linestyle="none", marker="o", ms=5, zorder=5,
                    markerfacecolor="white", markeredgecolor=line["color"],
                )  # fmt: skip
    if (curves[0].errors < 0.0).any():
        axes.axvline(0.0, color=GREY, linewidth=0.7)
