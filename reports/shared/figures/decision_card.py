"""The decision card as a picture: steps, gains, and each limit by what it holds under."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from reports.shared.card import CardRow, gains_words, matrix_table, proof_words
from reports.shared.figures.style import (
    BLACK,
    BLUE,
    DASHED,
    DOTTED,
    GREEN,
    GREY,
    ORANGE,
    VERMILLION,
    WIDTH,
    new_figure,
    styled,
)
from reports.shared.glossary import BROKEN, MET
from reports.shared.tables import Cell, Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SMALL = 7.0
"""Size of the letters of the table [pt]."""

TITLE = 77
"""Letters of a title that stand in one line above the table."""

LIMIT, BOUND = 0.17, 0.1
"""Widths of the first two columns, as shares of the table's."""


def draw_steps(rows: Sequence[CardRow]) -> "Figure":
    """The step of each motion: nominal, behind the longest dead time, and the band of fresh cases."""
    with styled():
        figure, axes = new_figure(1, len(rows), 2.7, sharey=True)
        for at, r in zip(axes, rows, strict=True):
            _step(at, r)
            at.set(title=r.motion, xlabel="Time [s]")
        axes[0].set_ylabel("Angle [deg]")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def draw_card(rows: Sequence[CardRow]) -> "Figure":
    """The whole card: a row a motion, its step beside its gains and limits."""
    with styled():
        figure, axes = new_figure(
            len(rows), 2, 0.5 + 2.2 * len(rows), 1.4 * WIDTH, gridspec_kw={"width_ratios": (1.0, 2.2)}
        )
        for at, table, r in zip(axes[::2], axes[1::2], rows, strict=True):
            _step(at, r)
            at.set_ylabel("Angle [deg]")
            at.set_title(r.motion)
            table.set_axis_off()
            gains, proof = gains_words(r.gains), f"stability {proof_words(r)}"
            apart = "; " if len(gains) + len(proof) < TITLE else "\n"
            table.set_title(f"{gains}{apart}{proof}", fontsize=8.5)
            _matrix(table, matrix_table([r]))
        axes[-2].set_xlabel("Time [s]")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def _step(at: "Axes", r: CardRow) -> None:
    """One motion's step."""
    b = r.band
    words = f"{b['cases']} fresh cases"
    at.fill_between(b["time_s"], b["low"], b["high"], color=GREY, alpha=0.35, lw=0, label=words)
    at.plot(b["time_s"], b["nominal"], color=BLUE, lw=1.6, label="plant as fitted")
    if b["dead_time_s"]:
        words = f"with {1000 * b['dead_time_s']:.3g} ms dead time"
        at.plot(b["time_s"], b["late"], color=ORANGE, lw=1.6, ls=DASHED, label=words)
    at.axhline(b["step"], color=BLACK, lw=0.7)
    if r.overshoot is not None:
        top = b["step"] * (1.0 + r.overshoot / 100.0)
        words = f"overshoot limit, {r.overshoot:g} %"
        at.axhline(top, color=VERMILLION, lw=1.1, ls=DOTTED, label=words)
    at.set_xlim(0.0, b["time_s"][-1])


def _matrix(at: "Axes", table: Table) -> None:
    """Limits as rows, what they are judged under as columns; the last one, of proofs, is left out."""
    heads = [c.heading for c in table.columns[:-1]]
    lines = [r[: len(heads)] for r in table.groups[0].rows]
    each = (1.0 - LIMIT - BOUND) / (len(heads) - 2)
    right = [LIMIT + BOUND + each * i for i in range(len(heads) - 1)]
    places = [(0.0, "left"), *((x, "right") for x in right)]
    high = 1.0 / (len(lines) + 1.6)
    for head, (x, side) in zip(heads, places, strict=True):
        at.text(x, 1.0, "\n".join(_halves(head)), ha=side, va="top", fontsize=SMALL, color=GREY)
    for n, cells in enumerate(lines):
        y = 1.0 - high * (n + 2.1)
        at.axhline(y + 0.5 * high, color=GREY, lw=0.3, alpha=0.6)
        for cell, (x, side) in zip(cells, places, strict=True):
            mark, colour = _look(cell)
            at.text(x, y, f"{mark} {cell.text}".strip(), ha=side, va="center", fontsize=SMALL, color=colour)
    at.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))


def _halves(words: str) -> tuple[str, str]:
    """A heading in two lines of about the same length; the second may be empty.

    >>> _halves("every branch and start"), _halves("nominal")
    (('every branch', 'and start'), ('nominal', ''))
    """
    parts = words.split()
    cut = min(range(1, len(parts) + 1), key=lambda i: max(len(" ".join(h)) for h in (parts[:i], parts[i:])))
    return " ".join(parts[:cut]), " ".join(parts[cut:])


def _look(cell: Cell) -> tuple[str, str]:
    """The mark of a cell, and its colour."""
    if cell.broken:
        return BROKEN, VERMILLION
    return (MET, GREEN) if cell.met else ("", BLACK)
