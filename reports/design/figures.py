"""Figures of a design: the price of each guarantee."""

from typing import TYPE_CHECKING

import numpy as np

from design.studies.design_study import DesignStudy
from reports.design.tables import GUARANTEES
from reports.shared.figures.style import BLUE, PALE, new_figure, styled
from reports.shared.glossary import BROKEN
from reports.shared.tables import measured

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WHOLE = ("worst case found", "proved")
"""Guarantees of the whole requirement; the others are of less."""


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
            at.barh(place, heights, color=[BLUE if h else PALE for h in held])
            for y, r in zip(place, m.prices, strict=True):
                mark = "" if r["feasible"] else f" {BROKEN}"
                text = "open" if r["worst_iae_deg_s"] is None else f"{measured(r['worst_iae_deg_s'])}{mark}"
                end = (r["worst_iae_deg_s"] or 0.0, y)
                at.annotate(text, end, (4, 0), textcoords="offset points", va="center")
            at.set_yticks(place, labels=names)
            at.set(title=m.motion, xlabel="Worst IAE [deg s]", xlim=(0.0, 1.35 * max(heights)))
            at.grid(False)
    return figure
