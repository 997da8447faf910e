"""An MPC in the loop: one plant, stepped and judged as `design.loop.run` does it."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design import metrics
from design.metrics import Metrics
from design.mpc.fallback import Info
from design.mpc.fallback import State as MPCState
from plants.errors import InputError
from plants.simulation import periodic
from plants.simulation.closed_loop import ClosedLoop, Trajectory, recorded, trajectory
from plants.simulation.periodic import Periodic
from plants.simulation.reference_profile import ReferenceProfile
from plants.simulation.sensor import Sensor
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
    sensor: Sensor = Sensor(),  # noqa: B008  (a value)
    noise: Array | None = None,
    begin: float = 0.0,
    memory: Any = None,
) -> Play:
    """Step the reference [deg] at time 0 and play the loop for a duration [s], a whole number of periods.

    Metrics are those of `design.loop.run`, leaves of shape (1,), and so is the trajectory.  The loop
    starts from `state` (the wrist's rest where not given), of which the controller sees angle and pressure;
    `memory`: its state where it has been acting before; noise: of the sensor, of standard deviation 1, (rows,
    1), as of `plants.simulation.periodic.PeriodicLoop`.  Raises
    InputError for a duration that is no number of periods and for a wrist whose parameters are arrays.
    """
    if any(np.ndim(v) for v in wrist.values.values()):
        raise InputError("an MPC is played on one wrist at a time: give parameters that are numbers")
    at_rest = periodic.prompt(wrist).rest() if state is None else state
    judge, profile = (
        metrics.of_step(at_rest.angle, reference, wrist.rig.sample_time),
        ReferenceProfile((reference,)),
    )
    first = periodic.begin(
        wrist, controller, at_rest, profile, judge, duration, 1, sensor, noise, begin,
        None if memory is None else [memory],
    )  # fmt: skip
    last, rows = periodic.play(first, recorded(first.loop) if record else ())
    judged = judge.finish(last.loop.judge, len(last.commands))
    went = trajectory(rows, at_rest, first.c.plant, wrist.rig.sample_time, begin) if record else None
    return Play(judged, last.loop, last.memories[0], went, last.periods)
