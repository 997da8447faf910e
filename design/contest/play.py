"""Every controller on every plant and task of a field, in pieces that fit the memory."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from design.contest.coupled import run_coupled
from design.contest.periodic import play_coupled
from design.contest.plants import NOISE, PlantField
from design.contest.run import METRICS, Result, lanes_of, rests, run
from design.controllers.controller import Controller
from design.evaluation.runner import Lanes
from design.evaluation.tasks import Task, batch
from design.robustness.samples.conditions import Conditions
from design.robustness.samples.draws import generator
from plants.simulation.periodic import Periodic
from plants.simulation.sensor import HOLD, sensor

Array = NDArray[np.float64]

CHUNK = 480
"""Runs that go side by side: a multiple of the kernel's `LANES`, few enough for their noise to fit."""

WORST = ("settling_time_s", "unsettled", "overshoot_percent")
"""Metrics of which a plant's value is the worst over the tasks of a family; the mean of the others."""


def play(
    field: PlantField,
    controllers: Mapping[str, Controller | Periodic],
    asked: list[Task],
    conditions: Conditions,
    seed: int,
    jobs: int | None = None,
) -> dict[str, Result]:
    """Every controller on every plant of a field and every task, leaves of shape (plants, tasks).

    All controllers meet the same plants, rests and noise.
    """
    parts: dict[str, list[Result]] = {n: [] for n in controllers}
    pairs = [(i, j) for i in range(field.count) for j in range(len(asked))]
    for number, begin in enumerate(range(0, len(pairs), CHUNK)):
        piece = pairs[begin : begin + CHUNK]
        lanes = lanes_for(
            field, [i for i, _ in piece], [asked[j] for _, j in piece], conditions, seed, number
        )
        for name, controller in controllers.items():
            parts[name].append(run(lanes, controller, jobs)[0])
    shape = (field.count, len(asked))
    return {
        n: Result(*(np.concatenate([getattr(r, m) for r in of]).reshape(shape) for m in METRICS))
        for n, of in parts.items()
    }


def lanes_for(
    field: PlantField, which: list[int], asked: list[Task], conditions: Conditions, seed: int, chunk: int
) -> Lanes:
    """Plants and tasks lane by lane."""
    wrist = lanes_of(field.wrist, np.array(which, dtype=np.intp))
    state = rests(wrist, [t.start for t in asked], [t.angle for t in asked])
    loads = {
        "load-step.shift": np.array([t.load for t in asked]),
        "load-step.moment": np.array([t.judged_from for t in asked]),
    }
    rows = round(asked[0].duration / wrist.rig.sample_time) // HOLD
    noise = generator(seed, chunk, NOISE).standard_normal((rows, len(which)))
    lanes = batch(wrist.with_values(**loads), state, asked)
    return replace(lanes, sensor=sensor(conditions.noise, conditions.quantum), noise=noise)


def by_plant(played: Result, tasks_: list[int]) -> dict[str, Array]:
    """Each metric of each plant over some tasks, (plants,): the mean, or the worst."""
    found = {}
    for name in METRICS:
        values = getattr(played, name)[:, tasks_]
        found[name] = values.max(axis=1) if name in WORST else values.mean(axis=1)
    return found


def both_motions(
    pair: tuple[Controller | Periodic, Controller | Periodic],
    lanes: tuple[Lanes, Lanes],
    jobs: int | None,
) -> tuple[Result, Result]:
    """What two controllers of one kind make of two motions that move each other."""
    one, two = pair
    if isinstance(one, Periodic) and isinstance(two, Periodic):
        return play_coupled((one, two), lanes)
    assert not isinstance(one, Periodic)
    assert not isinstance(two, Periodic)
    return run_coupled((one, two), lanes, jobs)[0]
