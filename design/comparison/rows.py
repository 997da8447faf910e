"""Rows of a comparison: one controller on one task, and where it stands on a motion."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from design.comparison.on_tasks import METRICS

TUNED = "tuned"
WITHOUT_DEAD_TIME = "PI tuned without dead time"
PAPER = "paper"
FORWARD = "feedforward"


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
    designed, of one that neither tuning nor a rule gave; worst ratios to the lower bounds over the tasks;
    tolerated_delay_s, tolerated_gain: of an MPC what it tolerates in simulation
    (`design.comparison.tolerated`); its delay is judged by the smaller of that and its margin at rest.  Else
    None.
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
    tolerated_delay_s: float | None = None
    tolerated_gain: float | None = None


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
