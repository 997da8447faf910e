"""What ``wrist compare`` prints: tables of the comparison and of the contest, 80 columns wide."""

from math import isfinite
from typing import TYPE_CHECKING

from design.cli.common import seconds

if TYPE_CHECKING:
    from design.compare import Comparison
    from design.contest import Contest


def table(comparison: "Comparison") -> list[object]:
    """A table for each motion, one row a controller; what breaks a limit carries a mark."""
    from rich.table import Table

    headings = (
        "controller", "Kp", "Ki", "settle\ns", "settle\n/bound", "over\n%", "IAE\ndeg s", "IAE\n/bound",
        "Ms", "delay\nms",
    )  # fmt: skip
    parts: list[object] = []
    for motion in {s.motion: None for s in comparison.standings}:
        one = Table(
            title=f"{motion}: gains, worst values over the tasks, and margins",
            title_justify="left",
            box=None,
            pad_edge=False,
            padding=(0, 1, 0, 0),
        )
        for heading in headings:
            one.add_column(heading, justify="left" if heading == "controller" else "right", no_wrap=True)
        for s in comparison.standings:
            if s.motion != motion:
                continue
            over = s.worst_overshoot_percent
            cells = {
                "": _short(s.Kp),
                " ": _short(s.Ki),
                "steady_error_percent": seconds(s.worst_settling_s).removesuffix(" s"),
                "  ": _short(s.worst_settling_ratio),
                "overshoot_percent": f"{over:.2g}" if over >= 0.05 else "0",
                "   ": _short(s.worst_iae_deg_s),
                "    ": _short(s.worst_iae_ratio),
                "Ms": _short(s.Ms),
                "delay_margin_s": f"{1000 * s.delay_margin_s:.0f}" if isfinite(s.delay_margin_s) else "-",
            }
            one.add_row(s.controller, *(text + ("!" if n in s.breaks else " ") for n, text in cells.items()))
        parts += [one, ""]
    return [*parts, "! beyond its limit; /bound: largest ratio over the tasks to what none can beat", ""]


def _short(value: float | None) -> str:
    return "-" if value is None or not isfinite(value) else f"{value:.3g}"


def contest_table(broad: "Contest") -> list[object]:
    """A table of the steps on the perturbed plants for each motion, and one for both at once."""
    from rich.table import Table

    from design.contest.scores import BOTH

    headings = (
        "controller", "IAE\ndeg s", "less tuned PI's\n95 %", "rank", "settle\ns", "95 % in\ns",
        "over\n%", "travel\nV",
    )  # fmt: skip
    parts: list[object] = []
    for motion, field, family in broad.tables:
        if family != "steps" or not (field.startswith("perturbed plants") or motion == BOTH):
            continue
        scores = broad.of(motion, field, family)
        one = Table(
            title=f"{motion}: {family}, {scores[0].plants} plants ({field}), noisy sensor",
            title_justify="left",
            box=None,
            pad_edge=False,
            padding=(0, 1, 0, 0),
        )
        for heading in headings:
            one.add_column(heading, justify="left" if heading == "controller" else "right", no_wrap=True)
        for s in scores:
            i, (best, worst) = s.against["iae_deg_s"], s.ranks["iae_deg_s"]
            one.add_row(
                s.controller,
                f"{s.mean['iae_deg_s']:.3g}",
                "-" if s.controller == broad.reference else f"{i.low:+.2f} to {i.high:+.2f}",
                f"{best}" if best == worst else f"{best}-{worst}",
                f"{s.mean['settling_time_s']:.2f}",
                f"{s.settling_q95:.2f}",
                f"{s.mean['overshoot_percent']:.2g}",
                f"{s.mean['total_variation_V']:.3g}",
            )
        parts += [one, ""]
    return parts
