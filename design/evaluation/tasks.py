"""The tasks: what rigs are asked, each under an id that rows, bounds and figures refer to.

Names for people are made here and nowhere else.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from design.evaluation import metrics
from design.evaluation.runner import Lanes
from plants.rig import Rig
from plants.simulation.reference_profile import ReferenceProfile
from plants.wrist import STARTS, Start, State, Wrist

LOAD = 15.0
"""A load shifts the static angle by one part in so many of the step."""

STAIRS = (8.0 / 15.0, 1.0, 1.0 / 3.0, -2.0 / 3.0)
"""References of the staircase over the step: two up, a reversal within the loop, one through 0."""

SHARES = {"tread": 0.2, "return": 0.2, "load": 0.1, "side by side": 0.8}
"""Times over the duration of the rig's task: of a stair, before a return and before a load step in tasks that
run side by side, and of these tasks themselves."""

FAMILIES = ("steps", "return", "staircase", "load step")
"""Families of tasks that run side by side."""


def stairs(rig: Rig) -> tuple[float, ...]:
    """References of the staircase [deg]."""
    return tuple(float(np.round(share * rig.task.step, 12)) for share in STAIRS)


def lasts(what: str, rig: Rig) -> float:
    """A time of `SHARES` [s]."""
    return float(np.round(SHARES[what] * rig.task.duration, 12))


def families(rig: Rig) -> dict[str, str]:
    """What the families of tasks are."""
    step, unit = rig.task.step, rig.units.angle
    treads = ", ".join(f"{r:g}" for r in stairs(rig))
    words = (
        f"steps of {step:g} {unit}, both signs, from every starting memory",
        f"return to 0 {unit} after {lasts('return', rig):g} s at {step:g} {unit}, both signs",
        f"a staircase to {treads} {unit}, {lasts('tread', rig):g} s each, and its mirror image",
        f"a load of {step / LOAD:g} {unit}, either way, after {lasts('load', rig):g} s of holding {step:g} "
        f"{unit} on either side",
    )
    return dict(zip(FAMILIES, words, strict=True))


@dataclass(frozen=True)
class Task:
    """A rig at rest at an angle [deg], having come there by `start`, meets references [deg], each from a
    moment [s] on of which the first is 0, for a duration [s].

    Judged from a moment [s] on: relative to the step that begins there, or, stair by stair, to a step of
    `relative_to` [deg].  load [deg]: shift of the static angle that comes at that moment.
    """

    id: str
    family: str
    name: str
    start: Start
    angle: float
    references: tuple[float, ...]
    moments: tuple[float, ...] = (0.0,)
    duration: float = 10.0
    judged_from: float = 0.0
    relative_to: float | None = None
    load: float = 0.0

    @property
    def stages(self) -> list[tuple[float, float, float]]:
        """Each reference [deg], the moment from which it holds, and for how long [s]."""
        ends = [*self.moments[1:], self.duration]
        return [(r, a, b - a) for r, a, b in zip(self.references, self.moments, ends, strict=True)]


def _sign(value: float) -> str:
    return "+" if value > 0.0 else "-"


def steps(rig: Rig) -> list[Task]:
    """Steps from rest at 0, both signs, from every starting memory."""
    size, unit, T = rig.task.step, rig.units.angle, rig.task.duration
    return [
        Task(f"step{_sign(r)}{start}", "steps", f"0 to {r:+g} {unit}, {start}", start, 0.0, (r,), duration=T)
        for r in (size, -size)
        for start in STARTS
    ]


def returns(rig: Rig, held: float | None = None) -> list[Task]:
    """Returns to 0 from a step that was held for so long [s], both signs; judged for the duration of a
    task."""
    size, unit = rig.task.step, rig.units.angle
    held = rig.task.hold if held is None else held
    return [
        Task(
            f"return{_sign(r)}", "return", f"return from {r:+g} to 0 {unit}", "virgin", 0.0, (r, 0.0),
            (0.0, held), held + rig.task.duration, held,
        )
        for r in (size, -size)
    ]  # fmt: skip


def staircases(rig: Rig) -> list[Task]:
    """A staircase and its mirror image."""
    treads, tread = stairs(rig), lasts("tread", rig)
    moments = tuple(tread * k for k in range(len(treads)))
    return [
        Task(f"staircase{_sign(s)}", "staircase", name, "virgin", 0.0, tuple(s * r for r in treads), moments)
        for s, name in ((1.0, "up first"), (-1.0, "down first"))
    ]


def load_steps(rig: Rig) -> list[Task]:
    """Loads, either way, that come after some time of holding a step, on either side."""
    size, unit, before = rig.task.step, rig.units.angle, lasts("load", rig)
    found = []
    for r in (size, -size):
        line: Start = "line1" if r > 0.0 else "line2"
        for load in (size / LOAD, -size / LOAD):
            name = f"{load:+g} {unit} of load at {r:+g} {unit}"
            id_ = f"load{_sign(load)}at{_sign(r)}"
            found.append(
                Task(id_, "load step", name, line, r, (r, r), (0.0, before), judged_from=before, load=load)
            )
    return found


def comparison_tasks(rig: Rig) -> list[Task]:
    """What controllers are compared on, on the plant as it is: steps and returns, each judged by itself."""
    return [*steps(rig), *returns(rig)]


def side_by_side(rig: Rig) -> list[Task]:
    """All families, as long as each other and judged against one band, that of a step, so that they
    may run as lanes of one batch on many plants."""
    given = [*steps(rig), *returns(rig, lasts("return", rig)), *staircases(rig), *load_steps(rig)]
    return [replace(t, duration=lasts("side by side", rig), relative_to=rig.task.step) for t in given]


def batch(wrist: Wrist, state: State, given: Sequence[Task]) -> Lanes:
    """Tasks that are judged stair by stair as lanes, one a lane of the wrist; one with fewer references than
    others holds its last one on.  Raises ValueError for tasks that cannot run side by side."""
    ((step, duration),) = {(t.relative_to, t.duration) for t in given}
    if step is None:
        raise ValueError("tasks that are judged by a step of their own do not run side by side")
    most = len(STAIRS)  # the same for all, so that one compiled loop serves them
    dt = wrist.rig.sample_time
    samples = round(duration / dt)
    references = np.array([t.references + t.references[-1:] * (most - len(t.references)) for t in given])
    switches = np.full((most, len(given)), float(samples))
    for lane, task in enumerate(given):
        switches[: len(task.moments), lane] = np.round(np.array(task.moments) / dt)
    begins = np.round(np.array([t.judged_from for t in given]) / dt)
    before = np.array([t.angle for t in given], float)
    profile = ReferenceProfile(tuple(references.T), tuple(switches[1:]), before)
    judge = metrics.of_stairs(step, begins, samples - begins, wrist.rig)
    return Lanes(wrist, state, profile, judge, duration)
