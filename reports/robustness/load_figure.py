"""The response to a load, and the command under the sensor's noise: what regulation is, beside the steps."""

from typing import TYPE_CHECKING

from design.studies.shown.load_response import MOMENT, LoadResponse
from reports.robustness.branches.signature import COMPARED
from reports.shared.figures.style import BLACK, DOTTED, GREY, controller_line, new_figure, seen, styled
from reports.shared.tables import number

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def load_figure(found: LoadResponse) -> "Figure":
    """Angle after the load, without noise; beneath, the command under noise: these gains and SIMC's."""
    names = [n for n in COMPARED if n in found.angle]
    with styled():
        figure, (above, below) = new_figure(2, 1, height=4.2, sharex=True, height_ratios=(1.3, 1.0))
        few, all_ = seen(found.time.size, 700), seen(found.time.size, 1600)
        for name in reversed(names):  # these gains on top
            look = controller_line("tuned" if name == COMPARED[0] else name) | {"label": name}
            above.plot(found.time[few], found.angle[name][few], **look)
            below.plot(found.time[all_], found.command[name][all_], **{**look, "linewidth": 0.9})
        above.axhline(found.reference, color=BLACK, linewidth=0.7, label="reference")
        for panel in (above, below):
            panel.axvline(MOMENT, color=GREY, linestyle=DOTTED, linewidth=1.1, label="load comes")
        above.set_ylabel("Angle [deg]")
        below.set(ylabel="Command [V]", xlabel="Time [s]", xlim=(0.0, found.time[-1]))
        figure.legend(*above.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def load_caption(found: LoadResponse) -> str:
    """What the load and the noise do, in numbers.

    >>> import numpy as np
    >>> x = {"these gains": np.zeros(2)}
    >>> one = {"these gains": 0.9}
    >>> load_caption(LoadResponse(1.0, 0.07, 15.0, np.zeros(2), x, x, one, one, one))[:59]
    'A load that shifts the angle by 1 deg comes at 1 s while th'
    """
    parts = [
        f"{name} within the settling band after {_seconds(found.returns_s[name])}, largest error "
        f"{number(found.deviation[name])} deg, {number(found.variation_V_s[name], 2)} V/s"
        for name in COMPARED
        if name in found.angle
    ]
    return (
        f"A load that shifts the angle by {number(found.load)} deg comes at {MOMENT:g} s while the nominal "
        f"plant holds {number(found.reference)} deg: {'; '.join(parts)}. Above: angle without noise. Below: "
        f"command with {number(found.noise)} deg of sensor noise; V/s: its total variation before the load."
    )


def _seconds(value: float) -> str:
    return "more than the run" if value == float("inf") else f"{value:.2f} s"
