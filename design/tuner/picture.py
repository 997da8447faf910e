"""What the tuner shows of one setting: responses from every starting memory, margins, limits."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from design.evaluation.cases import Case
from design.evaluation.metrics import Metrics
from design.evaluation.runner import play
from design.synthesis.evaluate import Evaluation, controller, evaluate
from design.synthesis.requirements import LIMIT_UNITS, ROUNDING, Problem
from design.tuner.branch_margins import BranchMargins, branch_margins
from design.tuner.case import TunedPlant
from design.tuner.setting import Setting
from plants.rig import Rig

Array = NDArray[np.float64]

ROWS = np.unique(
    np.concatenate([np.arange(0.0, 0.2, 0.001), np.arange(0.2, 0.5, 0.003), np.arange(0.5, 1.0001, 0.01)])
)
"""What is shown of a run, as shares of it, (rows,): dense where a step moves, coarse at its end."""


def shown_samples(rig: Rig) -> NDArray[np.intp]:
    """The samples of a run of a rig's task that are shown, (rows,).

    >>> from plants.rig import built_in_rig
    >>> shown_samples(built_in_rig())[[0, 1, -2, -1]].tolist()
    [0, 10, 9900, 10000]
    """
    return np.unique(np.round(ROWS * round(rig.task.duration / rig.sample_time)).astype(np.intp))


@dataclass(frozen=True)
class ShownStep:
    """A step of the task: its case, the way gone towards the reference [deg] and the command [V], each
    (rows,), settling time [s] (infinite where it does not) and overshoot [%]."""

    case: Case
    way: Array
    command: Array
    settling_time_s: float
    overshoot_percent: float


@dataclass(frozen=True)
class LimitReading:
    """A limit: its name, value and limit [unit] (None where there is no limit), where the value comes from,
    and whether the limit is broken."""

    name: str
    value: float
    limit: float | None
    unit: str
    place: str
    broken: bool


@dataclass(frozen=True)
class Picture:
    """What a setting leads to.

    time [s] (rows,), that of the series, if there are any; cost: the worst IAE [deg s]; settling_time_s: the
    longest; trouble: why there is nothing to show, in one line; note: what keeps the plant from a reference.
    """

    setting: Setting
    time: Array
    series: tuple[ShownStep, ...] = ()
    margins: tuple[BranchMargins, ...] = ()
    limits: tuple[LimitReading, ...] = ()
    cost: float = float("nan")
    settling_time_s: float = float("nan")
    trouble: str | None = None
    note: str | None = None

    @property
    def broken(self) -> list[str]:
        """Names of the limits that are broken."""
        return [row.name for row in self.limits if row.broken]


def picture(given: TunedPlant, setting: Setting) -> Picture:
    """The picture of a setting; `given` is the case of its plant.

    >>> from design.tuner.case import case
    >>> from plants import Wrist
    >>> shown = picture(case(Wrist.flexion(), Setting()), Setting(Kp=1.2, Ki=2.2))
    >>> len(shown.series), round(shown.series[0].settling_time_s, 2), shown.broken
    (10, 5.59, [])
    """
    problem = given.problem
    if problem is None:
        return Picture(setting, np.empty(0), trouble=given.trouble)
    pi = controller(problem, setting.Kp, setting.Ki)
    played = play(problem.lanes, pi, record=True, jobs=problem.jobs)
    judged, went = played.metrics, played.trajectory
    assert went is not None
    at, rows = evaluate(problem, setting.Kp, setting.Ki), shown_samples(problem.wrist.rig)
    return Picture(
        setting, went.time[rows], _series(problem, judged, went.angle[rows], went.command[rows]),
        branch_margins(problem.branches, pi), _limits(problem, at), float(at.cost[0]),
        float(judged.settling_time_s.max()), note=given.note,
    )  # fmt: skip


def _series(problem: Problem, judged: Metrics, angle: Array, command: Array) -> tuple[ShownStep, ...]:
    """Responses of the scenarios; angle [deg], command [V], (rows, scenarios)."""
    return tuple(
        ShownStep(
            s, (angle[:, i] - s.task.angle) * np.sign(s.task.reference - s.task.angle), command[:, i],
            float(judged.settling_time_s[i]), float(judged.overshoot_percent[i]),
        )
        for i, s in enumerate(problem.scenarios)
    )  # fmt: skip


def _limits(problem: Problem, at: Evaluation) -> tuple[LimitReading, ...]:
    """Each limited quantity of one pair of gains, whether it is limited or not."""
    return tuple(
        LimitReading(
            name, float(at.values[name][0]), problem.limits.named.get(name), LIMIT_UNITS[name],
            problem.place(name, int(at.values_at[name][0])),
            bool(name in at.excess and at.excess[name][0] > ROUNDING - 1.0),
        )
        for name in at.values
    )  # fmt: skip
