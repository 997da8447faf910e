"""Every controller on every plant and task of a field, in pieces that fit the memory."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from design.contest.coupled import run_coupled
from design.contest.periodic import play_coupled
from design.contest.plants import NOISE, PlantField
from design.controllers.controller import Controller
from design.evaluation.cases import lanes_of, on_lanes
from design.evaluation.runner import Lanes, PlayedTask
from design.evaluation.runner import play as play_lanes
from design.evaluation.tasks import STAIRS, Task
from design.robustness.samples.conditions import Conditions
from design.robustness.samples.draws import generator
from plants.simulation.periodic import Periodic
from plants.simulation.sensor import HOLD, sensor

Array = NDArray[np.float64]

CHUNK = 480
"""Runs that go side by side: a multiple of the kernel's `LANES`, few enough for their noise to fit."""

METRICS = (
    "iae_deg_s", "settling_time_s", "unsettled", "overshoot_percent", "total_variation_V",
    "pressure_travel_kPa",
)  # fmt: skip
"""What is told of a run, see `told`."""

WORST = ("settling_time_s", "unsettled", "overshoot_percent")
"""Metrics of which a plant's value is the worst over the tasks of a family; the mean of the others."""


def play(
    field: PlantField,
    controllers: Mapping[str, Controller | Periodic],
    asked: list[Task],
    conditions: Conditions,
    seed: int,
    jobs: int | None = None,
) -> dict[str, dict[str, Array]]:
    """Every controller on every plant of a field and every task: each metric, (plants, tasks), by controller.

    All controllers meet the same plants, rests and noise.
    """
    parts: dict[str, list[dict[str, Array]]] = {n: [] for n in controllers}
    pairs = [(i, j) for i in range(field.count) for j in range(len(asked))]
    for number, begin in enumerate(range(0, len(pairs), CHUNK)):
        piece = pairs[begin : begin + CHUNK]
        lanes = lanes_for(
            field, [i for i, _ in piece], [asked[j] for _, j in piece], conditions, seed, number
        )
        for name, controller in controllers.items():
            parts[name].append(told(play_lanes(lanes, controller, jobs=jobs)))
    shape = (field.count, len(asked))
    return {
        n: {m: np.concatenate([r[m] for r in of]).reshape(shape) for m in METRICS} for n, of in parts.items()
    }


def told(played: PlayedTask) -> dict[str, Array]:
    """What is told of runs that were judged stair by stair, by name, each (lanes,): the settling time is the
    slowest stair's, the whole window where one is not settled before the next or the end, which `unsettled`
    (0 or 1) says; overshoot is relative to the step of the rig's task."""
    m = played.metrics
    settling = np.where(m.unsettled, played.lanes.duration, m.settling_time_s)
    values = (
        m.iae_deg_s, settling, m.unsettled.astype(float), m.overshoot_percent, m.total_variation_V,
        played.pressure_travel_kPa,
    )  # fmt: skip
    return dict(zip(METRICS, values, strict=True))


def lanes_for(
    field: PlantField, which: list[int], asked: list[Task], conditions: Conditions, seed: int, chunk: int
) -> Lanes:
    """Plants and tasks lane by lane."""
    # As many references for all, so that one compiled loop serves them.
    lanes = on_lanes(lanes_of(field.wrist, np.array(which, np.intp)), asked, longest=len(STAIRS))
    noise = generator(seed, chunk, NOISE).standard_normal((lanes.samples // HOLD, len(which)))
    return replace(lanes, sensor=sensor(conditions.noise, conditions.quantum), noise=noise)


def by_plant(played: Mapping[str, Array], tasks_: list[int]) -> dict[str, Array]:
    """Each metric of each plant over some tasks, (plants,): the mean, or the worst."""
    found = {}
    for name in METRICS:
        values = played[name][:, tasks_]
        found[name] = values.max(axis=1) if name in WORST else values.mean(axis=1)
    return found


def both_motions(
    pair: tuple[Controller | Periodic, Controller | Periodic],
    lanes: tuple[Lanes, Lanes],
    jobs: int | None,
) -> tuple[PlayedTask, PlayedTask]:
    """What two controllers of one kind make of two motions that move each other."""
    one, two = pair
    if isinstance(one, Periodic) and isinstance(two, Periodic):
        return play_coupled((one, two), lanes)
    assert not isinstance(one, Periodic)
    assert not isinstance(two, Periodic)
    return run_coupled((one, two), lanes, jobs)[0]
