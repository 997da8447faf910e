"""A design as a page for a colleague, and beside it the same as JSON and pictures."""

from pathlib import Path
from typing import TYPE_CHECKING

from design.studies.design_study import DesignStudy
from reports.design import alternative_words, figures, tables, words
from reports.design.record import design_record
from reports.shared.card import card, step_caption
from reports.shared.figures.decision_card import draw_card, draw_steps
from reports.shared.figures.style import save, svg
from reports.shared.html import Made, Shown, markup, render

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SECTIONS = {"prices": "What each guarantee costs"}
"""Titles of the page's sections by their ids."""


def write_design(folder: str | Path, study: DesignStudy, made: Made) -> Path:
    """Write design.html, design.json and the figures as PNG into a folder, each complete or not at all.
    Returns the path of the page; raises InputError where it cannot be written."""
    from plants.files import json_text, write_atomically

    folder = Path(folder)
    rows = tables.card_rows(study)
    drawn = {"step": draw_steps(rows), "prices": figures.draw_prices(study)}
    page = design_page(study, made, drawn)
    for name, figure in {**drawn, "card": draw_card(rows)}.items():
        save(figure, folder / f"{name}.png")
    write_atomically(folder / "design.json", json_text(design_record(study)))
    write_atomically(folder / "design.html", page)
    return folder / "design.html"


def design_page(study: DesignStudy, made: Made, drawn: "dict[str, Figure]") -> str:
    """The whole study as one self-contained HTML text."""

    def shown(name: str, caption: str) -> Shown:
        return Shown(markup(svg(drawn[name], name, caption)), caption)

    rows = tables.card_rows(study)
    steps = step_caption(rows, "recommended" if study.holds else "nearest")
    return render(
        "design.html", made=made, title=words.title(study),
        kind=f"design for {' and '.join(m.motion for m in study.motions)}", sections=SECTIONS,
        summary=words.summary(study), remarks=words.remarks(study),
        decision=card(rows, shown("step", steps)), controllers=words.controllers(study),
        price=tables.price_table(study), prices=shown("prices", words.price_caption(study)),
        alternatives=alternative_words.alternatives(study),
    )  # fmt: skip
