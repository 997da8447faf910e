"""Drawing the paper's figures: panels of series, and the labels that say what to look at."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from design.evaluation.metrics import SETTLING_BAND
from design.evaluation.scenarios import STEP
from design.studies.paper import HOLD, STAIRCASE
from design.studies.shown.panels import Panel, Series
from plants.wrist import COMMAND_RANGE
from reports.shared.figures.style import (
    BLACK,
    BLUE,
    DASHED,
    DOTTED,
    GREY,
    LINES,
    PALE,
    VERMILLION,
    new_figure,
    seen,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Plot = Callable[[tuple[Panel, ...]], "Figure"]
SMALL = 8.5
"""Size of labels within the axes [pt]."""

ROLES: dict[str, dict[str, Any]] = {
    "model": {"color": BLUE, "linestyle": "-"},
    "beside": {"color": VERMILLION, "linestyle": DOTTED, "linewidth": 2.0},
    "command": {"color": BLACK, "linestyle": DASHED, "linewidth": 1.1},
    "guide": {"color": GREY, "linestyle": DASHED, "linewidth": 1.0},
    "points": {"color": BLACK, "linestyle": "none", "marker": "o", "ms": 5, "markerfacecolor": "white"},
}


def plot_series(axes: "Axes", panel: Panel) -> None:
    """Draw the series of a panel by their roles, with labels and title; bounds as a band."""
    axes.set(title=panel.title, xlabel=panel.x_label, ylabel=panel.y_label)
    models = 0
    for s in panel.series:
        look = dict(ROLES[s.role])
        if s.role == "model":
            look |= LINES[models % len(LINES)]
            models += 1
        if s.low is not None and s.high is not None:
            band: dict[str, Any] = {"color": PALE, "linewidth": 0, "label": "over the range of its gains"}
            every = seen(len(s.x), 400)  # smooth
            axes.fill_between(s.x[every], s.low[every], s.high[every], **band)
        axes.plot(s.x, s.y, label=s.name, **look)


def note(
    axes: "Axes", text: str, at: tuple[float, float], place: tuple[float, float], **text_look: Any
) -> None:
    """Write at `place` a label [offset in points] with a thin line to a point [data]."""
    look: dict[str, Any] = {"fontsize": SMALL, "color": "#222222", "ha": "left", "va": "center"}
    look |= {"bbox": {"facecolor": "white", "edgecolor": "none", "pad": 0.6}} | text_look
    arrow = {"arrowstyle": "-", "color": GREY, "linewidth": 0.7, "shrinkB": 2}
    axes.annotate(text, at, place, textcoords="offset points", arrowprops=arrow, **look)


def steady_line(panels: tuple[Panel, ...]) -> "Figure":
    """Fig. 5."""
    figure, (axes,) = new_figure(height=3.3)
    plot_series(axes, panels[0])
    axes.set(xlim=(-0.1, 4.1), ylim=(-6, 212))
    axes.legend(loc="upper left")
    top = panels[0].series[1]
    note(axes, f"{top.x[-1]:g} V reach {top.y[-1]:.1f} kPa", (top.x[-1], top.y[-1]), (-4, -48), ha="right")
    return figure


def regulator_responses(panels: tuple[Panel, ...]) -> "Figure":
    """Figs. 6 and 8."""
    figure, (whole, near) = new_figure(1, 2, height=3.3)
    for axes, panel in zip((whole, near), panels, strict=True):
        plot_series(axes, panel)
        axes.set_xlim(panel.series[0].x[0], panel.series[0].x[-1])
    whole.set_ylim(95, 153)
    asked = float(panels[0].series[0].y.max())
    if any(s.role == "beside" for s in panels[0].series):
        near.set_ylim(asked - 0.3 * (asked - 100.0), asked + 2.5)
    else:
        near.set_ylim(95, 153)
    near.set_ylabel("")
    entries = whole.get_legend_handles_labels()
    figure.legend(*entries, loc="outside lower center", ncols=2 if len(entries[0]) > 3 else 3)
    return figure


def initial_motions(panels: tuple[Panel, ...]) -> "Figure":
    """Fig. 10."""
    figure, both = new_figure(1, 2, height=3.5)
    for axes, panel in zip(both, panels, strict=True):
        _through_rest(axes)
        plot_series(axes, panel)
        virgin = panel.named("virgin curve")
        _limits(axes, virgin)
        still = virgin.x[np.abs(virgin.y) < 1e-9]
        axes.axvspan(still[0], still[-1], color=PALE, alpha=0.6, linewidth=0)
        low = axes.get_ylim()[0]
        label = f"dead zone\n{still[0] - 100:+.1f} to\n{still[-1] - 100:+.1f} kPa".replace("-", "−")
        axes.text(still[-1] + 4, 0.78 * low, label, fontsize=SMALL, va="center")
        _out_of_reach(axes, panel.named("held for 20 s"))
    figure.legend(*both[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def staircase_pressures(panels: tuple[Panel, ...]) -> "Figure":
    """Fig. 11."""
    figure, (axes,) = new_figure(height=3.2)
    (panel,) = panels
    plot_series(axes, panel)
    axes.lines[0].set_drawstyle("steps-post")  # the applied pressure jumps
    axes.set(xlim=(0, len(STAIRCASE) * HOLD), ylim=(-12, 235), xticks=np.arange(len(STAIRCASE) + 1) * HOLD)
    reached = panel.series[1]
    first = 3 * HOLD
    at = (first - 4, float(np.interp(first - 4, reached.x, reached.y)))
    top = f"{COMMAND_RANGE[1]:g} V end at {reached.y.max():.1f} kPa"
    note(axes, top, at, (18, 14))
    axes.legend(loc="lower left", bbox_to_anchor=(0.02, 0.02))
    return figure


def hysteresis_loops(panels: tuple[Panel, ...]) -> "Figure":
    """Fig. 12."""
    figure, both = new_figure(1, 2, height=4.0)
    for axes, panel in zip(both, panels, strict=True):
        _through_rest(axes)
        plot_series(axes, panel)
        line1, line2, path = (panel.named(n) for n in ("line 1", "line 2", "path"))
        low, high = float(path.y.min()), float(path.y.max())
        axes.set(xlim=(-6, 212), ylim=(low - 0.14 * (high - low), high + 0.14 * (high - low)))
        note(axes, "line 1", _at(line1, 128.0), (18, -16))
        note(axes, "line 2", _at(line2, 72.0), (-18, 16), ha="right")
        peak = int(np.argmax(path.y))
        after = peak + int(np.argmax(path.x[peak:] < path.x[peak] - 7.0))
        note(axes, "transit", (float(path.x[after]), float(path.y[after])), (-16, 13), ha="right")
        least = int(np.argmin(path.y))
        after = least + int(np.argmax(path.x[least:] > path.x[least] + 7.0))
        note(axes, "transit", (float(path.x[after]), float(path.y[after])), (16, -13))
        for share, turning in ((0.35, peak), (0.65, least)):
            _arrow(axes, path, turning, share)
    named = dict(zip(*reversed(both[0].get_legend_handles_labels()), strict=True))
    words = ["path of the simulation", f"steady state, each level held for {HOLD:g} s"]
    figure.legend([named["path"], named["steady states"]], words, loc="outside lower center", ncols=2)
    return figure


def angles_on_staircase(panels: tuple[Panel, ...]) -> "Figure":
    """Fig. 13."""
    figure, both = new_figure(2, 1, height=5.2, sharex=True)
    for axes, panel in zip(both, panels, strict=True):
        axes.axhline(0.0, color=GREY, linewidth=0.7)
        plot_series(axes, panel)
        s = panel.series[0]
        span = float(np.ptp(s.y))
        axes.set_ylim(s.y.min() - 0.2 * span, s.y.max() + 0.08 * span)
        for i, level in enumerate(STAIRCASE):
            place = ((i + 0.5) * HOLD, s.y.min() - 0.13 * span)
            axes.text(*place, f"{level:g}", fontsize=8, color="#444444", ha="center", va="center")
    both[0].set_xlabel("")
    both[1].set(xlim=(0, len(STAIRCASE) * HOLD), xticks=np.arange(len(STAIRCASE) + 1) * HOLD)
    both[0].text(
        1.0, 1.02, "numbers below: applied pressure [kPa]", transform=both[0].transAxes, fontsize=SMALL,
        color="#444444", ha="right", va="bottom",
    )  # fmt: skip
    return figure


def pi_steps(panels: tuple[Panel, ...], mark: tuple[float, str] | None = None) -> "Figure":
    """Figs. 14 and 15; `mark` is a time [s] to be pointed out, and what is to be said there."""
    figure, (angle, pressure) = new_figure(2, 1, height=4.6, sharex=True, height_ratios=(3, 2))
    plot_series(angle, panels[0])
    plot_series(pressure, panels[1])
    band = STEP * SETTLING_BAND
    for edge in (STEP - band, STEP + band):
        angle.axhline(edge, color=GREY, linestyle=DOTTED, linewidth=0.9)
    angle.set(xlabel="", xlim=(0, 10), ylim=(0, 19.5))
    words = f"settling band ± {100 * SETTLING_BAND:g} %"
    angle.text(9.95, STEP + band + 0.15, words, fontsize=SMALL, ha="right", va="bottom")
    if mark:
        angle.axvline(mark[0], ymax=0.55, color=GREY, linestyle=DASHED, linewidth=0.9)
        angle.text(mark[0] + 0.12, 5.0, mark[1], fontsize=SMALL, va="center")
    figure.legend(*angle.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _through_rest(axes: "Axes") -> None:
    axes.axhline(0.0, color="#999999", linewidth=0.7)
    axes.axvline(100.0, color="#999999", linewidth=0.7)


def _limits(axes: "Axes", s: Series) -> None:
    span = float(np.ptp(s.y))
    axes.set(xlim=(-8, 212), ylim=(s.y.min() - 0.1 * span, s.y.max() + 0.12 * span))


def _out_of_reach(axes: "Axes", points: Series) -> None:
    x, y = float(points.x[-1]), float(points.y[-1])
    if x < 199.5:
        note(axes, f"{COMMAND_RANGE[1]:g} V reach {x:.1f} kPa\ninstead of 200", (x, y), (-20, -2), ha="right")


def _at(s: Series, x: float) -> tuple[float, float]:
    return x, float(np.interp(x, s.x, s.y))


def _arrow(axes: "Axes", path: Series, turning: int, share: float) -> None:
    """An arrow head on the path after a turning point, where its pressure has gone some way across."""
    x = path.x[turning:]
    far = float(path.x.min() if x[0] > 100.0 else path.x.max())
    aim = x[0] + share * (far - x[0])
    i = turning + int(np.argmax((x - aim) * (x[0] - aim) <= 0.0))
    tail, head = (path.x[i - 1], path.y[i - 1]), (path.x[i], path.y[i])
    axes.annotate("", head, tail, arrowprops={"arrowstyle": "-|>", "color": BLUE, "mutation_scale": 14})
