"""Controllers that are not in the repository, known to comparisons and exports by one call."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Registered:
    """A controller by its name: title, and how it is made for a wrist."""

    title: str
    make: Callable[[Any], Any]


REGISTERED: dict[str, Registered] = {}
"""By name, in the order of registration."""


def register(name: str, make: Callable[[Any], Any], title: str | None = None) -> None:
    """Make a controller known by a name: ``make(wrist)`` gives the `Controller` for a `plants.Wrist`.

    `design.comparison.compare.controllers` then plays it beside the others, with the margins of its law, and
    `design.export.catalogue.part` makes C of it.  The same name again replaces it.  title: what it is, in a
    line; the name where not given.
    """
    REGISTERED[name] = Registered(name if title is None else title, make)
