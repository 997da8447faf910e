"""Rows of a comparison: one controller on one task, where it stands on a motion, and what they say."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from design.compare_tasks import METRICS

TUNED = "tuned"
PAPER = "paper"
FORWARD = "feedforward"
NEAREST = "what stands as tuned is only the nearest there is."
"""How the verdict on a motion ends of which no gains hold every limit."""


@dataclass(frozen=True)
class Row:
    """One controller on one task, which has a name for people and an id (`design.evaluation.tasks`).

    `low` and `high` bound each metric over the range of the
    paper's gains; they equal `metrics` for every other controller.  The ratios are those of `metrics` to
    the lower bounds of the task, None where there is no such bound."""

    motion: str
    task: str
    controller: str
    metrics: Mapping[str, float]
    low: Mapping[str, float]
    high: Mapping[str, float]
    task_id: str
    settling_ratio: float | None = None
    iae_ratio: float | None = None


@dataclass(frozen=True)
class Standing:
    """A controller's margins on one motion, the worst over branches and rates, of a PI by python-control
    (a feedforward stands outside the loop: alone it has no margin to lose), and which of the limits it
    breaks (margins, and overshoot on the tasks).

    Kp, Ki: None of a controller that has others; settings: all of its settings by name; design: what was
    designed, of one that neither tuning nor a rule gave; worst ratios to the lower bounds over the tasks.
    """

    motion: str
    controller: str
    Kp: float | None
    Ki: float | None
    Ms: float
    delay_margin_s: float
    worst_overshoot_percent: float
    worst_settling_s: float
    worst_iae_deg_s: float
    breaks: tuple[str, ...]
    settings: Mapping[str, float] = field(default_factory=dict)
    design: Mapping[str, Any] = field(default_factory=dict)
    worst_settling_ratio: float | None = None
    worst_iae_ratio: float | None = None


def verdicts(
    rows: list[Row], standings: list[Standing], refusals: Mapping[str, str] | None = None
) -> list[str]:
    """What the table says, one sentence a motion; a comparison with the paper's PI only where the
    whole range of its gains agrees."""
    said = []
    for motion in {s.motion: None for s in standings}:
        if refusals and motion in refusals:
            said.append(f"{motion}: {refusals[motion]}; {NEAREST}")
            continue
        of = {s.controller: s for s in standings if s.motion == motion}
        ours = max(r.high["settling_time_s"] for r in rows if (r.motion, r.controller) == (motion, TUNED))
        theirs = [r for r in rows if (r.motion, r.controller) == (motion, PAPER)]
        low = max(r.low["settling_time_s"] for r in theirs)
        high = max(r.high["settling_time_s"] for r in theirs)
        if ours < low:
            against = "ahead of the paper's PI over the whole range of its gains"
        elif ours > high:
            against = "behind the paper's PI over the whole range of its gains"
        else:
            against = "not to be ranked against the paper's PI, whose gains are not known well enough"
        rules = [s for n, s in of.items() if n not in (TUNED, PAPER)]
        broken = [s.controller for s in rules if s.breaks]
        tail = f"; {', '.join(broken)} break the limits" if broken else ""
        said.append(
            f"{motion}: the tuned PI settles the worst 15 degree task in {_seconds(ours)} "
            f"(paper's stand-in {_seconds(low)} to {_seconds(high)}), {against}{tail}."
        )
    return said


def _seconds(value: float) -> str:
    return f"{value:.2f} s" if np.isfinite(value) else "more than 10 s"


def row_record(row: Row) -> dict[str, Any]:
    """A row as a flat record for CSV and JSON; what is infinite becomes None."""

    def finite(v: float) -> float | None:
        return v if np.isfinite(v) else None

    record: dict[str, Any] = {"motion": row.motion, "task": row.task, "controller": row.controller}
    record["task_id"] = row.task_id
    for n in METRICS:
        record[n] = finite(row.metrics[n])
    for n in METRICS:
        record[f"{n}_low"], record[f"{n}_high"] = finite(row.low[n]), finite(row.high[n])
    for name, ratio in (("settling_ratio", row.settling_ratio), ("iae_ratio", row.iae_ratio)):
        record[name] = None if ratio is None else finite(ratio)
    return record
