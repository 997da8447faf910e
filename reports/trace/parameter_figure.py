"""How well the recordings determine the parameters: relative intervals, and how their errors correlate."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from plants.measured.trace.result import Trace
from plants.parameters.quantities import Fitted
from reports.shared.figures.style import BLACK, BLUE, new_figure, styled
from reports.shared.tables import fixed, number
from reports.trace.fit_figures import SPREAD

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TOLD = 0.5
"""Correlation from which its value stands in its cell."""

DRAWN = (
    "Left: half the width of each parameter's 95 % interval, in per cent of its value. Right: correlation of "
    "the errors; white where parameters were estimated separately. Values of at least 0.5 are "
    "printed: a combination of such parameters is determined better than each alone."
)


def parameters_caption(trace: Trace) -> str:
    """The parameter with the widest interval, the strongest correlation, and what is drawn."""
    names = _names(trace)
    if not names:
        return DRAWN
    sizes = {n: _relative(trace, n) or 0.0 for n in names}
    widest = max(sizes, key=lambda n: sizes[n])
    said = [f"Widest interval: {_short(widest)}, ± {number(sizes[widest], 2)} %."]
    values = np.tril(np.nan_to_num(_matrix(trace, names)), -1)
    row, column = np.unravel_index(int(np.argmax(np.abs(values))), values.shape)
    if abs(value := float(values[row, column])) >= TOLD:
        pair = f"{_short(names[column])} and {_short(names[row])}"
        said.append(f"Strongest correlation: {pair}, {fixed(value, 2)}.")
    return f"{' '.join(said)} {DRAWN}"


def _short(name: str) -> str:
    return name.rpartition(".")[2].replace("_", " ") if "." in name else name


def _names(trace: Trace) -> list[str]:
    """Parameters that have a standard error."""
    return [n for c in trace.correlations for n in c.names if _relative(trace, n) is not None]


def draw_parameters(trace: Trace) -> "Figure | None":
    """A row a parameter that has a standard error; None where none has."""
    names = _names(trace)
    if not names:
        return None
    with styled():
        height = 1.1 + 0.24 * len(names)
        figure, (left, right) = new_figure(1, 2, height, width_ratios=(1, 1.5), sharey=True)
        sizes = [_relative(trace, n) or 0.0 for n in names]
        left.barh(range(len(names)), sizes, color=BLUE, height=0.45)
        for place, size in enumerate(sizes):
            left.annotate(f"{number(size, 2)} %", (size, place), (3, 0), textcoords="offset points",
                          va="center", fontsize=8)  # fmt: skip
        left.set(xscale="log", xlim=(0.4 * min(sizes), 12.0 * max(sizes)), xlabel="± 95 % [% of the value]")
        left.set_yticks(range(len(names)), [n.replace(".", ".\n") for n in names], fontsize=8)
        left.grid(axis="y", visible=False)
        left.minorticks_off()
        _correlations(right, trace, names)
    return figure


def _relative(trace: Trace, name: str) -> float | None:
    """Half the width of a parameter's interval, in per cent; None without a standard error, or at zero."""
    parameter = trace.revised.parameters.get(name)
    if parameter is None or not isinstance(parameter.provenance, Fitted) or not parameter.value:
        return None
    error = parameter.provenance.std_error
    return 100.0 * SPREAD * error / abs(parameter.value) if error else None


def _matrix(trace: Trace, names: list[str]) -> NDArray[np.float64]:
    """Correlations of the errors of parameters, (n, n); nan where they were estimated separately."""
    values = np.full((len(names), len(names)), np.nan)
    for c in trace.correlations:
        kept = c.of(names)
        at = [names.index(n) for n in kept.names]
        values[np.ix_(at, at)] = kept.matrix
    return values


def _correlations(axes: "Axes", trace: Trace, names: list[str]) -> None:
    values = _matrix(trace, names)
    edges = np.arange(len(names) + 1) - 0.5
    axes.pcolormesh(
        edges, edges, values, cmap="RdBu_r", vmin=-1.0, vmax=1.0, edgecolors="white", linewidth=0.5
    )
    for row, column in np.argwhere(np.abs(np.nan_to_num(values)) >= TOLD):
        if row != column:
            value = values[row, column]
            words = f"{value:.1f}".replace("0.", ".").replace("-", "−")
            colour = "white" if abs(value) > 0.75 else BLACK
            axes.text(column, row, words, ha="center", va="center", fontsize=7.6, color=colour)
    labels = [n.rpartition(".")[2] for n in names]
    axes.set_xticks(range(len(names)), labels, rotation=90, fontsize=8)
    axes.set(ylim=(len(names) - 0.5, -0.5), title="Correlation of errors")
    axes.grid(False)
