"""What the script of a page (`templates/cells.js`) needs to know of a map of gains: of every cell its step
and what limits are held against."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.studies.shown.cell_steps import CellSteps
from design.synthesis.evaluate import Evaluation
from design.synthesis.requirements import LIMIT_UNITS
from reports.shared.card import LIMIT_NAMES
from reports.shared.glossary import BROKEN, NOT_JUDGED
from reports.shared.html import markup
from reports.shared.names import COST_WORDS
from reports.shared.tables import number
from reports.shared.units import in_units

Array = NDArray[np.float64]

TENTHS = 10.0
"""Angles are sent in whole tenths of a degree."""


def cells(
    Kp: Array,
    Ki: Array,
    at: Evaluation,
    steps: CellSteps,
    limits: Mapping[str, float],
    chosen: tuple[float, float],
    cost: str = "",
) -> Any:
    """A map's cells as a JSON element, to stand behind the figure whose first panel is the map.

    Kp (n,), Ki (m,): of its rows and columns; at, steps: of its cells, flattened with Kp in rows; limits: in
    force, by name; chosen: gains whose cell is shown first; cost: that of the map, none where it has none.
    """
    rows = [
        (LIMIT_NAMES[n], LIMIT_UNITS[n], [_value(v, limits.get(n), n) for v in at.values[n]])
        for n in at.values
    ]
    if cost:
        name, _, unit = COST_WORDS[cost].partition(" [")
        known = [number(float(v)) if np.isfinite(v) else NOT_JUDGED for v in at.cost]
        rows.append((f"Worst {name}", unit.rstrip("]"), known))
    first = [int(np.argmin(np.abs(np.log(axis / gain)))) for axis, gain in zip((Kp, Ki), chosen, strict=True)]
    sent = {
        "gains": [[number(float(v)) for v in axis] for axis in (Kp, Ki)],
        "units": [in_units("kPa/deg"), in_units("kPa/(deg s)")],
        "at": first,
        "rows": [[name, in_units("" if unit == "1" else unit), values] for name, unit, values in rows],
        "time": [round(float(t), 3) for t in steps.time],
        "steps": [
            [_late(late), np.round(TENTHS * y).astype(int).tolist()] for late, y in steps.angle.items()
        ],
        "reference": round(TENTHS * steps.reference),
        "per": TENTHS,
        "angle": in_units("Angle [deg]"),
    }  # fmt: skip
    text = json.dumps(sent, separators=(",", ":"), ensure_ascii=False).replace("<", "\\u003c")
    return markup(f'<script type="application/json" class="cells">{text}</script>')


def _value(value: float, limit: float | None, name: str) -> str:
    """A number, marked where it breaks its limit; of gains that were not simulated a dash."""
    if np.isnan(value):
        return NOT_JUDGED
    beyond = limit is not None and (value < limit if name == "delay_margin_s" else value > limit)
    return (f"{BROKEN} " if beyond else "") + number(float(value))


def _late(dead_time: float) -> str:
    return f"{1000.0 * dead_time:.3g} ms dead time" if dead_time else "no dead time"
