"""Speed against robustness: worst settling time over delay margin of every controller that was compared."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from design.comparison.compare import TUNED, Comparison
from design.comparison.pareto import margin_s, pareto_front
from design.comparison.rows import Standing
from reports.shared.figures.point_labels import label_points
from reports.shared.figures.style import BLUE, DASHED, GREY, VERMILLION, new_figure, styled
from reports.shared.names import name_of, title_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DRAWN = (
    "Worst settling time against delay margin: better is down and to the right. Hollow mark: a limit is "
    "broken; square: delay tolerated in simulation; arrow: no loop to destabilise."
)


def trade_off_caption(comparison: Comparison) -> str:
    """Who is on the Pareto front of each motion, fastest first, and what is drawn."""
    motions = dict.fromkeys(s.motion for s in comparison.standings)
    fronts = {m: pareto_front([s for s in comparison.standings if s.motion == m]) for m in motions}
    said = [f"{m}: {', '.join(name_of(s.controller) for s in f)}" for m, f in fronts.items() if f]
    return f"Pareto front within the limits: {'; '.join(said)}. {DRAWN}" if said else DRAWN


def trade_off(comparison: Comparison) -> "Figure":
    """A panel a motion; controllers that do not settle within a task are left out."""
    motions = list(dict.fromkeys(s.motion for s in comparison.standings))
    margins = [1000.0 * margin_s(s) for s in comparison.standings if 0.0 < margin_s(s) < np.inf]
    with styled():
        figure, axes = new_figure(len(motions), 1, height=0.6 + 2.3 * len(motions), sharex=True)
        axes[0].set_xscale("log")
        axes[0].set_xlim(0.4 * min(margins), 3.0 * max(margins))
        for panel, motion in zip(axes, motions, strict=True):
            panel.set(title=title_of(motion), yscale="log", ylabel="Worst settling [s]")
            _panel(panel, [s for s in comparison.standings if s.motion == motion])
            limit = comparison.limits.delay_margin_s
            if limit is not None:
                look: dict[str, Any] = {"color": VERMILLION, "linestyle": DASHED, "linewidth": 1.2}
                panel.axvline(1000.0 * limit, label=f"limit {1000.0 * limit:.3g} ms", **look)
        axes[-1].set_xlabel("Delay margin [ms]")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        for panel, motion in zip(axes, motions, strict=True):
            of = [s for s in comparison.standings if s.motion == motion and np.isfinite(s.worst_settling_s)]
            label_points(panel, {name_of(s.controller): _place(panel, s) for s in of})
    return figure


def _panel(axes: "Axes", standings: Sequence[Standing]) -> None:
    """The marks of some controllers, and the front."""
    from matplotlib.ticker import LogLocator, NullLocator

    settled = [s for s in standings if np.isfinite(s.worst_settling_s)]
    times = [s.worst_settling_s for s in settled]
    axes.set_ylim(0.7 * min(times), 1.5 * max(times))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(lambda v, _: f"{v:g}")
        axis.set_minor_locator(NullLocator())
    front = pareto_front(settled)
    line: dict[str, Any] = {"color": GREY, "linewidth": 1.0, "zorder": 2, "label": "Pareto front"}
    axes.plot([1000.0 * margin_s(s) for s in front], [s.worst_settling_s for s in front], **line)
    for s in settled:
        x, y = _place(axes, s)
        colour = BLUE if s.controller == TUNED else GREY
        shape = ">" if not np.isfinite(margin_s(s)) else "o" if s.tolerated_delay_s is None else "s"
        axes.plot(
            x, y, shape, color=colour, markerfacecolor="white" if s.breaks else colour, zorder=4,
            ms=8 if s.controller == TUNED else 5.5, gid=name_of(s.controller),
        )  # fmt: skip


def _place(axes: "Axes", s: Standing) -> tuple[float, float]:
    """Where the mark of a controller is; of an infinite margin near the edge."""
    low, high = axes.get_xlim()
    return float(np.clip(1000.0 * margin_s(s), low, 0.9 * high)), s.worst_settling_s
