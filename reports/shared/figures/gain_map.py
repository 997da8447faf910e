"""The map of the gains: cost, the regions where limits are broken, and where everybody stands."""

from typing import TYPE_CHECKING, Any

import numpy as np

from design.synthesis.tuning import Tuning
from design.synthesis.tuning_rules import PAPER_GAINS, baselines, paper_range
from reports.shared.figures.style import BLACK, GREY, ORANGE, new_figure, styled
from reports.shared.names import COST_WORDS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LIMIT_WORDS = {
    "overshoot_percent": "overshoot > {:g} %",
    "Ms": "Ms > {:g}",
    "delay_margin_s": "delay margin < {:g} s",
    "total_variation_V": "travel > {:g} V",
    "steady_error_percent": "steady error > {:g} %",
    "Mt": "Mt > {:g}",
    "settling_time_s": "not settled in {:g} s",
    "WT": "|W T| > {:g}",
}
HATCHES = {
    "overshoot_percent": "///",
    "Ms": "|||",
    "delay_margin_s": "xxx",
    "total_variation_V": "\\\\\\",
    "steady_error_percent": "---",
    "Mt": "...",
    "settling_time_s": "oo",
    "WT": "++",
}
MARKS = {"SIMC": "s", "AMIGO": "^", "Ziegler-Nichols": "v"}


def gain_map(tuning: Tuning) -> "Figure":
    """Worst cost over the gains; hatched where limits are broken, by the one broken most; the
    optimum, the ends of the local searches, the paper's stand-in with its range, and the rules."""
    Kp, Ki = tuning.region.grid
    shape = (Kp.size, Ki.size)
    cost = tuning.map.cost.reshape(shape).T
    with styled():
        figure, (axes,) = new_figure(height=5.4)
        axes.set(xscale="log", yscale="log", xlabel="Kp [kPa/deg]", ylabel="Ki [kPa/(deg s)]")
        axes.grid(False)
        known = np.where(np.isfinite(cost), cost, np.nan)
        if np.isfinite(cost).any():  # no gains may settle at all, where the cost is the settling time
            levels = np.geomspace(np.nanmin(known), np.nanmax(known) * 1.001, 13)
            top = 1.6 * levels[-1]  # keeps the darkest blue light enough for hatches and marks
            filled = axes.contourf(Kp, Ki, known, levels=levels, cmap="Blues", vmax=top, extend="max")
            bar = figure.colorbar(filled, ax=axes, pad=0.02, aspect=30)
            bar.set_label(f"Worst {COST_WORDS.get(tuning.problem.cost, tuning.problem.cost)}")
            bar.set_ticks(list(levels[::3]), labels=[f"{v:.3g}" for v in levels[::3]])
            bar.ax.minorticks_off()
        hatched = _limits(axes, tuning, shape)
        _marks(axes, tuning)
        axes.set(xlim=tuning.region.Kp, ylim=tuning.region.Ki)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(lambda v, _: f"{v:g}")
        figure.legend(
            handles=axes.get_legend_handles_labels()[0] + hatched, loc="outside lower center", ncols=2
        )
    return figure


def _limits(axes: "Axes", tuning: Tuning, shape: tuple[int, int]) -> list[Any]:
    """Hatch each limit's region, the cells where it is the one that is broken most; what stands for
    them in a legend."""
    from matplotlib.patches import Patch

    Kp, Ki = tuning.region.grid
    excess = {n: np.nan_to_num(v, posinf=1e6).reshape(shape).T for n, v in tuning.map.excess.items()}
    shown: list[Any] = []
    if not excess:
        return shown
    stacked = np.stack(list(excess.values()))
    worst, largest = stacked.argmax(axis=0), stacked.max(axis=0)
    limits = tuning.problem.limits.named
    for index, name in enumerate(excess):
        here = (worst == index) & (largest > 0.0)
        words = LIMIT_WORDS.get(name, name + " {:g}").format(limits[name])
        if here.any():
            region = axes.contourf(
                Kp,
                Ki,
                here.astype(float),
                levels=[0.5, 1.5],
                colors="none",
                hatches=[HATCHES.get(name, "++")],
            )
            region.set(edgecolor="#555555", linewidth=0.0)
            shown.append(Patch(facecolor="white", edgecolor="#555555", hatch=HATCHES.get(name), label=words))
    held = largest <= 0.0
    if held.any() and not held.all():
        edge = np.clip(largest, -1.0, 1.0)
        axes.contour(Kp, Ki, edge, levels=[0.0], colors=BLACK, linewidths=1.6)
    return shown


def _marks(axes: "Axes", tuning: Tuning) -> None:
    def mark(Kp: float, Ki: float, marker: str, words: str, **look: Any) -> None:
        shown: dict[str, Any] = {"markeredgecolor": BLACK, "markerfacecolor": "white", "ms": 8} | look
        axes.plot(Kp, Ki, linestyle="none", marker=marker, label=words, zorder=5, **shown)

    for i, search in enumerate(tuning.searches):
        mark(*search.end, "o", "end of a local search" if i == 0 else "_", ms=6, markeredgecolor=GREY)
    rules = baselines(tuning.problem.wrist)
    for name, marker in MARKS.items():
        mark(float(rules[name].Kp), float(rules[name].Ki), marker, name)
    Kps, Kis = zip(*paper_range(), strict=True)
    corners = [min(Kps), max(Kps)], [min(Kis), max(Kis)]
    (left, right), (low, high) = corners
    axes.plot([left, right, right, left, left], [low, low, high, high, low], color=BLACK, lw=1.2, zorder=4)
    mark(*PAPER_GAINS, "D", "paper's PI (stand-in), its range", ms=6)
    words = "tuned" if tuning.feasible else "nearest to the limits"
    mark(tuning.Kp, tuning.Ki, "*", words, ms=16, markerfacecolor=ORANGE)
    limit = tuning.active.rsplit("_", 1)[0].replace("_", " ") if tuning.active else "none"
    gains = f"Kp {tuning.Kp:.3g}, Ki {tuning.Ki:.3g}"
    axes.set_title(f"{words.capitalize()}: {gains}; active: {limit}")
