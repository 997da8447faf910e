"""Tuning again once a rig is known better: the PI of the declared plant beside that of the revised one.

Both are then run on one judge: the revised plant, where only data is at hand, or a rig.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from design.evaluation.steps import run
from design.synthesis.answer import Refusal, out_of_reach, refusal
from design.synthesis.designed_plant import designed, left_out
from design.synthesis.evaluate import evaluate, out_of_range
from design.synthesis.requirements import ROUNDING, Limits, Problem, late_problem
from design.synthesis.tuning import Region, Tuning, tune
from plants.equilibrium import holding_command
from plants.parameters.quantities import ParameterSet
from plants.rig import StepTask
from plants.wrist import Wrist

Array = NDArray[np.float64]
Tell = Callable[[str, float], None]
LAST = 1.0
"""The error that is left is the largest over the last so many seconds, so that a loop that rings does
not pass for one that has arrived."""

SWING, SWINGS = 0.05, 3
"""A loop oscillates that turns so often in the second half of the run, by this share of the step or more."""

ON_REVISED = "the revised plant, since only data is at hand"
"""What both PIs are run on where no rig is given."""

ON_FITTED = "the fitted plant, since only data is at hand"
"""The same where nothing was revised."""


class StepSignals(Protocol):
    """What a step of the reference gave: time [s], angle of the joint [deg], command [V], (n,) each."""

    @property
    def time(self) -> Array:
        """Times [s], (n,)."""
        ...

    @property
    def angle(self) -> Array:
        """Angle of the joint [deg], (n,)."""
        ...

    @property
    def command(self) -> Array:
        """Command [V], (n,)."""
        ...


class Stepped(Protocol):
    """A closed-loop step of the rig's task from rest: its signals."""

    @property
    def run(self) -> StepSignals:
        """The signals of the step."""
        ...


Judge = Callable[[float, float], Stepped]
"""Runs a PI with gains Kp [kPa/deg] and Ki [kPa/(deg s)] on a rig."""


@dataclass(frozen=True)
class RetunedResponse:
    """A closed-loop step: time [s], angle of the joint [deg], command [V], (n,) each."""

    time: Array
    angle: Array
    command: Array

    @property
    def run(self) -> "RetunedResponse":
        """The signals, so that a response is a `Stepped`."""
        return self


@dataclass(frozen=True)
class JudgedStep:
    """What a PI did on the judge in one step from rest, by the true angle.

    iae_deg_s; overshoot_percent of the step; settling_time_s into the band for good, infinite if never or
    if it oscillates;
    steady_error_deg: largest error over the last second; total_variation_V: total variation of the command,
    a rig's noise included; oscillates: three swings of 5 % or more in the second half;
    broken: limits that the step breaks, total variation of the command only counted where there is no noise.
    """

    response: RetunedResponse
    iae_deg_s: float
    overshoot_percent: float
    settling_time_s: float
    steady_error_deg: float
    total_variation_V: float
    oscillates: bool
    broken: tuple[str, ...]


@dataclass(frozen=True)
class RetunedSide:
    """The PI of one plant.

    plant: ``declared`` or ``revised``; tuning: None where the task is out of the plant's reach,
    refusal saying why, or which limit no gains hold (the gains are then the nearest);
    judged: on the judge; broken: limits that the PI breaks on the revised plant as it is tuned on, over
    all starting memories, corners and branches.
    """

    plant: str
    tuning: Tuning | None
    refusal: Refusal | None
    judged: JudgedStep | None
    broken: tuple[str, ...] = ()


@dataclass(frozen=True)
class Control:
    """Both PIs on one judge, which is named in words.

    same: nothing was revised, so there is one PI; task: what is stepped; left_out: effects of the
    revised plant that sit in its sensor, and that it was tuned without.
    """

    declared: RetunedSide
    revised: RetunedSide
    judge: str
    same: bool
    task: StepTask
    left_out: tuple[str, ...] = ()


