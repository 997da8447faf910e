"""Steps of the reference in the closed loop (`plants.simulation.closed_loop`), judged while they run."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from design import metrics
from design.controllers.controller import Controller
from design.metrics import Metrics
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
from plants.simulation.reference_profile import ReferenceProfile
from plants.simulation.sensor import Sensor
from plants.wrist import State, Wrist

__all__ = ["Trajectory", "holding", "run", "step_loop"]

Number = Any
Array = NDArray[np.float64]


def step_loop(
    wrist: Wrist,
    controller: Controller,
    reference: Number,
    state: State,
    held: Any = None,
    sensor: Sensor = Sensor(),  # noqa: B008  (a value)
) -> tuple[ClosedLoop, SampledClosedLoop]:
    """First state and coefficients of a loop whose reference [deg] steps at time 0; `held`: state of the
    controller, which holds the wrist where not given."""
    held = holding(wrist, controller, state) if held is None else held
    dt = wrist.rig.sample_time
    judge = metrics.of_step(state.angle, reference, dt)
    profile = ReferenceProfile((reference,))
    c = SampledClosedLoop(wrist.sampled(), controller.sampled(dt), profile, judge, sensor)
    return ClosedLoop(state, held, judge.begin(controller.command(held))), c


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
) -> tuple[Metrics, ClosedLoop, Trajectory | None]:
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
    samples = round(duration / wrist.rig.sample_time)
    state = wrist.rest() if state is None else state
    held = holding(wrist, controller, state, begin) if held is None else held
    first, c = step_loop(wrist, controller, reference, state, held)
    names = recorded(first) if record else ()
    last, rows = advance(
        first, c, samples, clock(wrist, samples, begin), every=int(record), record=names, jobs=jobs
    )
    went = trajectory(rows, state, c.plant, wrist.rig.sample_time, begin) if record else None
    return c.judge.finish(last.judge, samples), last, went
