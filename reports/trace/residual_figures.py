"""Figures of what is left: conditional means, autocorrelation, spectrum, and a description of it."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from plants.measured.residual.curves import BinnedCurve
from plants.measured.residual.series.remainder import Remainder
from plants.measured.trace.result import StageTrace
from plants.measured.trace.stages.remainders import remainders
from reports.shared.figures.style import BLACK, BLUE, DASHED, GREY, PALE, VERMILLION, new_figure, styled
from reports.shared.names import CHANNELS
from reports.trace.tables import strength

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
PANELS = 4
"""Variables whose conditional means are drawn, those that the tests found most on."""

DOTS = 1200
"""Rows of a residual that are drawn as dots."""

STILL = 10.0
"""Rates of the pressure [kPa/s] below which the axis is linear, logarithmic above: most rows stand still."""

BINS = 60
"""Bins of the mean in a description, fine enough to show a ripple."""

DECADE = 25
"""Points of a spectrum in each decade of frequency."""

LABELS = {
    "pressure_kPa": "Pressure [kPa]",
    "pressure_rate_kPa_s": "Pressure rate [kPa/s]",
    "direction": "Direction of motion [-]",
    "angle_deg": "Angle [deg]",
    "time_s": "Time [s]",
    "since_reversal_s": "Time since the last reversal [s]",
    "work_kPa": "Travel of the pressure [kPa]",
    "command_V": "Command [V]",
    "other_pressure_kPa": "The other motion's pressure [kPa]",
    "reference_deg": "Set-point [deg]",
}
"""Labels of axes, by variable; a channel of the user's own keeps its name."""

BEFORE: dict[str, Any] = {"color": VERMILLION, "linestyle": DASHED, "marker": "s", "markersize": 3.5}
AFTER: dict[str, Any] = {"color": BLUE, "linestyle": "-", "marker": "o", "markersize": 3.5}


def draw_remainder(stage: StageTrace, after_name: str = "revised") -> "Figure":
    """Conditional means of the residual on the variables that tell most, with the bounds that noise
    alone stays within, its autocorrelation and its spectrum, before the effects and after.

    after_name: what the model with the effects is called.
    """
    revised = stage.after is not stage.before
    with styled():
        figure, axes = new_figure(3, 2, height=6.8)
        unit = CHANNELS[stage.stage.channel][1]
        for panel, variable in zip(axes, telling(stage), strict=False):
            _means(panel, stage, variable, unit, after_name if revised else None)
        _autocorrelation(axes[4], stage, revised)
        _spectrum(axes[5], stage, unit, revised)
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def telling(stage: StageTrace) -> list[str]:
    """The variables on which the conditional means exceed their bounds most, before and after."""
    worth: dict[str, float] = {}
    for f in (*stage.before.findings, *stage.after.findings):
        if f.test == "conditional mean" and f.variable in stage.before.curves:
            worth[f.variable] = max(strength(f), worth.get(f.variable, 0.0))
    return sorted(worth, key=lambda v: -worth[v])[:PANELS]


def _means(axes: "Axes", stage: StageTrace, variable: str, unit: str, after_name: str | None) -> None:
    before, after = stage.before.curves[variable], stage.after.curves.get(variable)
    if after_name is not None and after is not None:
        _band(axes, after, label="band of noise alone")
        axes.plot(before.centre, before.mean, label="residual, declared", **BEFORE)
        axes.plot(after.centre, after.mean, label=f"residual, {after_name}", **AFTER)
    else:
        _band(axes, before, label="band of noise alone")
        axes.plot(before.centre, before.mean, label="residual, declared", **BEFORE)
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    if variable == "pressure_rate_kPa_s":
        axes.set_xscale("symlog", linthresh=STILL)
    axes.set(xlabel=LABELS.get(variable, variable), ylabel=f"Mean residual [{unit}]")
    axes.margins(y=0.15)


def _band(axes: "Axes", curve: BinnedCurve, label: str) -> None:
    axes.fill_between(curve.centre, curve.low, curve.high, color=PALE, linewidth=0.0, label=label, zorder=0)