def retune(
    declared: ParameterSet,
    revised: ParameterSet,
    judge: Judge | None = None,
    where: str = "the rig",
    region: Region | None = None,
    starts: int = 5,
    seed: int = 0,
    jobs: int | None = None,
    progress: Tell | None = None,
) -> Control:
    """Tune a PI on the declared plant and one on the revised, and run both on a judge.

    judge: runs a PI on a rig that `where` names; the revised plant where None.  Both are tuned behind the
    longest dead time that the rig states, where the plant has none of its own, on a map of `region` from
    `starts` local searches, and without what a design leaves out (`design.synthesis.designed_plant`).
    """
    tell = progress or (lambda what, share: None)
    wrist = Wrist.of(revised)
    problems = [late_problem(Wrist.of(p), jobs=jobs) for p in (declared, designed(revised))]
    same = declared.values == revised.values and declared.effects == revised.effects
    held = float(holding_command(wrist, wrist.hysteresis.rest_pressure))
    sides, task = [], wrist.rig.task
    for name, problem in list(zip(("declared", "revised"), problems, strict=True))[: 1 if same else 2]:
        found, no = _tuned(problem, region, starts, seed, _under(f"tuning on the {name} plant", tell))
        step = None if found is None else (judge or simulated(wrist))(found.Kp, found.Ki).run
        limits = problems[1].limits if judge is None else replace(problems[1].limits, total_variation_V=None)
        seen = None if step is None else judged(step, limits, held, task)
        sides.append(RetunedSide(name, found, no, seen, _breaks(found, problems[1])))
    if judge is None:
        where = ON_FITTED if same else ON_REVISED
    return Control(sides[0], sides[-1], where, same, task, left_out(revised))


def _tuned(
    problem: Problem, region: Region | None, starts: int, seed: int, tell: Tell
) -> tuple[Tuning | None, Refusal | None]:
    """The tuning, and why it is none or only the nearest."""
    beyond = out_of_reach(problem)
    if beyond is not None:  # no gains help: nothing to be searched for
        return None, beyond
    found = tune(problem, region, starts, seed, tell)
    return found, refusal(found)


def _under(what: str, tell: Tell) -> Tell:
    return lambda stage, share: tell(f"{what}: {stage}", share)


def _breaks(found: Tuning | None, problem: Problem) -> tuple[str, ...]:
    """Limits that the gains found break on a plant, in any scenario or on any branch."""
    if found is None or out_of_range(problem) is not None:
        return ()
    at = evaluate(problem, found.Kp, found.Ki)
    return tuple(n for n, excess in at.excess.items() if excess[0] > ROUNDING - 1.0)


def simulated(wrist: Wrist) -> Judge:
    """A judge that runs a wrist, without noise, under a PI that knows its declared parameters."""

    task = wrist.rig.task

    def play(Kp: float, Ki: float) -> RetunedResponse:
        pi = PI.of(wrist, Kp, Ki)
        _, _, t = run(wrist, pi, task.step, duration=task.duration, record=True)
        assert t is not None
        return RetunedResponse(
            t.time[:-1], t.angle[:-1, 0], t.command[:-1, 0]
        )  # the last row is after the last sample

    return play


def judged(signals: StepSignals, limits: Limits, held: float, task: StepTask) -> JudgedStep:
    """Metrics of the step of a task from 0 at the first sample, and which limits it breaks; `held` [V] is
    the command until then."""
    step = task.step
    time, angle = np.asarray(signals.time, float), np.asarray(signals.angle, float)
    command = np.asarray(signals.command, float)
    error, dt = step - angle, float(time[1] - time[0])
    far = np.flatnonzero(np.abs(error) >= task.band * abs(step))
    settled = int(far[-1]) + 1 if far.size else 0
    values = {
        "overshoot_percent": max(0.0, 100.0 * float((angle / step).max() - 1.0)),
        "total_variation_V": float(np.abs(np.diff(command, prepend=held)).sum()),
        "steady_error_percent": 100.0 * float(np.abs(error[time > time[-1] - LAST]).max()) / abs(step),
    }
    oscillates = _turns(angle[len(angle) // 2 :: 10], SWING * abs(step)) >= SWINGS
    return JudgedStep(
        RetunedResponse(time, angle, command),
        float(np.abs(error).sum() * dt),
        values["overshoot_percent"],
        settled * dt if settled < len(time) and not oscillates else float("inf"),
        0.01 * abs(step) * values["steady_error_percent"],
        values["total_variation_V"],
        oscillates,
        tuple(n for n, value in values.items() if n in limits.named and value > ROUNDING * limits.named[n]),
    )


def _turns(angle: Array, least: float) -> int:
    """How often an angle turns round after it has come by at least `least` [deg] from where it last turned.

    >>> _turns(np.array([0.0, 2.0, -2.0, 0.5]), 1.0), _turns(np.array([0.0, 0.5, 0.2, 3.0]), 1.0)
    (2, 0)
    """
    count, heading = 0, 0
    low = high = float(angle[0])
    for value in angle[1:].tolist():
        low, high = min(low, value), max(high, value)
        if heading <= 0 and value - low >= least:
            count, heading, high = count + (heading < 0), 1, value
        elif heading >= 0 and high - value >= least:
            count, heading, low = count + (heading > 0), -1, value
    return count
