"""Steps of PIs from every initial hysteresis state, and their overshoot behind a growing dead time."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from design.evaluation.sequence import PlayedSequence, Sequence, play
from plants.wrist import STARTS, Wrist

Array = NDArray[np.float64]
DEAD_TIMES = np.linspace(0.0, 0.1, 11)
"""Dead times [s] beside the plant's own; 50 ms is what rigs of this kind show."""

SECONDS = 3.0
"""How long [s] steps are drawn."""


@dataclass(frozen=True)
class BranchSteps:
    """What PIs do on the nominal plant.

    controllers: by name, the one that is judged first; steps: of each the task's step from every state of
    `plants.wrist.STARTS`, as lanes, with its trajectory; dead_times [s], and overshoot [%] of each behind
    them, the worst over both signs and every state, not a number where the loop does not settle.
    """

    controllers: Mapping[str, PI]
    steps: Mapping[str, PlayedSequence]
    dead_times: Array
    overshoot: Mapping[str, Array]


def branch_steps(wrist: Wrist, controllers: Mapping[str, PI]) -> BranchSteps:
    """Play the steps of some PIs on a wrist.

    >>> found = branch_steps(Wrist.flexion(), {"PI": PI(2.3, 6.4)})
    >>> found.overshoot["PI"].shape
    (11,)
    """
    task = wrist.rig.task
    shown = [Sequence(s, 0.0, (task.step,), (SECONDS,), wrist) for s in STARTS]
    lanes = [
        Sequence(s, 0.0, (sign * task.step,), (task.duration,), wrist, float(late))
        for late in DEAD_TIMES
        for s in STARTS
        for sign in (1.0, -1.0)
    ]
    steps, overshoot = {}, {}
    for name, c in controllers.items():
        steps[name] = play(shown, c, record=True)
        values = play(lanes, c, task_band=True).values
        late = np.where(np.isfinite(values["settling_time_s"]), values["overshoot_percent"], np.nan)
        overshoot[name] = late.reshape(DEAD_TIMES.size, -1).max(axis=1)  # one that does not settle spoils all
    return BranchSteps(controllers, steps, DEAD_TIMES, overshoot)
