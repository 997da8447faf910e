"""What PIs do when a load comes while they hold the reference, and what sensor noise does to the command."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from design.evaluation.cases import Case, stack
from design.evaluation.runner import play
from design.evaluation.tasks import Task
from design.robustness.samples.conditions import Conditions
from design.robustness.samples.draws import generator
from plants.effects.wrist.load_step import LoadStep
from plants.simulation.closed_loop import Trajectory
from plants.simulation.sensor import HOLD, sensor
from plants.wrist import Wrist

Array = NDArray[np.float64]
MOMENT, SECONDS = 1.0, 8.0
"""When the load comes, and how long the run is [s]."""
STREAM = 5000
"""Of the random numbers of the noise."""


@dataclass(frozen=True)
class LoadResponse:
    """Runs on the nominal plant, at rest at the task's step until the load comes.

    load [deg]: shift of the static angle; noise [deg]: standard deviation of the sensor's noise; reference
    [deg]; time [s]; angle [deg]: by controller, without noise; command [V]: by controller, with noise;
    deviation [deg]: largest, by controller; returns_s: time from the load until the angle stays within the
    task's band, infinite where it does not within the run; variation_V_s: total variation of the command by
    noise alone, per second.
    """

    load: float
    noise: float
    reference: float
    time: Array
    angle: Mapping[str, Array]
    command: Mapping[str, Array]
    deviation: Mapping[str, float]
    returns_s: Mapping[str, float]
    variation_V_s: Mapping[str, float]


def load_response(wrist: Wrist, controllers: Mapping[str, PI], seed: int = 0) -> LoadResponse | None:
    """Play the load step of the rig's file under some PIs; None for a rig without loads, or a plant that has
    a load step of its own.

    >>> found = load_response(Wrist.flexion(), {"PI": PI(2.3, 6.4)})
    >>> found.load, round(found.deviation["PI"], 2)
    (1.0, 0.9)
    """
    asked, task = Conditions.of(wrist.rig), wrist.rig.task
    if not asked.load or any(e.NAME == LoadStep.NAME for e in wrist.effects):
        return None
    held = Task("line1", task.step, (task.step,), (SECONDS,), "task band", asked.load, MOMENT)
    lane = stack([Case(held, wrist)])
    rows = round(SECONDS / wrist.rig.sample_time) // HOLD + 2
    drawn = generator(seed, 0, STREAM).standard_normal((rows, 1)) if asked.noise else None
    seen = replace(lane, sensor=sensor(asked.noise, asked.quantum), noise=drawn)
    calm = {n: _signals(play(lane, c, record=True).trajectory) for n, c in controllers.items()}
    noisy = {n: _signals(play(seen, c, record=True).trajectory) for n, c in controllers.items()}
    time = next(iter(calm.values())).time
    error = {n: np.abs(t.angle[:, 0] - task.step) for n, t in calm.items()}
    before = time < MOMENT
    return LoadResponse(
        asked.load, asked.noise, task.step, time,
        {n: t.angle[:, 0] for n, t in calm.items()}, {n: t.command[:, 0] for n, t in noisy.items()},
        {n: float(e.max()) for n, e in error.items()},
        {n: _returns(time, e, task.band * task.step) for n, e in error.items()},
        {n: float(np.abs(np.diff(t.command[before, 0])).sum()) / MOMENT for n, t in noisy.items()},
    )  # fmt: skip


def _signals(of: Trajectory | None) -> Trajectory:
    assert of is not None
    return of


def _returns(time: Array, error: Array, band: float) -> float:
    """From the load until the error stays within a band [s]."""
    outside = np.flatnonzero(error > band)
    if outside.size == 0:
        return 0.0
    return float(time[outside[-1] + 1] - MOMENT) if outside[-1] + 1 < time.size else float("inf")
