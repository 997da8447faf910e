"""Figure of a search: the ranking of effects in each round, and which were refitted."""

from typing import TYPE_CHECKING

from plants.measured.trace.choose import WORTH, Round
from plants.measured.trace.screening import Ranked
from plants.measured.trace.trace import StageTrace
from reports.style import BLACK, BLUE, DASHED, GREEN, PALE, VERMILLION, new_figure, styled
from reports.tables import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FLOOR = 1e-4
"""What falls by less is drawn as this; the axis is logarithmic."""


def draw_ranking(stage: StageTrace) -> "Figure":
    """By how much each effect would lower chi-square, in its best form, one panel a round; the tick on
    a bar is what noise alone would bring, the line what an effect must bring at least."""
    rounds = stage.search.rounds
    columns = 1 if len(rounds) == 1 else 2
    rows = -(-len(rounds) // columns)
    most = max(len(best_forms(r.ranking)) for r in rounds)
    top = max([q.drop for r in rounds for q in r.ranking] + [WORTH])
    with styled():
        figure, axes = new_figure(rows, columns, height=rows * (1.05 + 0.235 * most), sharex=True)
        for count, (panel, round_) in enumerate(zip(axes, rounds, strict=False), start=1):
            _round(panel, round_, count)
            panel.set_xlim(FLOOR, top * (8.0 if columns == 1 else 700.0))
        for panel in axes[len(rounds) :]:
            figure.delaxes(panel)
        for panel in axes[max(0, len(rounds) - columns) : len(rounds)]:
            panel.set_xlabel("Fall of chi-square per row [-]")
            panel.tick_params(labelbottom=True)
    return figure


def best_forms(ranking: tuple[Ranked, ...]) -> list[Ranked]:
    """The best form of each effect, in the order of a ranking."""
    found: dict[str, Ranked] = {}
    for r in ranking:
        found.setdefault(r.name, r)
    return list(found.values())


def _round(axes: "Axes", round_: Round, count: int) -> None:
    best = best_forms(round_.ranking)
    had = set(round_.before.model.effects)
    refitted = {n: c.model.chi2 for c in round_.candidates for n in set(c.model.effects) - had}
    taken = set() if round_.taken is None else set(round_.taken.model.effects) - had
    if round_.taken is not None:  # perhaps in a better form than the one that was refitted first
        refitted |= dict.fromkeys(taken, round_.taken.model.chi2)
    for y, r in enumerate(best):
        colour = GREEN if r.name in taken else BLUE if r.name in refitted else PALE
        axes.barh(y, max(r.drop, FLOOR) - 0.1 * FLOOR, left=0.1 * FLOOR, height=0.68, color=colour)
        axes.plot([max(r.chance, FLOOR)] * 2, [y - 0.42, y + 0.42], color=BLACK, linewidth=1.4)
        words = f" refitted: {number(refitted[r.name])}" if r.name in refitted else ""
        if r.name in taken:
            words += ", taken"
        axes.text(max(r.drop, 2.0 * r.chance), y, words, fontsize=8, va="center")
    axes.axvline(WORTH, color=VERMILLION, linestyle=DASHED, linewidth=1.1, zorder=0)
    axes.set_xscale("log")
    axes.set_yticks(range(len(best)), [r.name for r in best])
    axes.set_ylim(len(best) - 0.4, -0.6)
    axes.grid(axis="y", visible=False)
    known = " + ".join(round_.before.model.effects) or "the declared wrist"
    axes.set_title(f"Round {count}: beyond\n{known}", fontsize=9)
