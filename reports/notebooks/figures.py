"""Figures that only the notebooks draw."""

from typing import TYPE_CHECKING

from design.robustness.certificates.sampled.growth import Growth
from reports.shared.figures.style import GREY, LINES, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def word_growth(growth: Growth) -> "Figure":
    """The state of a loop under a word of branches and rates, again and again, and under each of its
    letters alone; lines where a pass ends."""
    with styled():
        figure, (axes,) = new_figure(height=3.4)
        for look, (name, size) in zip(LINES[1:], growth.alone.items(), strict=False):
            axes.semilogy(growth.time, size, label=f"only {name}", **look)
        bold = {**LINES[0], "linewidth": 2.2}
        axes.semilogy(growth.time, growth.word, label="the switching sequence", zorder=5, **bold)
        for end in growth.ends:
            axes.axvline(end, color=GREY, linewidth=0.6, zorder=0)
        axes.set(
            xlabel="Time [s]", ylabel="Size of the state,\nratio to the first pass [1]",
            xlim=(0.0, growth.time[-1]), ylim=(1e-3, None),
        )  # fmt: skip
        figure.legend(loc="outside lower center", ncols=2)
    return figure
