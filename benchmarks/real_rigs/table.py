"""The table of all rigs, of the numbers that are kept: error of the standard model, ours and the others'."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.real_rigs.black_box import METHODS
from plants.measured.fitting.fit import CHANNELS

KEPT = Path(__file__).parents[2] / "reports" / "examples" / "real"
ABOUT = {
    "real-rigs.json": "traces of other people's measured rigs, started from the log alone; errors are of "
    "free runs from the command, on whole held-out recordings; made by python -m benchmarks.real_rigs",
    "friction.json": "friction of other people's measured rigs, from displacement to force; errors are of "
    "free runs on rows held out; made by python -m benchmarks.real_rigs",
}
"""What the kept files say of themselves, by name."""


def kept_table() -> str:
    """The table of all rigs whose numbers are kept."""
    kept = [json.loads(p.read_text(encoding="utf-8")) for n in ABOUT if (p := KEPT / n).is_file()]
    found = {k: content[k] for content in kept for k in ("campaigns", "tasks") if k in content}
    return table(found.get("campaigns", ()), found.get("tasks", ()))


def table(campaigns: Sequence[Mapping[str, Any]], tasks: Sequence[Mapping[str, Any]]) -> str:
    """All rigs in Markdown: error of the standard model and of ours, what explains it, and the others'."""
    rows = [_campaign_row(c) for c in campaigns] + [_task_row(t) for t in tasks]
    head = ["rig", "rows, fit + held out", "declared or Coulomb", "ours", "explained", *METHODS, "Bouc-Wen"]
    lines = [head, ["---"] * len(head), *rows]
    return "".join(f"| {' | '.join(row)} |\n" for row in lines)


def _campaign_row(c: Mapping[str, Any]) -> list[str]:
    channel, unit = (CHANNELS[1], "deg") if c["stage"] == "wrist" else (CHANNELS[0], "kPa")
    found = c["channels"][channel]
    names = ", ".join(f"`{e['name']}`" for e in c["effects"])
    share = (c["explained_share"] or {}).get(channel)
    why = f"{names}: {100 * share:.0f} %" if names and share is not None else "no effect adopted"
    before, after = (
        {"error": found[s], "interval_95": found[f"{s}_interval_95"]} for s in ("before", "after")
    )
    least = [before, after, *c["others"].values()]
    cells = [_said(before, least), _said(after, least), why]
    return [
        f"{c['title']} [{unit}]", f"{c['rows']['fit']} + {c['rows']['held_out']}", *cells,
        *(_said(c["others"][m], least) for m in METHODS), "–",
    ]  # fmt: skip


def _task_row(t: Mapping[str, Any]) -> list[str]:
    e = t["errors"]
    left, before = e["ours"]["error"], e["Coulomb"]["error"]
    share = f": {100 * (1.0 - (left / before) ** 2):.0f} %" if left and before and left < before else ""
    why = (", ".join(t["parts"]) or "Coulomb friction") + share
    least = list(e.values())
    return [
        f"{t['task']} [{t['unit']}]", f"{t['rows']['fit']} + {t['rows']['held_out']}",
        _said(e["Coulomb"], least), _said(e["ours"], least), why,
        *(_said(e[m], least) for m in METHODS), _said(e["Bouc-Wen"], least),
    ]  # fmt: skip


def _said(found: Mapping[str, Any], beside: Sequence[Mapping[str, Any]]) -> str:
    """An error to three digits with its interval, in bold where none beside it is less."""
    if found.get("error") is None:
        return str(found.get("why", "–"))
    shown = f"{found['error']:.3g}"
    least = min(float(f["error"]) for f in beside if f.get("error") is not None)
    low, high = (f"{v:.3g}" for v in found["interval_95"])
    return f"{f'**{shown}**' if found['error'] <= least else shown} ({low}–{high})"
