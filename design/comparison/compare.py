"""Controllers x tasks -> one table: the tuned PI beside the paper's, textbook rules and other designs.

The other designs (`design.alternatives`) are made under the limits and on the scenarios that the tuned PI
was tuned on.  Everything is simulated under the same command range and sampling, from the same states,
and stands beside the lower bound of its task (`design.limit`).  The paper's gains are a stand-in, so its
rows carry the range that the metrics take over the range of those gains, and no verdict is given that
would change within it.  What happens on other plants is `design.contest`'s business.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from design.alternatives.designs import Design, design_others, design_record
from design.comparison.on_tasks import (
    METRICS,
    OnTasks,
    later,
    on_tasks,
    played_on_tasks,
    step_cases,
    together,
)
from design.comparison.rows import FORWARD, PAPER, TUNED, Row, Standing, row_record
from design.comparison.tolerated import tolerated
from design.controllers.controller import Controller
from design.controllers.feedforward import Feedforward
from design.controllers.pi import PI
from design.controllers.reference_model import no_inverse
from design.controllers.registry import REGISTERED
from design.evaluation.metrics import Metrics
from design.evaluation.steps import Trajectory
from design.evaluation.tasks import Task, comparison_tasks
from design.evaluation.tasks import steps as step_tasks
from design.input_loop import command_margins
from design.limit import Limit, ratios
from design.mpc.margins_at_rest import Replaceable, margins_at_rest
from design.synthesis.requirements import ROUNDING, Limits, default_problem
from design.synthesis.tuning_rules import baselines, paper_range
from plants.rig import Rig, built_in_rig
from plants.simulation.periodic import Periodic
from plants.wrist import Wrist

__all__ = [
    "FORWARD", "METRICS", "PAPER", "TUNED", "Comparison", "Row", "Standing", "compare",
    "controllers", "on_tasks", "row_record", "step_cases", "together",
]  # fmt: skip


@dataclass(frozen=True)
class Comparison:
    """Rows of the table, standings, and the step of each motion and controller for drawing; the other
    designs by motion and name, and why one is lacking; the rig."""

    rows: tuple[Row, ...]
    standings: tuple[Standing, ...]
    steps: Mapping[tuple[str, str], Trajectory]
    limits: Limits
    designs: Mapping[tuple[str, str], Design | str] = field(default_factory=dict)
    rig: Rig = field(default_factory=built_in_rig)


def controllers(
    wrist: Wrist,
    tuned: PI,
    designs: Mapping[str, Design | str] | None = None,
    more: Mapping[str, Controller] | None = None,
) -> dict[str, list[Controller]]:
    """Controllers by name, each a list: one, or the range of the paper's, the stand-in first.  A
    feedforward is among them where the wrist has an inverse, and whoever is registered
    (`design.controllers.register`); `more`: further ones."""
    named: dict[str, list[Controller]] = {TUNED: [tuned]}
    named |= {n: [r.make(wrist)] for n, r in REGISTERED.items()}
    named |= {n: [c] for n, c in (more or {}).items()}
    named |= {n: [d.controller] for n, d in (designs or {}).items() if not isinstance(d, str)}
    named |= {FORWARD: [Feedforward.of(wrist)]} if no_inverse(wrist) is None else {}
    named |= {name: [pi] for name, pi in baselines(wrist).items()}
    named[PAPER] = [PI.of(wrist, Kp, Ki) for Kp, Ki in paper_range()]
    return named


def _row(motion: str, task: Task, name: str, judged: list[Metrics], bound: Limit | None) -> Row:
    table = {n: [float(getattr(m, n)) for m in judged] for n in METRICS}
    to_bound = ratios(judged[0], bound) if bound else None
    return Row(
        motion, task.name, name,
        {n: v[0] for n, v in table.items()},
        {n: min(v) for n, v in table.items()},
        {n: max(v) for n, v in table.items()},
        task.id,
        *((float(to_bound.settling), float(to_bound.iae)) if to_bound else (None, None)),
    )  # fmt: skip


def compare(
    wrists: Mapping[str, Wrist],
    tuned: Mapping[str, PI],
    limits: Limits | None = None,
    designs: Mapping[str, Mapping[str, Design | str]] | None = None,
    more: Mapping[str, Mapping[str, Controller]] | None = None,
    periodic: Mapping[str, Mapping[str, Any]] | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Comparison:
    """Run every controller on every task of each motion, and of two motions at once.

    `wrists` and `tuned` map a motion's name to its wrist and its tuned PI.  `designs` are what
    `design_others` made of each motion; they are made here, on the declared scenarios, where not given.
    `more`: further controllers
    of each motion, by name; `periodic`: those that act once a period, such as an MPC; `progress` is told
    who plays and the share of the motion that is done.
    """
    limits = limits or Limits.of(next(iter(wrists.values())).rig)
    tell = progress or (lambda stage, share: None)
    if designs is None:
        designs = {m: design_others(default_problem(w, limits)) for m, w in wrists.items()}
    rows: list[Row] = []
    standings: list[Standing] = []
    steps: dict[tuple[str, str], Trajectory] = {}
    done: dict[tuple[str, str], OnTasks] = {}
    for motion, wrist in wrists.items():
        others, slow = designs.get(motion, {}), (periodic or {}).get(motion, {})
        named = controllers(wrist, tuned[motion], others, (more or {}).get(motion))
        entrants: dict[str, list[Any]] = {**named, **{n: [c] for n, c in slow.items()}}
        for place, (name, alike) in enumerate(entrants.items()):
            tell(f"{motion}, {name}", place / len(entrants))
            found = done[motion, name] = played_on_tasks(wrist, alike)
            steps[motion, name] = found.trajectory
            own = [
                _row(motion, t, name, found.metrics[t.id], found.bounds[t.id] if found.bounds else None)
                for t in comparison_tasks(wrist.rig)
            ]
            made = design_record(others[name]) if name in others else {}
            standings.append(_standing(motion, name, wrist, alike[0], own, limits, made))
            rows += own
    if len(wrists) == 2:
        one, other = wrists
        for name in (n for m, n in done if m == one and (other, n) in done):
            a, b = done[one, name], done[other, name]
            for t in (t for t in step_tasks(wrists[one].rig) if t.start == "virgin"):
                both = [together(x, y) for x, y in zip(a.metrics[t.id], b.metrics[t.id], strict=True)]
                slowest = later(a.bounds[t.id], b.bounds[t.id]) if a.bounds and b.bounds else None
                rows.append(_row("both at once", t, name, both, slowest))
    return Comparison(
        tuple(rows), tuple(standings), steps, limits,
        {(m, n): d for m, of in designs.items() for n, d in of.items()}, next(iter(wrists.values())).rig,
    )  # fmt: skip


def _standing(
    motion: str,
    name: str,
    wrist: Wrist,
    controller: Controller,
    rows: Sequence[Row],
    limits: Limits,
    design: Mapping[str, Any],
) -> Standing:
    at_rest = margins_at_rest(controller, [wrist]) if isinstance(controller, Replaceable) else None
    Ms, delay = (at_rest.Ms, at_rest.delay_margin_s) if at_rest else command_margins(wrist, controller)
    worst = {n: max(r.metrics[n] for r in rows) for n in METRICS}
    held = {
        "overshoot_percent": worst["overshoot_percent"],
        "Ms": Ms,
        "total_variation_V": worst["total_variation_V"],
        "steady_error_percent": 100.0 * worst["steady_state_error_deg"] / wrist.rig.task.step,
    }
    breaks = [n for n, v in held.items() if n in limits.named and v > limits.named[n] * ROUNDING]
    borne = tolerated(wrist, controller) if isinstance(controller, Periodic) else None
    late = delay if borne is None else float(np.fmin(delay, borne.delay_s))
    if "delay_margin_s" in limits.named and late < limits.named["delay_margin_s"] / ROUNDING:
        breaks.append("delay_margin_s")
    pi = getattr(controller, "pi", None)
    Kp, Ki = (pi.Kp, pi.Ki) if pi is not None else (None, None)
    ratios_ = [[getattr(r, n) for r in rows] for n in ("settling_ratio", "iae_ratio")]
    return Standing(
        motion, name, Kp, Ki, Ms, delay, worst["overshoot_percent"], worst["settling_time_s"],
        worst["iae_deg_s"], tuple(breaks), _settings(controller), design,
        *(None if None in values else max(values) for values in ratios_),
        *((borne.delay_s, borne.gain) if borne is not None else ()),
    )  # fmt: skip


def _settings(controller: Any) -> dict[str, float]:
    """Settings by name: all of a controller's, and of an MPC those of its problem that are numbers."""
    of = controller.problem if hasattr(controller, "problem") else controller
    found = dict(getattr(of, "settings", None) or vars(of))
    for part in ("weights", "observer"):
        if part in found:
            found |= {f"{part}.{n}": v for n, v in vars(found[part]).items()}
    return {n: float(v) for n, v in found.items() if isinstance(v, int | float | np.number | np.ndarray)}
