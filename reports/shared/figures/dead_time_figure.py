"""Overshoot against added dead time: a panel a plant, two controllers in colour, the others named where
they end."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from design.comparison.behind_dead_time import DeadTimeSweep
from reports.shared.figures.direct_labels import label_ends
from reports.shared.figures.style import (
    DASHED,
    DOTTED,
    FAINT,
    VERMILLION,
    controller_line,
    new_figure,
    styled,
)
from reports.shared.names import name_of
from reports.shared.tables import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SETTLED = "Dotted: a step does not settle within the run."
"""What a caption says of the line styles."""


def kept_up_to(sweep: DeadTimeSweep, name: str, limit: float | None) -> str:
    """Up to which dead time of a sweep a controller keeps the limit on overshoot [%], in words; nothing where
    there is no limit."""
    if limit is None:
        return ""
    kept = sweep.overshoot[name] <= limit
    if not kept[0]:
        return f"{name_of(name)} beyond {limit:g} % even without dead time"
    if kept.all():
        return f"{name_of(name)} within {limit:g} % up to {1000.0 * sweep.dead_times[-1]:.3g} ms at least"
    beyond = int(np.argmin(kept))
    pair = slice(beyond - 1, beyond + 1)  # between two dead times that were played, on a straight line
    late = float(np.interp(limit, sweep.overshoot[name][pair], sweep.dead_times[pair]))
    return f"{name_of(name)} within {limit:g} % up to about {number(1000.0 * late, 2)} ms"


def dead_time_figure(
    sweeps: Mapping[str, DeadTimeSweep], limit: float | None, coloured: Mapping[str, Sequence[str]]
) -> "Figure":
    """Worst overshoot of every controller over the dead time; sweeps and the controllers that are coloured by
    the title of their panel, which may be empty."""
    with styled():
        figure, axes = new_figure(len(sweeps), 1, height=0.5 + 2.6 * len(sweeps), sharex=True)
        for panel, (title, sweep) in zip(axes, sweeps.items(), strict=True):
            for place, name in enumerate(sweep.overshoot):
                look: dict[str, Any] = {"color": FAINT, "linewidth": 1.0, "zorder": 2}
                if name in coloured[title]:
                    look = controller_line(_line_of(name), place) | {"zorder": 4, "label": name_of(name)}
                _curve(panel, sweep, name, look)
            if limit is not None:
                panel.axhline(
                    limit, color=VERMILLION, linestyle=DASHED, linewidth=1.1, label=f"limit {limit:g} %"
                )
            panel.set(ylabel="Worst overshoot [%]", title=title)
            panel.set_xlim(0.0, 1000.0 * float(sweep.dead_times[-1]))
            panel.set_ylim(bottom=0.0)
        axes[-1].set_xlabel("Added dead time [ms]")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
        for panel, (title, sweep) in zip(axes, sweeps.items(), strict=True):
            grey = [n for n in sweep.overshoot if n not in coloured[title]]
            label_ends(panel, {name_of(n): float(sweep.overshoot[n][-1]) for n in grey})
    return figure


def _curve(axes: "Axes", sweep: DeadTimeSweep, name: str, look: Mapping[str, Any]) -> None:
    """A controller's overshoot, dotted from the first dead time behind which a step does not settle."""
    x, y = 1000.0 * sweep.dead_times, sweep.overshoot[name]
    lost = int(np.argmin(np.append(sweep.settles[name], False)))
    axes.plot(x[:lost], y[:lost], gid=name_of(name), **look)
    first = max(lost - 1, 0)
    if lost < x.size:
        plain = {k: v for k, v in look.items() if k != "label" or not lost}
        axes.plot(x[first:], y[first:], gid=name_of(name), **{**plain, "linestyle": DOTTED})


def _line_of(name: str) -> str:
    """Whose line a page's own name of a controller has."""
    return {"these gains": "tuned", "paper's PI (stand-in)": "paper"}.get(name, name)
