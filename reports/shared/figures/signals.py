"""The signals of one simulation over time: angle, pressure, command."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from plants.wrist import COMMAND_RANGE
from reports.shared.figures.style import BLACK, BLUE, DASHED, GREY, VERMILLION, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MODEL: dict[str, Any] = {"color": BLUE, "linestyle": "-"}
STATIC: dict[str, Any] = {"color": VERMILLION, "linestyle": DASHED, "linewidth": 1.2}
MEASURED: dict[str, Any] = {"color": BLACK, "linestyle": "-", "linewidth": 0.8, "alpha": 0.7}

ROWS: tuple[tuple[str, tuple[tuple[str, str, dict[str, Any]], ...]], ...] = (
    (
        "Angle [deg]",
        (
            ("measured_angle_deg", "measured", MEASURED),
            ("static_angle_deg", "static angle of the loop", STATIC),
            ("angle_deg", "model", MODEL),
        ),
    ),
    ("Pressure [kPa]", (("measured_pressure_kPa", "measured", MEASURED), ("pressure_kPa", "model", MODEL))),
    ("Command [V]", (("command_V", "command", MODEL),)),
)
"""Labels of the rows, and in each the signals by their keys."""


def draw(result: Mapping[str, Any], title: str = "", bounds: tuple[float, float] = COMMAND_RANGE) -> "Figure":
    """Signals over time: `result` holds ``time_s`` and some of the keys in `ROWS`, each (n,), or
    None for what was not logged.  A measured signal is drawn beneath the model's.  bounds [V]:
    of the command."""
    with styled():
        figure, axes = new_figure(3, 1, height=5.8, sharex=True, height_ratios=(4, 3, 2))
        for panel, (label, signals) in zip(axes, ROWS, strict=True):
            there = [(key, words, look) for key, words, look in signals if result.get(key) is not None]
            for key, words, look in there:
                panel.plot(result["time_s"], result[key], label=words, **look)
            panel.set_ylabel(label)
            if len(there) > 1:
                panel.legend(loc="best")
        axes[0].set_title(title)
        for bound in bounds:
            axes[2].axhline(bound, color=GREY, linewidth=0.8, linestyle=DASHED)
        axes[2].set(xlabel="Time [s]", xlim=(result["time_s"][0], result["time_s"][-1]))
    return figure
