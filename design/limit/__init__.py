"""The limit: how fast a step can be settled, and how small its IAE can be, whatever the controller.

Given a plant and commands of 0 to 4 V at 1 ms there is a lower bound of either (`design.limit.bound`),
cheap enough for every comparison, and on request a trajectory that comes close to it
(`design.limit.optimal`), of which only what the exact simulator makes of it counts
(`design.limit.replay`).  A controller's ratio to the bound says what is left to be gained.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from design.evaluation.cases import Case
from design.evaluation.metrics import Metrics
from design.evaluation.tasks import comparison_tasks
from design.limit.bound import Bound, bound
from design.limit.optimal import optimal
from design.limit.replay import Array, CommandReplay, replay
from plants.errors import InputError
from plants.wrist import State, Wrist

__all__ = [
    "Bound",
    "CommandReplay",
    "Limit",
    "Ratios",
    "bound",
    "limit",
    "limits_of",
    "optimal",
    "ratios",
    "replay",
]


@dataclass(frozen=True)
class Limit:
    """Lower bounds of a task, and where asked for the replays of two trajectories: `fastest` settles as
    soon, `least` has as small an IAE as was found.

    bound_s [s] may be infinite, where the band is out of reach; iae_bound [deg s].  What is achieved is
    None without trajectories, and a gap is what is achieved over the bound, less one.
    """

    bound_s: float
    iae_bound: float
    fastest: CommandReplay | None = None
    least: CommandReplay | None = None

    @property
    def achieved_s(self) -> float | None:
        """Settling time [s] of the fastest replay."""
        return None if self.fastest is None else float(self.fastest.metrics.settling_time_s)

    @property
    def iae_achieved(self) -> float | None:
        """IAE [deg s] of the replay that has the least."""
        return None if self.least is None else float(self.least.metrics.iae_deg_s)

    @property
    def gap(self) -> float | None:
        """Settling time achieved over its bound, less one."""
        return None if self.achieved_s is None else self.achieved_s / self.bound_s - 1.0

    @property
    def commands(self) -> Array | None:
        """Commands [V] of the fastest replay, one per sample of 1 ms."""
        return None if self.fastest is None else self.fastest.commands

    @property
    def trajectory(self) -> CommandReplay | None:
        """The fastest replay."""
        return self.fastest


@dataclass(frozen=True)
class Ratios:
    """Settling time and IAE over their lower bounds, floats or arrays of lanes: 1 cannot be beaten."""

    settling: Any
    iae: Any


def limit(case: Case, trajectory: bool = False, state: State | None = None, begin: float = 0.0) -> Limit:
    """The limit of the last step of a case, with trajectories where asked for, which takes seconds.

    state: where the wrist is not at rest when it begins, but moving, such as a controller leaves it
    before a return step; its angle is then what the step starts from.  begin [s]: time of
    the start, for effects that depend on it.  Raises InputError for a wrist that is not known to
    be monotone and a step of no size, and with trajectories for a wrist with effects other than a dead
    time and a reference that is out of reach.

    >>> from design.evaluation.tasks import Task
    >>> found = limit(Case(Task("virgin", 0.0, (15.0,)), Wrist.deviation()))
    >>> found.bound_s, round(found.iae_bound, 3), found.achieved_s
    (0.267, 2.286, None)
    """
    wrist, step = case.wrist, case.task.last
    r, start = step.reference, wrist.rest(step.start, step.angle) if state is None else state
    found = bound(wrist, r, start, begin)
    if not trajectory:
        return Limit(found.settling_s, found.iae)
    fastest = optimal(wrist, r, start, found, "settling", begin)
    least = optimal(wrist, r, start, found, "iae", begin)
    return Limit(found.settling_s, found.iae, fastest, least)


def limits_of(wrist: Wrist, trajectory: bool = False) -> dict[str, Limit]:
    """Limits of the tasks of a comparison, by their ids: the 15 degree steps from every
    starting memory, and the returns, which start here from rest on the line that was arrived on.

    Kept for the next call with the same wrist.  Raises InputError as `limit` does.

    >>> list(limits_of(Wrist.flexion()))[0]
    'step+virgin'
    """
    if any(np.ndim(v) for v in wrist.values.values()):
        raise InputError("limit: the wrist has arrays as parameters; ask for one lane at a time")
    return dict(_limits_of(wrist, trajectory))


@cache
def _limits_of(wrist: Wrist, trajectory: bool) -> dict[str, Limit]:
    return {t.id: limit(Case(t, wrist), trajectory) for t in comparison_tasks(wrist.rig)}


def ratios(metrics: Metrics, of: Limit) -> Ratios:
    """A controller's settling time and IAE over the bounds of the task that it was judged on; infinite
    where it, or anything, does not settle.

    >>> from design.evaluation.steps import run
    >>> from design.evaluation.tasks import Task
    >>> from design.controllers.pi import PI
    >>> wrist = Wrist.flexion()
    >>> judged, _, _ = run(wrist, PI(1.2, 2.2), 15.0)
    >>> found = ratios(judged, limit(Case(Task("virgin", 0.0, (15.0,)), wrist)))
    >>> round(float(found.settling[0]), 1), round(float(found.iae[0]), 2)
    (21.8, 11.68)
    """
    settled = np.isfinite(metrics.settling_time_s)
    settling = np.where(settled, metrics.settling_time_s, np.inf) / (
        of.bound_s if np.isfinite(of.bound_s) else 1.0
    )
    return Ratios(settling, np.asarray(metrics.iae_deg_s) / of.iae_bound)
