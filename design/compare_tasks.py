"""The tasks of the comparison, played and bounded: steps from every starting memory, and returns."""

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from design.controllers.controller import Controller, stacked
from design.limit import Limit, limit, limits_of
from design.loop import Trajectory, run
from design.metrics import Metrics
from design.tasks import STEP, Scenario
from plants import tree
from plants.errors import InputError
from plants.wrist import STARTS, State, Wrist

METRICS = tuple(f.name for f in fields(Metrics))

HOLD = 5.0
"""How long the first angle of a return step is held [s]."""


def task_scenarios(wrist: Wrist) -> list[Scenario]:
    """The 15 degree steps of one motion: both signs, from every starting memory."""
    return [Scenario(start, 0.0, sign * STEP, wrist) for sign in (1, -1) for start in STARTS]


def on_tasks(wrist: Wrist, alike: Sequence[Controller]) -> dict[str, list[Metrics]]:
    """Metrics by task, one for each of some controllers of one kind."""
    together, n = stacked(alike), len(alike)
    found: dict[str, list[Metrics]] = {}
    for s in task_scenarios(wrist):
        state = tree.like(wrist.rest(), [np.full(n, x) for x in tree.leaves(wrist.rest(s.start, s.angle))])
        judged, _, _ = run(wrist, together, np.full(n, s.reference), state)
        found[f"0 to {s.reference:+g} deg, {s.start}"] = [judged[i] for i in range(n)]
    for sign in (1, -1):
        _, held, _ = run(wrist, together, np.full(n, sign * STEP), duration=HOLD)
        judged, _, _ = run(wrist, together, np.zeros(n), held.plant, held.controller, begin=HOLD)
        found[f"return from {sign * STEP:+g} to 0 deg"] = [judged[i] for i in range(n)]
    return found


def bounds_on_tasks(wrist: Wrist, controller: Controller) -> dict[str, Limit]:
    """Lower bounds of the tasks, a return's from where the controller has left the wrist; none at all for a
    wrist that is not known to be monotone."""
    return _bounds(wrist, {s: run(wrist, controller, s * STEP, duration=HOLD)[1].plant for s in (1, -1)})


def _bounds(wrist: Wrist, left: dict[int, State]) -> dict[str, Limit]:
    try:
        found = limits_of(wrist)
        for sign, plant in left.items():
            state = tree.like(plant, [float(np.ravel(x)[0]) for x in tree.leaves(plant)])
            scenario = Scenario("line1" if sign > 0 else "line2", sign * STEP, 0.0, wrist)
            found[f"return from {sign * STEP:+g} to 0 deg"] = limit(scenario, state=state, begin=HOLD)
    except InputError:
        return {}
    return found


def played_on_tasks(
    wrist: Wrist, controller: Any
) -> tuple[dict[str, list[Metrics]], dict[str, Limit], Trajectory]:
    """Metrics and bounds by task, and the step from rest for drawing, of a controller that acts once a
    period, such as an MPC (`design.mpc.loop`)."""
    from design.mpc import loop

    found: dict[str, list[Metrics]] = {}
    drawn = None
    for s in task_scenarios(wrist):
        first = drawn is None
        played = loop.run(wrist, controller, s.reference, wrist.rest(s.start, s.angle), record=first)
        drawn = played.trajectory if first else drawn
        found[f"0 to {s.reference:+g} deg, {s.start}"] = [played.metrics[0]]
    left = {}
    for sign in (1, -1):
        there = loop.run(wrist, controller, sign * STEP, duration=HOLD)
        left[sign] = there.last.plant
        played = loop.run(wrist, controller, 0.0, left[sign], begin=HOLD, memory=there.controller)
        found[f"return from {sign * STEP:+g} to 0 deg"] = [played.metrics[0]]
    assert drawn is not None
    return found, _bounds(wrist, left), drawn


def together(one: Metrics, other: Metrics) -> Metrics:
    """Metrics of both motions at once: the later time, the larger overshoot and error, and the
    integrals and the travel of both added up.  The declared wrist couples the motions nowhere."""
    largest = ("rise_time_s", "settling_time_s", "overshoot_percent", "steady_state_error_deg")
    pairs = ((n, getattr(one, n), getattr(other, n)) for n in METRICS)
    return Metrics(*(max(a, b) if n in largest else a + b for n, a, b in pairs))


def later(bounds: Sequence[Limit | None]) -> Limit | None:
    """The bound of motions at once: the later settling, the errors added up."""
    known = [b for b in bounds if b is not None]
    if len(known) < len(bounds):
        return None
    return Limit(max(b.bound_s for b in known), sum(b.iae_bound for b in known))
