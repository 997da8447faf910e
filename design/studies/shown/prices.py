"""What each guarantee costs: gains that are tuned for ever more of it, judged on the same tasks.

    nominal              the nominal plant's step from rest
    memory and corners   every starting memory, on the plant and eight corners of it
    dead time            the same behind the longest dead time, which is in Ms and Mt too
    worst case found     the whole requirement, as far as a search and samples can tell
    proved               those of them for which a certificate is found

Every row is judged on the task's steps of the requirement: the same plants, memories, loads and dead
times.  The ratio to the lower bound is that of the IAE on the nominal plant behind the longest dead time,
known to the bound: a dead time adds at least itself to any settling time, and the whole step over it to any
IAE.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.alternatives.designs import excess_of
from design.controllers.controller import sensors_of
from design.evaluation.cases import Case, stack
from design.evaluation.runner import play
from design.evaluation.tasks import steps as step_tasks
from design.limit import limits_of
from design.robustness.requirement import Requirement
from design.status import Status
from design.studies.designs import BARE
from design.synthesis.requirements import Problem, default_problem, late_problem
from design.synthesis.structure import with_gains
from design.synthesis.tuning import Region, tune
from plants.errors import InputError
from plants.simulation.disturbance import burdened

Array = NDArray[np.float64]
Tell = Callable[[str, float], None]
TASKS = 3000
"""Places that the task's steps are taken from, the same for every row."""

GUARANTEES = {BARE: "without the residual"}
"""What a design was tuned to hold, where that is not the worst case that a search finds."""

POINTS = 20
"""Points of the map, in each gain, of a row that is not tuned elsewhere."""


@dataclass(frozen=True)
class Tasks:
    """The task's steps of a requirement as places (size, n), and lower bounds of the IAE [deg s] of the steps
    from rest behind the longest dead time, by task; None where the bound is not known to hold."""

    requirement: Requirement
    places: Array
    bounds: dict[str, float] | None

    @classmethod
    def of(cls, requirement: Requirement) -> "Tasks":
        """The steps of a requirement: half of them on corners of its box, drawn the same every time."""
        space = requirement.space
        x = np.random.default_rng(1).random((space.size, TASKS))
        x[: len(space.box.intervals), ::2] = np.round(x[: len(space.box.intervals), ::2])
        x = x[:, space.of_task(x)]
        return cls(requirement, x[:, space.reachable(x)], _bounds(requirement))

    def row(self, controller: Any, jobs: int | None = None) -> dict[str, Any]:
        """Worst IAE and settling of a controller on the tasks, its largest excess over the limits there, and
        the ratio to the lower bound."""
        values = self.requirement.run(self.places, controller, jobs=jobs)
        return {
            "worst_iae_deg_s": float(values["iae_deg_s"].max()),
            "worst_settling_s": float(values["settling_time_s"].max()),
            "worst_overshoot_percent": float(values["overshoot_percent"].max()),
            "ratio_to_bound": self.ratio(controller, jobs),
        }

    def ratio(self, controller: Any, jobs: int | None = None) -> float | None:
        """The largest IAE over its bound of the steps from rest on the nominal plant behind the longest dead
        time."""
        if self.bounds is None:
            return None
        wrist, asked = self.requirement.wrist, self.requirement
        tasks = step_tasks(wrist.rig)
        late = asked.space.dead_time
        cases = [
            Case(replace(t, holds=(asked.duration,), judged="task band"), wrist, dead_time=late)
            for t in tasks
        ]
        found = play(stack(cases), controller, jobs=jobs).metrics.iae_deg_s
        return float(max(v / self.bounds[t.id] for v, t in zip(found, tasks, strict=True)))


def _bounds(requirement: Requirement) -> dict[str, float] | None:
    late = requirement.space.dead_time or None
    try:
        return {k: v.iae_bound for k, v in limits_of(burdened(requirement.wrist, late, None)).items()}
    except InputError:
        return None


def simpler(requirement: Requirement, jobs: int | None = None) -> dict[str, Problem]:
    """Tuning problems that ask for less than the requirement, by the guarantee that they give; the residual
    of the plant is in none of them."""
    wrist, limits = requirement.wrist, replace(requirement.limits, WT=None)
    cost = requirement.cost
    found = {
        "nominal": default_problem(wrist, replace(limits, delay_margin_s=None), cost, True, jobs),
        "memory and corners": default_problem(wrist, limits, cost, jobs=jobs),
    }
    if requirement.space.dead_time > 0.0:
        late = requirement.space.dead_time
        found["dead time"] = late_problem(wrist, limits, cost, late, requirement.duration, jobs)
    return found


def price_rows(
    requirement: Requirement,
    designs: Mapping[str, Mapping[str, Any]],
    jobs: int | None = None,
    progress: Tell | None = None,
) -> list[dict[str, Any]]:
    """Rows of the guarantees that are less than the whole requirement, each with the gains of its own
    tuning; then those of all of it, a row for each of the designs, records by controller."""
    tell, tasks = progress or (lambda stage, share: None), Tasks.of(requirement)

    def row(guarantee: str, controller: str, gains: Any, feasible: bool, cost: float) -> dict[str, Any]:
        asked = {"guarantee": guarantee, "controller": controller, "gains": gains, "feasible": feasible}
        made = with_gains(requirement.wrist, gains)
        asked["sensors"] = list(sensors_of(made))
        return {**asked, "own_worst_iae_deg_s": cost, **tasks.row(made, jobs)}

    rows = []
    problems = simpler(requirement, jobs)
    for number, (guarantee, problem) in enumerate(problems.items()):
        tell(f"price of: {guarantee}", number / len(problems))
        found = tune(problem, Region.of(problem.wrist, POINTS), 1)
        gains = {"Kp": found.Kp, "Ki": found.Ki, "b": 1.0, "Tf": 0.0}
        rows.append(row(guarantee, "PI", gains, found.feasible, float(found.at.cost[0])))
    for name, design in designs.items():
        guarantee = GUARANTEES.get(name, "worst case found")
        rows.append(row(guarantee, name, design["gains"], in_its_cases(design), design["cost"]))
    return rows


def in_its_cases(design: Mapping[str, Any]) -> bool:
    """Whether a design, a record, breaks no limit in the cases of its tuning, no guard counted.

    >>> in_its_cases({"holds": False, "worst_excess": -0.02}), in_its_cases({"holds": False})
    (True, False)
    """
    excess = excess_of(design)
    return bool(design["holds"]) or (excess is not None and excess <= 0.0)


def proved_row(rows: list[dict[str, Any]], best: str, proved: Mapping[str, Any]) -> dict[str, Any]:
    """The row of the recommended controller once more, empty where its gains are not proved."""
    last = {**next(r for r in reversed(rows) if r["controller"] == best), "guarantee": "proved"}
    if proved["status"] == Status.PROVED.value:
        return last
    gone = dict.fromkeys(
        ("gains", "worst_iae_deg_s", "worst_settling_s", "worst_overshoot_percent", "ratio_to_bound",
         "own_worst_iae_deg_s")
    )  # fmt: skip
    return {**last, **gone, "feasible": False}
