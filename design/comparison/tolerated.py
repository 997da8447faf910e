"""How much dead time, and how much more gain of the plant, a loop tolerates: by simulation, for controllers
that have no linear law whose margins could be told, such as an MPC.

The loop is played from the plant's rest in the task's step, with ever more of either, by bisection on a
grid; it tolerates what it still settles with.  That is no margin of linear theory: a loop that rings down too
slowly counts as broken, and one that is broken by some dead time might settle again with more.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from design.evaluation.runner import play, step_from
from plants.simulation.disturbance import burdened
from plants.wrist import Wrist

DELAY_STEP, DELAYS = 0.005, 40
"""Grid of dead times [s], and how many there are: up to 0.2 s."""

GAIN_STEP, GAINS = 1.05, 28
"""Grid of factors of the regulator's gain, and how many there are: up to 3.9."""

DURATION = 5.0
"""Time [s] within which the step has to settle."""


@dataclass(frozen=True)
class Tolerated:
    """The longest dead time [s] beside the plant's own and the largest factor of the plant's gain [1] with
    which the step from rest still settles; 0 dead time where it does not settle at all."""

    delay_s: float
    gain: float


def tolerated(wrist: Wrist, controller: Any, duration: float = DURATION) -> Tolerated:
    """What a controller, of any kind, tolerates on a wrist, in steps from rest of a duration [s].

    >>> from design.controllers.pi import PI
    >>> found = tolerated(Wrist.flexion(), PI(2.0, 6.0))
    >>> found.delay_s, round(found.gain, 2)
    (0.2, 3.92)
    """

    def late(steps: int) -> bool:
        return settles(burdened(wrist, DELAY_STEP * steps or None, None), controller, duration)

    def strong(steps: int) -> bool:
        gain = float(wrist.regulator.gain) * GAIN_STEP**steps
        return settles(wrist.with_values(gain=gain), controller, duration)

    return Tolerated(DELAY_STEP * _most(late, DELAYS), GAIN_STEP ** _most(strong, GAINS))


def settles(wrist: Wrist, controller: Any, duration: float) -> bool:
    """Whether the step of the task from rest settles within a duration [s]."""
    lanes = step_from(wrist, wrist.rest(), wrist.rig.task.step, duration)
    return bool(np.isfinite(play(lanes, controller).metrics.settling_time_s).all())


def _most(bears: Callable[[int], bool], count: int) -> int:
    """The most steps that are tolerated, up to a count; 0 where none is, or not even 0."""
    if bears(count):
        return count
    low, high = 0, count
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if bears(middle) else (low, middle)
    return low
