"""An MPC in the loop: one plant, stepped and judged as `design.evaluation.steps.run` does it."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.evaluation.metrics import Metrics
from design.evaluation.runner import play, step_from
from design.mpc.fallback import Info, MPCState
from plants.errors import InputError
from plants.simulation.closed_loop import ClosedLoop, Trajectory
from plants.simulation.periodic import Periodic, prompt
from plants.simulation.sensor import PERFECT, Sensor
from plants.wrist import State, Wrist

Array = NDArray[np.float64]


class Play(NamedTuple):
    """A run: metrics, last states of plant with judge and of the controller, signals of every sample
    where they were recorded, and how each period went."""

    metrics: Metrics
    last: ClosedLoop
    controller: MPCState
    trajectory: Trajectory | None
    periods: list[Info]


def run(
    wrist: Wrist,
    controller: Periodic,
    reference: float,
    state: State | None = None,
    duration: float = 10.0,
    record: bool = False,
    sensor: Sensor = PERFECT,
    noise: Array | None = None,
    begin: float = 0.0,
    memory: Any = None,
) -> Play:
    """Step the reference [deg] at time 0 and run the loop for a duration [s].

    Metrics are those of `design.evaluation.steps.run`, leaves of shape (1,), and so is the trajectory.  The
    loop starts from `state` (the wrist's rest where not given), of which the controller sees angle and
    pressure; `memory`: its state where it has been acting before; noise: of the sensor, of standard deviation
    1, (rows, 1), as of `plants.simulation.periodic.PeriodicLoop`.  Raises InputError for a duration without a
    sample and for a wrist whose parameters are arrays.
    """
    if any(np.ndim(v) for v in wrist.values.values()):
        raise InputError("an MPC is played on one wrist at a time: give parameters that are numbers")
    at_rest = prompt(wrist).rest() if state is None else state
    lanes = replace(step_from(wrist, at_rest, reference, duration, begin), sensor=sensor, noise=noise)
    played = play(lanes, controller, None if memory is None else [memory], record)
    return Play(played.metrics, played.last, played.held[0], played.trajectory, played.periods)
