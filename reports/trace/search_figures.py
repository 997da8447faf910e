"""Figure of a search: the ranking of effects in each round, and which were refitted."""

from textwrap import fill
from typing import TYPE_CHECKING, Any

from plants.measured.trace.ranking.screening import Ranked
from plants.measured.trace.result import StageTrace
from plants.measured.trace.search.candidate import WORTH
from plants.measured.trace.search.rounds import SearchRound
from reports.shared.figures.style import BLACK, BLUE, DASHED, GREEN, PALE, VERMILLION, new_figure, styled
from reports.shared.tables import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BOX = {"facecolor": "white", "edgecolor": "none", "pad": 0.2}
LATER = 6
"""Effects that are drawn of rounds after the first, those that would lower chi-square most, and what was
selected."""

TITLE = 44
"""Letters in a line of a panel's title: more would leave the figure."""

CHANCE, NEEDED = "noise alone, 95 %", "least for a selection"
"""What the tick on a bar and the dashed line are."""

FLOOR = 1e-4
"""What falls by less is drawn as this; the axis is logarithmic."""


def draw_ranking(stage: StageTrace) -> "Figure":
    """By how much each effect would lower chi-square, in its best form, one panel a round; the tick on
    a bar is what noise alone would bring, the line what an effect must bring at least."""
    rounds = stage.search.rounds
    shown = [drawn_forms(r, None if i == 0 else LATER) for i, r in enumerate(rounds)]
    top = max([q.drop for r in rounds for q in r.ranking] + [WORTH])
    sizes = [0.75 + 0.21 * len(s) for s in shown]
    with styled():
        figure, axes = new_figure(len(rounds), 1, height=0.6 + sum(sizes), height_ratios=sizes, sharex=True)
        for count, (panel, round_, best) in enumerate(zip(axes, rounds, shown, strict=True), start=1):
            _round(panel, round_, best)
            known = " + ".join(round_.before.model.effects) or "the declared wrist"
            title = f"Round {count}: beyond {known}"
            panel.set_title(fill(title, TITLE, break_on_hyphens=False))
        marks = [line for line in axes[0].lines if line.get_label() in (CHANCE, NEEDED)]
        figure.legend(handles=marks, loc="outside lower center", ncols=2)
        axes[-1].set(xlabel="Reduction of chi-square per row [1]", xlim=(FLOOR, 30.0 * top))
    return figure


def best_forms(ranking: tuple[Ranked, ...]) -> list[Ranked]:
    """The best form of each effect, in the order of a ranking."""
    found: dict[str, Ranked] = {}
    for r in ranking:
        found.setdefault(r.name, r)
    return list(found.values())


def drawn_forms(round_: SearchRound, most: int | None) -> list[Ranked]:
    """The best form of each effect that is drawn of a round: so many, all where None, and what was
    selected."""
    best = best_forms(round_.ranking)
    return [r for i, r in enumerate(best) if most is None or i < most or r.name in _selected(round_)]


def _selected(round_: SearchRound) -> set[str]:
    """Effects that a round added."""
    return set() if round_.taken is None else {*round_.taken.model.effects} - {*round_.before.model.effects}


def _round(axes: "Axes", round_: SearchRound, best: list[Ranked]) -> None:
    had = set(round_.before.model.effects)
    refitted = {n: c.model.chi2 for c in round_.candidates for n in set(c.model.effects) - had}
    taken = _selected(round_)
    if round_.taken is not None:  # perhaps in a better form than the one that was refitted first
        refitted |= dict.fromkeys(taken, round_.taken.model.chi2)
    for y, r in enumerate(best):
        colour = GREEN if r.name in taken else BLUE if r.name in refitted else PALE
        hatched: dict[str, Any] = {}
        if r.name in taken:
            hatched = {"hatch": "////", "edgecolor": "white", "linewidth": 0.0}
        axes.barh(y, max(r.drop, FLOOR) - 0.1 * FLOOR, left=0.1 * FLOOR, height=0.68, color=colour, **hatched)
        words = CHANCE if y == 0 else ""
        axes.plot([max(r.chance, FLOOR)] * 2, [y - 0.42, y + 0.42], color=BLACK, linewidth=1.4, label=words)
        words = f" refitted: {number(refitted[r.name])}" if r.name in refitted else ""
        if r.name in taken:
            words += ", selected"
        place = (max(r.drop, 2.0 * r.chance), y)
        axes.text(*place, words, fontsize=8.5, va="center", bbox=BOX if words else None)
    axes.axvline(WORTH, color=VERMILLION, linestyle=DASHED, linewidth=1.1, zorder=2.5, label=NEEDED)
    axes.set_xscale("log")
    axes.set_yticks(range(len(best)), [r.name for r in best])
    axes.set_ylim(len(best) - 0.4, -0.6)
    axes.grid(axis="y", visible=False)
