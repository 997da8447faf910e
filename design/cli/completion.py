"""Values that the shell completes after an option; the names of files it completes by itself."""

from textwrap import shorten
from typing import Any

import typer


def files() -> list[str]:
    """Nothing of ours, so that the shell offers its files and folders."""
    return []


def costs(incomplete: str) -> list[str]:
    from design.synthesis.requirements import COSTS

    return _begun(COSTS, incomplete)


def starts(incomplete: str) -> list[str]:
    from plants.wrist import STARTS

    return _begun(STARTS, incomplete)


def controllers(incomplete: str) -> list[tuple[str, str]]:
    from design.export.catalogue import CATALOGUE
    from design.export.plant.files import PLANT

    titles = {n: _short(entry.title) for n, entry in CATALOGUE.items()} | {PLANT: "The plant itself"}
    return [(n, titles[n]) for n in _begun(titles, incomplete)]


def figures(incomplete: str) -> list[tuple[str, str]]:
    from reports.paper.figures import FIGURES

    titles = {str(number): _short(figure.title) for number, figure in FIGURES.items()}
    return [(n, titles[n]) for n in _begun(titles, incomplete)]


def intervals(context: typer.Context, incomplete: str) -> list[str]:
    """The parameters of the plant that the line names, effects' too; the bounds are for people to give."""
    from plants.errors import InputError
    from plants.parameters.files import built_in, load

    given = context.params
    try:
        chosen = load(given["plant"]) if given.get("plant") else built_in(given.get("axis") or "flexion")
    except InputError:  # no word of it in the middle of a line that is being typed
        return []
    return _begun([f"{name}=" for name in chosen.parameters], incomplete)


def _short(title: str) -> str:
    """A title in one line: typer breaks longer ones, and shells would offer the rest as a name."""
    return shorten(title, 70, placeholder="…")


def _begun(names: Any, incomplete: str) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]
