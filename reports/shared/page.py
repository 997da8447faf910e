"""A page with its figures: these put into it, and all written beside each other."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.shared.figures.style import save, svg
from reports.shared.html import Shown, markup

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def shown(drawn: Mapping[str, "Figure"], captions: Mapping[str, str]) -> dict[str, Shown]:
    """Figures as a template takes them, each with the caption of its name."""
    return {n: Shown(markup(svg(f, n, captions[n])), captions[n]) for n, f in drawn.items()}


def write_page(
    folder: Path, name: str, page: str, record: Mapping[str, Any], drawn: Mapping[str, "Figure"]
) -> Path:
    """Write the figures as PNG, NAME.json and NAME.html into a folder, each complete or not at all.

    Returns the path of the page; raises InputError where it cannot be written.
    """
    from plants.files import json_text, write_atomically

    for figure_name, figure in drawn.items():
        save(figure, folder / f"{figure_name}.png")
    write_atomically(folder / f"{name}.json", json_text(record))
    write_atomically(folder / f"{name}.html", page)
    return folder / f"{name}.html"
