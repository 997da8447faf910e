"""Figures of a design: the steps with their band, and the price of each guarantee."""

from typing import TYPE_CHECKING

import numpy as np

from design.studies.design_study import DesignStudy
from reports.shared.style import BLACK, GREY, ORANGE, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_steps(study: DesignStudy) -> "Figure":
    """The step of each motion: nominal, behind the longest dead time, and the band of fresh cases."""
    with styled():
        figure, axes = new_figure(1, len(study.motions), 3.0, sharey=True)
        for at, m in zip(axes, study.motions, strict=True):
            b = m.band
            over = study.requirements[m.motion]["limits"].get("overshoot_percent")
            at.fill_between(
                b["time_s"], b["low"], b["high"], color=GREY, alpha=0.35, lw=0, label="fresh cases"
            )
            at.plot(b["time_s"], b["nominal"], color=BLACK, lw=1.4, label="as fitted")
            words = f"with {1000 * b['dead_time_s']:.3g} ms more"
            at.plot(b["time_s"], b["late"], color=ORANGE, lw=1.4, ls="--", label=words)
            if over is not None:
                at.axhline(
                    b["step"] * (1 + over / 100), color=GREY, lw=0.8, ls=":", label="limit on overshoot"
                )
            at.set(title=m.motion, xlabel="time [s]", xlim=(0.0, b["time_s"][-1]))
        axes[0].set_ylabel("angle [deg]")
        axes[-1].legend(loc="lower right")
    return figure


def draw_prices(study: DesignStudy) -> "Figure":
    """Worst IAE of each row of the price list, a panel a motion; a row without gains is open."""
    with styled():
        figure, axes = new_figure(1, len(study.motions), 3.0)
        for at, m in zip(axes, study.motions, strict=True):
            names = [f"{r['guarantee']}\n{r['controller']}" for r in m.prices]
            heights = [r["worst_iae_deg_s"] or 0.0 for r in m.prices]
            place = np.arange(len(names))[::-1]
            held = [r["guarantee"] == "worst case found" and r["feasible"] for r in m.prices]
            at.barh(place, heights, color=[ORANGE if h else GREY for h in held])
            for y, r in zip(place, m.prices, strict=True):
                text = (
                    "open"
                    if r["worst_iae_deg_s"] is None
                    else f"{r['worst_iae_deg_s']:.3g}{'' if r['feasible'] else ', not held'}"
                )
                at.text(r["worst_iae_deg_s"] or 0.0, y, f" {text}", va="center")
            at.set_yticks(place, labels=names)
            at.set(title=m.motion, xlabel="worst IAE [deg s]", xlim=(0.0, 1.35 * max(heights)))
            at.grid(False)
    return figure