def _autocorrelation(axes: "Axes", stage: StageTrace, revised: bool) -> None:
    before, after = stage.before.curves["autocorrelation"], stage.after.curves["autocorrelation"]
    _band(axes, after, "")
    axes.plot(before.centre, before.mean, **BEFORE)
    if revised:
        axes.plot(after.centre, after.mean, **AFTER)
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.set(xlabel="Lag [s]", ylabel="Autocorrelation [1]", ylim=(min(-0.2, axes.get_ylim()[0]), 1.05))


def _spectrum(axes: "Axes", stage: StageTrace, unit: str, revised: bool) -> None:
    sides = [(stage.before, BEFORE)] + ([(stage.after, AFTER)] if revised else [])
    for examination, look in sides:
        f, power = thinned(examination.curves["spectrum"])
        axes.loglog(f, power, **{**look, "marker": "", "linewidth": 1.3})
    axes.set(xlabel="Frequency [Hz]", ylabel=f"Power [{unit}²/Hz]")


def thinned(curve: BinnedCurve) -> tuple[Array, Array]:
    """A spectrum averaged within bins of equal width on a logarithmic axis: frequency, power."""
    used = curve.centre > 0.0
    f, power = curve.centre[used], curve.mean[used]
    decades = np.log10(f[-1] / f[0])
    label = np.floor(np.log10(f / f[0]) * DECADE).astype(int).clip(0, int(decades * DECADE))
    counts = np.bincount(label)
    full = counts > 0
    return (np.bincount(label, f) / np.maximum(counts, 1))[full], (
        np.bincount(label, power) / np.maximum(counts, 1)
    )[full]


def described(stage: StageTrace) -> list[str]:
    """Variables to draw an unexplained residual against: those of its description, or else those
    that it was found to depend on, or else time."""
    named = ["time_s" if n == "time" else n for n in stage.after.depends_on]
    wanted = stage.description.variables if stage.description is not None else dict.fromkeys(named)
    there = [v for v in wanted if v in stage.after.curves]
    return there[:3] or ["time_s"]


def draw_description(stage: StageTrace) -> "Figure":
    """What is left against what it depends on: rows as dots, their mean, and the curve learnt from them,
    which is a description and not a cause."""
    left, variables = remainders(stage.model), described(stage)
    unit = CHANNELS[stage.stage.channel][1]
    with styled():
        figure, axes = new_figure(1, len(variables), height=3.6, sharey=True)
        for panel, variable in zip(axes, variables, strict=True):
            _dots(panel, left, variable)
            for c in () if stage.description is None else stage.description.curves:
                if c.variable == variable:
                    panel.plot(c.at, c.term, color=BLACK, linewidth=2.0, label="fitted description")
            panel.set_xlabel(LABELS.get(variable, variable))
            panel.axhline(0.0, color=GREY, linewidth=0.6)
        axes[0].set_ylabel(f"Residual [{unit}]")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _dots(axes: "Axes", left: Sequence[Remainder], variable: str) -> None:
    x = np.concatenate([r.variables[variable] for r in left])
    y = np.concatenate([r.value for r in left])
    some = np.random.default_rng(0).permutation(len(x))[:DOTS]
    axes.plot(x[some], y[some], ".", color="#b8b8b8", markersize=3, zorder=0, label="rows of the recordings")
    axes.plot(*means(x, y), color=BLUE, linewidth=1.5, label=f"mean, in {BINS} bins")


def means(x: Array, y: Array) -> tuple[Array, Array]:
    """Means of x and y in bins of equally many rows along x; of fewer where values of x repeat."""
    order = np.argsort(x, kind="stable")
    starts = np.searchsorted(x[order], np.quantile(x, np.arange(BINS) / BINS))
    edges = np.unique([*starts, x.size])
    pieces = [order[a:b] for a, b in pairwise(edges)]
    return np.array([x[p].mean() for p in pieces]), np.array([y[p].mean() for p in pieces])
