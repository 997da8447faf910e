"""The runner: plants and tasks side by side, one a lane, played by any kind of controller.

A controller either acts in every sample, and is compiled with the plant, or once a period
(`plants.simulation.periodic`); plants, sensors, noise and judge are the same for both.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Controller
from design.evaluation.metrics import Metrics, Yardstick, of_step
from design.evaluation.scaled import scaled
from plants.kernel import pytrees
from plants.simulation import periodic
from plants.simulation.closed_loop import (
    ClosedLoop,
    SampledClosedLoop,
    Trajectory,
    advance,
    clock,
    holding,
    recorded,
    trajectory,
)
from plants.simulation.periodic import Periodic
from plants.simulation.reference_profile import ReferenceProfile
from plants.simulation.sensor import HOLD, PERFECT, Sensor
from plants.wrist import State, Wrist

Number = Any
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Lanes:
    """What is to be played, leaves floats or arrays (lanes,): wrists and the states that they start from,
    reference profiles, judge, duration [s], the sensor and its noise of standard deviation 1 (rows, lanes), a
    row for every 10 samples; time of the start [s], for effects that depend on it; pressure of the other
    motion [kPa] (samples, lanes), at rest where not given; a reference that was logged [deg] (samples,), in
    place of the profiles; samples that each lane asks for, (lanes,), where they need not go on to the end."""

    wrist: Wrist
    state: State
    reference: ReferenceProfile
    judge: Yardstick
    duration: float
    sensor: Sensor = PERFECT
    noise: Array | None = None
    begin: float = 0.0
    other_pressure: Array | None = None
    logged: Array | None = None
    lasts: NDArray[np.intp] | None = None

    @property
    def dt(self) -> float:
        """Sample time [s]."""
        return self.wrist.rig.sample_time

    @property
    def samples(self) -> int:
        """Samples of a run."""
        return round(self.duration / self.dt)

    @property
    def count(self) -> int:
        """Number of lanes."""
        leaves = [*pytrees.leaves((self.state, self.reference, self.judge)), *self.wrist.values.values()]
        return max(np.size(x) for x in leaves)

    def loop(self, controller: Controller, held: Any = None) -> tuple[ClosedLoop, SampledClosedLoop]:
        """First state and coefficients of the loop; `held`: the controller's state, which holds the plants
        where not given."""
        held = holding(self.wrist, controller, self.state, self.begin) if held is None else held
        tally = self.judge.begin(controller.command(held), self.state.angle)
        c = SampledClosedLoop(
            self.wrist.sampled(), controller.sampled(self.dt), self.reference, self.judge, self.sensor
        )
        return ClosedLoop(self.state, held, tally), c


@dataclass(frozen=True)
class PlayedTask:
    """What became of `lanes`: metrics, leaves (lanes,); the last state; the controller's, of one that acts
    once a period a list of each lane's; where they were asked for the signals of every sample, and rows of
    some; what a periodic controller told of each period."""

    lanes: Lanes
    metrics: Metrics
    last: ClosedLoop
    held: Any
    trajectory: Trajectory | None
    rows: Array
    periods: list[Any]

    @property
    def start(self) -> Array:
        """The true angle [deg] where the step that is judged began, (lanes,)."""
        began = self.lanes.judge.step or self.last.judge.step
        return np.broadcast_to(began.start, self.metrics.iae_deg_s.shape)

    @property
    def size(self) -> Array:
        """The size [deg] of that step, (lanes,)."""
        return np.asarray(np.abs(self.lanes.reference.references[-1] - self.start), float)

    @property
    def values(self) -> dict[str, Array]:
        """What limits and cost are held against, by name, each (lanes,), see `scaled`."""
        return scaled(self.metrics, self.size, self.lanes.wrist.rig.task.step)

    @property
    def pressure_travel_kPa(self) -> Array:
        """Travel of the pressure [kPa], which is the air that was moved, of lanes that are judged stair by
        stair, (lanes,)."""
        return np.asarray(self.last.judge.stairs.travel, float)

    @property
    def reference(self) -> Array:
        """The reference [deg] in every sample of the trajectory, (samples, lanes)."""
        assert self.trajectory is not None
        asked = self.lanes.reference.at(np.arange(len(self.trajectory.time))[:, None]).reference
        return np.broadcast_to(np.asarray(asked, float), self.trajectory.angle.shape)


def step_from(
    wrist: Wrist, state: State, reference: Number, duration: float = 10.0, begin: float = 0.0
) -> Lanes:
    """A step to a reference [deg] at time 0, from where the wrist is, for a duration [s], begun at a time
    [s]."""
    judge = of_step(state.angle, reference, wrist.rig)
    return Lanes(wrist, state, ReferenceProfile((reference,)), judge, duration, begin=begin)


def play(
    lanes: Lanes,
    controller: Controller | Periodic,
    held: Any = None,
    record: bool = False,
    signals: tuple[str, ...] = (),
    every: int = 1,
    jobs: int | None = None,
) -> PlayedTask:
    """Play a controller, whose settings may be arrays of lanes where it acts in every sample.

    record: all signals of every sample; signals: rows of some instead, such as ``plant.angle``, after every
    `every` samples (of a periodic controller, every sample, its last period cut short where the duration is
    no whole number of them).  Raises InputError for a duration without a sample.
    """
    if isinstance(controller, Periodic):
        return _play_periodic(lanes, controller, held, record, signals)
    first, c = lanes.loop(controller, held)
    names = recorded(first) if record else signals
    own = {} if lanes.noise is None or not lanes.sensor.noise else {"noise": lanes.noise}
    hold = HOLD
    if lanes.other_pressure is not None:  # another value in every sample
        own = {n: np.repeat(x, HOLD, axis=0)[: lanes.samples] for n, x in own.items()}
        own["other_pressure"], hold = lanes.other_pressure - lanes.wrist.rig.rest_pressure, 1
    times = clock(lanes.wrist, lanes.samples, lanes.begin)
    times |= {} if lanes.logged is None else {"reference": lanes.logged}
    samples = lanes.samples if lanes.lasts is None or names or own else lanes.lasts
    last, rows = advance(first, c, samples, times, own, hold, every if names else 0, names, jobs)
    went = trajectory(rows, lanes.state, c.plant, lanes.dt, lanes.begin) if record else None
    judged = c.judge.finish(last.judge, lanes.samples)
    return PlayedTask(lanes, judged, last, last.controller, went, rows, [])


def _play_periodic(
    lanes: Lanes, controller: Periodic, held: Any, record: bool, signals: tuple[str, ...]
) -> PlayedTask:
    first = begun(lanes, controller, held)
    last, rows = periodic.play(first, recorded(first.loop) if record else signals)
    went = trajectory(rows, lanes.state, first.c.plant, lanes.dt, lanes.begin) if record else None
    return ended(lanes, last, rows, went)


def ended(
    lanes: Lanes, last: periodic.PeriodicLoop, rows: Array, went: Trajectory | None = None
) -> PlayedTask:
    """What became of lanes under a periodic controller."""
    judged = lanes.judge.finish(last.loop.judge, lanes.samples)
    return PlayedTask(lanes, judged, last.loop, last.memories, went, rows, last.periods)


def begun(lanes: Lanes, controller: Periodic, held: Any = None) -> periodic.PeriodicLoop:
    """The loop of a periodic controller before its first period."""
    return periodic.begin(
        lanes.wrist, controller, lanes.state, lanes.reference, lanes.judge, lanes.duration, lanes.count,
        lanes.sensor, lanes.noise, lanes.begin, held,
    )  # fmt: skip
