"""Figures of a design: the price of each guarantee."""

from typing import TYPE_CHECKING

import numpy as np

from design.studies.design_study import DesignStudy
from reports.design.tables import GUARANTEES
from reports.design.words import WHOLE
from reports.shared.figures.style import BLUE, PALE, new_figure, styled
from reports.shared.glossary import BROKEN
from reports.shared.tables import measured

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BEYOND = 2.0
"""A bar that is longer than the next by this factor ends at the axis, with an arrow at its value."""


def draw_prices(study: DesignStudy) -> "Figure":
    """Worst IAE of each row of the price list, a panel a motion; a row without gains is open."""
    with styled():
        rows = max(len(m.prices) for m in study.motions)
        figure, axes = new_figure(1, len(study.motions), 0.6 + 0.38 * rows)
        for at, m in zip(axes, study.motions, strict=True):
            names = [f"{GUARANTEES.get(r['guarantee'], r['guarantee'])}\n{r['controller']}" for r in m.prices]
            heights = [r["worst_iae_deg_s"] or 0.0 for r in m.prices]
            place = np.arange(len(names))[::-1]
            held = [r["guarantee"] in WHOLE and r["feasible"] for r in m.prices]
            end = _axis_end(heights)
            at.barh(place, np.minimum(heights, end), color=[BLUE if h else PALE for h in held])
            for y, r in zip(place, m.prices, strict=True):
                mark = "" if r["feasible"] else f" {BROKEN}"
                text = "open" if r["worst_iae_deg_s"] is None else f"{measured(r['worst_iae_deg_s'])}{mark}"
                height = r["worst_iae_deg_s"] or 0.0
                text = f"→ {text}" if height > end else text
                at.annotate(text, (min(height, end), y), (4, 0), textcoords="offset points", va="center")
            at.set_yticks(place, labels=names)
            at.set(title=m.motion, xlabel="Worst IAE [deg s]", xlim=(0.0, 1.35 * end))
            at.grid(False)
    return figure


def _axis_end(heights: list[float]) -> float:
    """The longest bar that is drawn whole.

    >>> _axis_end([44.5, 8.0, 7.0]), _axis_end([11.1, 8.0])
    (8.0, 11.1)
    """
    longest, *others = sorted(heights, reverse=True)
    return others[0] if others and longest > BEYOND * others[0] > 0.0 else longest
