"""The tasks of the comparison, played and bounded: steps from every starting memory, and returns."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from design.controllers.controller import Controller, stacked
from design.evaluation.cases import Case
from design.evaluation.metrics import Metrics
from design.evaluation.runner import PlayedTask, play, step_from
from design.evaluation.steps import Trajectory
from design.evaluation.tasks import Task, comparison_tasks, steps
from design.limit import Limit, limit, limits_of
from plants.errors import InputError
from plants.kernel import pytrees
from plants.simulation.periodic import Periodic
from plants.wrist import State, Wrist

METRICS = tuple(f.name for f in fields(Metrics))

DRAWN = "step+virgin"
"""The task whose signals are kept for drawing."""


@dataclass(frozen=True)
class OnTasks:
    """What some controllers of one kind do: metrics by the task's id, one for each of them; lower bounds by
    id, a return's from where the first of them has left the wrist, None for a wrist that is not known to be
    monotone; the signals of the first in the task `DRAWN`."""

    metrics: dict[str, list[Metrics]]
    bounds: dict[str, Limit] | None
    trajectory: Trajectory


def step_cases(wrist: Wrist) -> list[Case]:
    """The steps of the task on one motion: both signs, from every starting memory."""
    return [Case(t, wrist) for t in steps(wrist.rig)]


def on_tasks(wrist: Wrist, alike: Sequence[Controller | Periodic]) -> dict[str, list[Metrics]]:
    """Metrics by the task's id, one for each of some controllers of one kind."""
    return {t.id: _each(play_task(wrist, alike, t)[0], len(alike)) for t in comparison_tasks(wrist.rig)}


def played_on_tasks(wrist: Wrist, alike: Sequence[Controller | Periodic]) -> OnTasks:
    """What some controllers of one kind do on every task, and what no controller could do better."""
    played = {t.id: play_task(wrist, alike, t, t.id == DRAWN) for t in comparison_tasks(wrist.rig)}
    drawn = played[DRAWN][0].trajectory
    assert drawn is not None
    first = Trajectory(drawn.time, *(x[:, :1] for n, x in vars(drawn).items() if n != "time"))
    begun = {t: state for t, (_, state) in played.items()}
    return OnTasks({t: _each(p, len(alike)) for t, (p, _) in played.items()}, _bounds(wrist, begun), first)


def play_task(
    wrist: Wrist, alike: Sequence[Controller | Periodic], task: Task, record: bool = False
) -> tuple[PlayedTask, State]:
    """The last step of a task under controllers of one kind, lanes of one batch, and the state that it begins
    from: rest, or where the references before it have led.  A step is begun as if the command had been what
    the controller holds."""
    controller: Any = alike[0] if len(alike) == 1 else stacked(alike)
    state, held = wrist.rest(task.start, task.angle), None
    for reference, moment, duration in task.stages:
        before = state
        played = play(step_from(wrist, state, reference, duration, moment), controller, held, record)
        state, held = played.last.plant, played.held
    return played, before


def _each(played: PlayedTask, count: int) -> list[Metrics]:
    return [played.metrics[i] for i in range(count)]


def _bounds(wrist: Wrist, begun: dict[str, State]) -> dict[str, Limit] | None:
    """Bounds by the task's id, of tasks of several stages from the states at which the last begins."""
    try:
        found = limits_of(wrist)
        for task in comparison_tasks(wrist.rig):
            if len(task.stages) > 1:
                here = [float(np.ravel(x)[0]) for x in pytrees.leaves(begun[task.id])]
                state = pytrees.like(begun[task.id], here)
                found[task.id] = limit(Case(task, wrist), state=state, begin=task.stages[-1][1])
    except InputError:
        return None
    return found


def together(one: Metrics, other: Metrics) -> Metrics:
    """Metrics of both motions at once: the later time, the larger overshoot and error, and the
    integrals and the travel of both added up.  The declared wrist couples the motions nowhere."""
    largest = ("rise_time_s", "settling_time_s", "overshoot_percent", "steady_state_error_deg")
    pairs = ((n, getattr(one, n), getattr(other, n)) for n in METRICS)
    return Metrics(*(max(a, b) if n in largest else a + b for n, a, b in pairs))


def later(one: Limit, other: Limit) -> Limit:
    """The bound of motions at once: the later settling, the errors added up."""
    return Limit(max(one.bound_s, other.bound_s), one.iae_bound + other.iae_bound)
