"""The closed loop: controller and wrist, sampled together, judged while it runs.

The controller, any that `controllers.controller` describes, sees what the sensors show; the judge sees the
joint.  The two differ where the wrist has effects that sit in its sensor, such as a drift.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design import metrics
from design.controllers.controller import Controller, Measured
from design.metrics import Metrics, Tally, Yardstick
from plants import tree
from plants import wrist as plant
from plants.effects.effect import Around
from plants.simulate import run_lanes
from plants.wrist import SAMPLE_TIME, SampledWrist, State, Wrist

Number = Any
Array = NDArray[np.float64]


class Loop(NamedTuple):
    """State of plant, controller and judge."""

    plant: State
    controller: Any
    tally: Tally


class SampledLoop(NamedTuple):
    """Coefficients of plant, controller and judge."""

    plant: SampledWrist
    controller: Any
    yardstick: Yardstick


def step(s: Loop, inputs: tuple[Number, ...], c: SampledLoop) -> Loop:
    """One sample: measure, control, judge by the true angle, move.

    `inputs` holds the index of the sample and, for a wrist with effects, its time
    [s]; the other motion rests.
    """
    around = Around(*inputs[1:])
    seen = plant.read(s.plant, c.plant, around)
    measured = Measured(c.yardstick.reference - seen, seen, s.plant.pressure)
    controller, command = c.controller.act(s.controller, measured)
    tally = metrics.update(s.tally, inputs[0], s.plant.angle, command, c.yardstick)
    return Loop(plant.step(s.plant, command, c.plant, around), controller, tally)


@dataclass(frozen=True)
class Trajectory:
    """Signals of closed loops, shape (samples, lanes): time [s] (samples,), angle of the joint
    and static angle [deg], pressure [kPa], command [V], and what the sensor shows [deg]."""

    time: Array
    angle: Array
    static_angle: Array
    pressure: Array
    command: Array
    measured: Array


def holding(wrist: Wrist, controller: Controller, state: State, begin: float = 0.0) -> Any:
    """The state of a controller that holds the wrist still at the pressure of `state`, at a time [s]."""
    seen = plant.read(state, wrist.sampled(), Around(begin))
    measured = Measured(0.0, seen, state.pressure)
    return controller.holding(state.pressure * controller.gain / wrist.regulator.gain, measured)


def run(
    wrist: Wrist,
    controller: Controller,
    reference: Number,
    state: State | None = None,
    held: Any = None,
    duration: float = 10.0,
    record: bool = False,
    jobs: int | None = None,
    begin: float = 0.0,
) -> tuple[Metrics, Loop, Trajectory | None]:
    """Step the reference [deg] at time 0 and run the loop for a duration [s].

    Parameters, settings, references and states may be arrays, one entry per lane.
    The loop starts from `state` (the wrist's rest where not given), the
    controller holding it, at the time `begin` [s], which matters to effects that
    depend on it alone.  Returns metrics with leaves of shape (lanes,), of the true
    angle, the last state, and where `record` is true the signals of every sample.
    What is under way in a delay line is no part of the state: a loop that goes on
    from the last state of another starts with its last command everywhere in the tube.

    >>> from plants import Wrist
    >>> from design.controllers.pi import PI
    >>> judged, _, _ = run(Wrist.flexion(), PI(1.2, 2.2), 15.0)
    >>> float(judged.settling_time_s[0].round(2)), float(judged.overshoot_percent[0].round(2))
    (5.59, 0.58)
    """
    samples = round(duration / SAMPLE_TIME)
    state = wrist.rest() if state is None else state
    if held is None:
        held = holding(wrist, controller, state, begin)
    command = controller.command(held)
    c = SampledLoop(wrist.sampled(), controller.sampled(), metrics.yardstick(state.angle, reference))
    loop = Loop(state, held, metrics.begin(command))
    signals = tuple(n for n in tree.names(loop) if n.startswith("plant.")) + ("tally.command",)
    times = {"time": begin + np.arange(samples) * SAMPLE_TIME} if wrist.effects else {}
    last, rows = run_lanes(
        step, loop, c, samples, times, inputs=("sample", *times), every=int(record),
        record=signals if record else (), jobs=jobs,
    )  # fmt: skip
    trajectory = None
    if record:
        # The command of a row is given after its measurement: it stands in the row after.
        given = np.concatenate([rows[-1, 1:], rows[-1, -1:]])
        time = np.asarray(np.arange(rows.shape[1]) * SAMPLE_TIME, float)
        went = tree.like(state, rows[:-1])
        seen = plant.read(went, c.plant, Around(begin + time[:, None]))
        trajectory = Trajectory(time, went.angle, went.memory.h, went.pressure, given, seen)
    return metrics.finish(last.tally, samples), last, trajectory
