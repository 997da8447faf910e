"""Steps of PIs from every initial hysteresis state, and their overshoot behind a growing dead time."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from design.comparison.behind_dead_time import DeadTimeSweep, behind_dead_time
from design.controllers.pi import PI
from design.evaluation.cases import Case, stack
from design.evaluation.runner import PlayedTask, play
from design.evaluation.tasks import Task
from plants.wrist import STARTS, Wrist

DEAD_TIMES = np.linspace(0.0, 0.1, 11)
"""Dead times [s] of the sweep: PIs alone are played, which takes no time."""

SECONDS = 3.0
"""How long [s] steps are drawn."""


@dataclass(frozen=True)
class BranchSteps:
    """What PIs do on the nominal plant.

    controllers: by name, the one that is judged first; steps: of each the task's step from every state of
    `plants.wrist.STARTS`, as lanes, with its trajectory; late: their overshoot behind dead times.
    """

    controllers: Mapping[str, PI]
    steps: Mapping[str, PlayedTask]
    late: DeadTimeSweep


def branch_steps(wrist: Wrist, controllers: Mapping[str, PI]) -> BranchSteps:
    """Play the steps of some PIs on a wrist.

    >>> found = branch_steps(Wrist.flexion(), {"PI": PI(2.3, 6.4)})
    >>> found.late.overshoot["PI"].shape
    (11,)
    """
    shown = stack(Case(Task(s, 0.0, (wrist.rig.task.step,), (SECONDS,)), wrist) for s in STARTS)
    steps = {name: play(shown, c, record=True) for name, c in controllers.items()}
    return BranchSteps(controllers, steps, behind_dead_time(wrist, controllers, DEAD_TIMES))
