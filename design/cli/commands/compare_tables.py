"""What ``wrist compare`` prints: tables of the comparison and of the contest."""

from math import isfinite
from typing import TYPE_CHECKING

from design.cli.common import seconds
from design.cli.terminal.screen import Sheet

if TYPE_CHECKING:
    from design.comparison.compare import Comparison, Standing
    from design.contest import Contest
    from design.contest.scores import Score

NONE = "–"
"""What is shown where there is no value, as in the pages."""

STANDING = (
    "controller", "Kp", "Ki", "settle\ns", "settle\n/bound", "over\n%", "IAE\ndeg s", "IAE\n/bound",
    "Ms", "delay\nms",
)  # fmt: skip
LEGEND = (
    "▲ limit broken; – not judged; /bound: largest ratio over the tasks to a lower bound",
    "~ dead time that an MPC tolerates in simulation",
)
SCORE = (
    "controller", "IAE\ndeg s", "difference\n95 %", "rank", "settle\ns", "95 % in\ns", "over\n%",
    "total var.\nV",
)  # fmt: skip


def table(comparison: "Comparison") -> list[object]:
    """A table for each motion, one row a controller; what breaks a limit carries a mark."""
    parts: list[object] = []
    for motion in dict.fromkeys(s.motion for s in comparison.standings):
        rows = tuple(_standing(s) for s in comparison.standings if s.motion == motion)
        parts += [Sheet(STANDING, rows, f"{motion}: gains, worst values over the tasks, and margins"), ""]
    return [*parts, *LEGEND, ""]


def _standing(s: "Standing") -> tuple[str, ...]:
    from reports.shared.glossary import BROKEN
    from reports.shared.names import name_of

    over = s.worst_overshoot_percent
    cells = (  # what each shows, and the limit that it may break
        (_short(s.Kp), ""),
        (_short(s.Ki), ""),
        (seconds(s.worst_settling_s).removesuffix(" s"), "steady_error_percent"),
        (_short(s.worst_settling_ratio), ""),
        (f"{over:.2g}" if over >= 0.05 else "0", "overshoot_percent"),
        (_short(s.worst_iae_deg_s), ""),
        (_short(s.worst_iae_ratio), ""),
        (_short(s.Ms), "Ms"),
        (_delay(s), "delay_margin_s"),
    )
    return (name_of(s.controller), *(text + (BROKEN if limit in s.breaks else " ") for text, limit in cells))


def _delay(s: "Standing") -> str:
    """The delay margin [ms], with a tilde where it is what a simulation tolerates."""
    if s.tolerated_delay_s is not None:
        return f"~{1000 * s.tolerated_delay_s:.0f}"
    return f"{1000 * s.delay_margin_s:.0f}" if isfinite(s.delay_margin_s) else NONE


def _short(value: float | None) -> str:
    return NONE if value is None or not isfinite(value) else f"{value:.3g}"


def contest_table(broad: "Contest") -> list[object]:
    """A table of the steps on the perturbed plants for each motion, and one for both at once."""
    from reports.comparison.contest.table import is_main

    parts: list[object] = []
    for motion, field, family in broad.tables:
        if is_main((motion, field, family)):
            scores = broad.of(motion, field, family)
            title = (
                f"{motion}: {family}, {scores[0].plants} plants ({field}), noisy sensor; "
                "difference of the IAE to the recommended PI"
            )
            parts += [Sheet(SCORE, tuple(_score(s, broad.reference) for s in scores), title), ""]
    return parts


def _score(s: "Score", reference: str) -> tuple[str, ...]:
    from design.contest.statistics import FEWEST
    from reports.shared.names import name_of

    i, (best, worst) = s.against["iae_deg_s"], s.ranks["iae_deg_s"]
    known = s.plants >= FEWEST  # fewer give neither interval nor rank
    return (
        name_of(s.controller),
        f"{s.mean['iae_deg_s']:.3g}",
        f"{i.low:+.2f} to {i.high:+.2f}" if known and s.controller != reference else NONE,
        NONE if not known else f"{best}" if best == worst else f"{best}-{worst}",
        f"{s.mean['settling_time_s']:.2f}",
        f"{s.settling_q95:.2f}",
        f"{s.mean['overshoot_percent']:.2g}",
        f"{s.mean['total_variation_V']:.3g}",
    )
