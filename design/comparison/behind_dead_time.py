"""Overshoot behind a growing dead time, by simulation, of controllers of any kind on one wrist.

Every step of the task is played, both signs from every initial hysteresis state; under a controller that acts
once a period, such as an MPC, whose runs take seconds, those from rest alone, and for a shorter time.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.comparison.tolerated import DURATION
from design.evaluation.cases import Case, stack
from design.evaluation.runner import play
from design.evaluation.tasks import Task
from plants.simulation.periodic import Periodic
from plants.wrist import STARTS, Start, Wrist

Array = NDArray[np.float64]

DEAD_TIMES = np.linspace(0.0, 0.1, 6)
"""Dead times [s] beside the plant's own; 50 ms is what rigs of this kind show."""

FROM_REST: tuple[Start, ...] = ("virgin",)
"""Initial states that a controller which acts once a period is played from."""


@dataclass(frozen=True)
class DeadTimeSweep:
    """What controllers do behind dead times [s] (n,) beside the plant's own: overshoot [%] (n,) of each, by
    name, the worst over the steps that were played; settles (n,): whether all of these settled within the
    run."""

    dead_times: Array
    overshoot: Mapping[str, Array]
    settles: Mapping[str, NDArray[np.bool_]]

    def rows(self) -> list[dict[str, Any]]:
        """The numbers, one record for each controller and dead time, for tables and JSON."""
        return [
            {
                "controller": name, "dead_time_s": float(late), "overshoot_percent": float(values[n]),
                "settles": bool(self.settles[name][n]),
            }
            for name, values in self.overshoot.items()
            for n, late in enumerate(self.dead_times)
        ]  # fmt: skip


def behind_dead_time(
    wrist: Wrist, controllers: Mapping[str, Any], dead_times: Array = DEAD_TIMES
) -> DeadTimeSweep:
    """Play controllers, by name, behind each of some dead times [s] (n,).

    >>> from design.controllers.pi import PI
    >>> found = behind_dead_time(Wrist.flexion(), {"PI": PI(2.3, 6.4)})
    >>> found.overshoot["PI"].shape, bool(found.settles["PI"].all())
    ((6,), True)
    """
    task = wrist.rig.task
    overshoot, settles = {}, {}
    for name, c in controllers.items():
        starts, lasts = (FROM_REST, DURATION) if isinstance(c, Periodic) else (STARTS, task.duration)
        cases = [
            Case(Task(start, 0.0, (sign * task.step,), (lasts,), "task band"), wrist, dead_time=float(late))
            for late in dead_times
            for start in starts
            for sign in (1.0, -1.0)
        ]
        values = play(stack(cases), c).values
        overshoot[name] = values["overshoot_percent"].reshape(dead_times.size, -1).max(axis=1)
        settling = values["settling_time_s"].reshape(dead_times.size, -1)
        settles[name] = np.isfinite(np.asarray(settling.max(axis=1)))
    return DeadTimeSweep(dead_times, overshoot, settles)
