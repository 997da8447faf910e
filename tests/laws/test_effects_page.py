"""The page of effects says what a file may hold: each parameter with its unit, range, null and trials."""

import re
from collections import defaultdict
from dataclasses import fields

from plants.effects import EFFECTS
from tests.cli.terminal import ROOT

PAGE = (ROOT / "docs" / "effects.md").read_text(encoding="utf-8")


def declared(form):
    """Rows of a form: parameter, meaning, unit, from, to, absent at, tried first, moved by."""
    for part in fields(form):
        if "kind" in part.metadata:
            kind, spread = part.metadata["kind"], part.metadata["spread"]
            tried = ", ".join(f"{t:g}" for t in part.metadata["trials"])
            moved = "a factor" if spread is None else f"{spread:g}"
            numbers = (f"{kind.low:g}", f"{kind.high:g}", f"{part.default:g}")
            yield (f"`{part.name}`", kind.meaning, kind.unit, *numbers, tried, moved)


def written():
    """Rows of the page by effect and form."""
    found, name = defaultdict(list), ""
    for line in PAGE.splitlines():
        if heading := re.fullmatch(r"## (\S+)", line):
            name = heading[1]
        elif line.startswith("| ") and not line.startswith(("| form", "| ---")):
            form, *row = (cell.strip() for cell in line.strip("| ").split(" | "))
            found[name, form].append(tuple(row))
    return found


def test_every_parameter_is_as_the_page_says():
    page = written()
    for name, forms in EFFECTS.items():
        for form in forms:
            if form.__module__.startswith("plants.effects."):
                rows = list(declared(form))
                shown = "\n".join(" | ".join(("", form.FORM, *row, "")).strip() for row in rows)
                assert page[name, form.FORM] == rows, f"docs/effects.md, {name}:\n{shown}"
