"""Steps of the reference in the closed loop (`plants.simulation.closed_loop`), judged while they run."""

from typing import Any

from design.controllers.controller import Controller
from design.evaluation.metrics import Metrics
from design.evaluation.runner import play, step_from
from plants.simulation.closed_loop import ClosedLoop, Trajectory, holding
from plants.wrist import State, Wrist

__all__ = ["Trajectory", "holding", "run"]

Number = Any


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
    The content of a delay line is not part of the state: a loop continued from the last state of another
    starts with its last command throughout the delay.

    >>> from plants import Wrist
    >>> from design.controllers.pi import PI
    >>> judged, _, _ = run(Wrist.flexion(), PI(1.2, 2.2), 15.0)
    >>> float(judged.settling_time_s[0].round(2)), float(judged.overshoot_percent[0].round(2))
    (5.59, 0.58)
    """
    state = wrist.rest() if state is None else state
    lanes = step_from(wrist, state, reference, duration, begin)
    played = play(lanes, controller, held, record, jobs=jobs)
    return played.metrics, played.last, played.trajectory
