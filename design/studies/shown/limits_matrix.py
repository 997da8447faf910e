"""Limits by what they hold under: nominal, every branch, dead time, perturbed plants, worst case found.

And the steps that show it: the nominal one, behind the longest dead time, and the band of fresh cases.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from design.controllers.pi import PI
from design.evaluation.cases import Case, stack
from design.evaluation.runner import play
from design.evaluation.tasks import Task, tuning_tasks
from design.margins import LINEAR, branch_responses, margins, with_dynamics
from design.robustness.requirement import Requirement
from design.robustness.samples.draws import CASES, generator
from plants.simulation.disturbance import burdened

CONDITIONS = (
    "nominal",
    "every branch and memory",
    "longest dead time",
    "perturbed plants",
    "worst case found",
)
"""What limits are looked at under; each holds what the one before holds, and more, but for the last, which
is the one case that a search found."""

EVERY, SHOWN, SECONDS = 0.02, 400, 5.0
"""Time [s] between rows of the steps that are drawn, cases of their band, and how long [s] they are drawn at
least."""

LONGER = 1.2
"""Settling times of the nominal plant that they are drawn for, up to the duration of the task."""


def matrix(
    required: Requirement, controller: PI, evidence: Mapping[str, Any]
) -> list[dict[str, Any]]:  # fmt: skip
    """A row a limit: its name, the limit, and the value under each of `CONDITIONS`; None where that is no
    matter of it, as margins are of no single case."""
    late = required.space.dead_time
    calm, delayed = (_on_scenarios(required, controller, t) for t in (0.0, late))
    wrist = required.wrist
    plain, behind = (
        with_dynamics(branch_responses(w), required.box.weight)
        for w in (wrist, burdened(wrist, late or None, None))
    )
    linear = {
        "nominal": margins(plain[:1], controller),
        "every branch and memory": margins(plain, controller),
        "longest dead time": margins(behind, controller),
        "perturbed plants": required.margins(controller),
    }
    rows = []
    for name, limit in required.limits.named.items():
        if name in LINEAR:
            of = {c: float(m.values[name]) for c, m in linear.items()}
        else:
            of = {
                "nominal": float(calm[name][0]), "every branch and memory": float(calm[name].max()),
                "longest dead time": float(delayed[name].max()),
                "perturbed plants": _bounded(evidence["samples"]["worst"][name]),
                "worst case found": _bounded(evidence["worst_case"]["values"][name]),
            }  # fmt: skip
        values = {c: of.get(c) for c in CONDITIONS}
        held = {
            c: None if v is None else bool(v >= limit if name == "delay_margin_s" else v <= limit)
            for c, v in values.items()
        }
        rows.append({"limit": name, "bound": limit, "values": values, "held": held})
    return rows


def _bounded(value: float | None) -> float:
    """What a run was held against; a file has null for what is infinite, as the settling time of a run that
    never settles."""
    return float("inf") if value is None else value


def _on_scenarios(required: Requirement, controller: PI, dead_time: float) -> dict[str, Any]:
    """What limits are held against in the task's steps of the nominal plant, that from rest first."""
    asked = tuning_tasks(required.wrist.rig, required.duration)
    return play(stack(Case(t, required.wrist, dead_time=dead_time) for t in asked), controller).values


def step_band(required: Requirement, controller: PI, seed: int) -> dict[str, Any]:
    """Steps from rest over time [s] in the direction of the step [deg]: least and largest angle of fresh
    cases, the nominal plant's, and the same behind the longest dead time."""
    steps = replace(required, kinds=("step",))
    x = generator(3000 + seed, 0, CASES).random((steps.space.size, SHOWN))
    x = x[:, steps.space.reachable(x)]
    rig, step = required.wrist.rig, required.wrist.rig.task.step
    asked = Task("virgin", 0.0, (step,), (required.duration,))
    plain, late = (
        play(stack([Case(asked, required.wrist, dead_time=t)]), controller, record=True)
        for t in (0.0, required.space.dead_time)
    )
    assert plain.trajectory is not None
    assert late.trajectory is not None
    settled = max(float(p.metrics.settling_time_s.max()) for p in (plain, late))
    seconds = min(max(SECONDS, LONGER * settled), required.duration)
    lanes = replace(steps.space, duration=seconds).lanes(x)
    angle = play(lanes, controller, record=True).trajectory
    assert angle is not None
    sign = np.sign(lanes.reference.references[-1])
    rows = slice(0, round(seconds / rig.sample_time), max(round(EVERY / rig.sample_time), 1))
    seen = (angle.angle * sign)[rows]
    return {
        "time_s": angle.time[rows].tolist(), "low": seen.min(axis=1).tolist(),
        "high": seen.max(axis=1).tolist(), "nominal": plain.trajectory.angle[rows, 0].tolist(),
        "late": late.trajectory.angle[rows, 0].tolist(), "cases": int(x.shape[1]), "step": step,
        "dead_time_s": required.space.dead_time,
    }  # fmt: skip
