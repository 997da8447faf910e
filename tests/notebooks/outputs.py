"""What a notebook shows, as tests compare it: kinds of output, and the numbers in its text."""

import math
import re
from typing import Any

TEXTS = ("text/markdown", "text/plain")
NUMBER = re.compile(r"(?<![\w.])[-−+]?(?:\d+\.?\d*(?:e[-+]?\d+)?|∞)(?!\w)")
TOLERANCE = 0.05
"""Share by which a number may differ between machines."""

TINY = 1e-9
"""Differences that are rounding."""


def kinds(cell: Any) -> list[str]:
    """The richest kind of each output of a cell, streams by name."""
    found = []
    for output in cell.get("outputs", ()):
        data = output.get("data", {})
        rich = [k for k in ("image/png", *TEXTS) if k in data]
        found.append(rich[0] if rich else output.get("name", output["output_type"]))
    return found


def text(cell: Any) -> str:
    """All text of a cell's outputs; that of a picture is the name of its class, and left out."""
    found = []
    for output in cell.get("outputs", ()):
        data = output.get("data", {})
        rich = next((data[k] for k in TEXTS if k in data), "") if "image/png" not in data else ""
        found.append(output.get("text", "") + rich)
    return "\n".join(found)


def numbers(words: str) -> list[float]:
    """The numbers in a text, in order."""
    return [
        math.inf if n[-1] == "∞" else float(n.replace("−", "-")) for n in NUMBER.findall(words)
    ]  # fmt: skip


def difference(stored: Any, now: Any) -> str | None:
    """In what a cell shows something else than what is stored of it; None where it does not."""
    if kinds(stored) != kinds(now):
        return f"shows {kinds(now)}, stored are {kinds(stored)}"
    before, after = numbers(text(stored)), numbers(text(now))
    if len(before) != len(after):
        return f"{len(after)} numbers, stored are {len(before)}: {text(now)}"
    for a, b in zip(before, after, strict=True):
        if not math.isclose(a, b, rel_tol=TOLERANCE, abs_tol=TINY):
            return f"{b:g}, stored is {a:g}"
    return None
