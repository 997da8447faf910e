"""The tasks: what rigs are asked, each under an id that rows, bounds and figures refer to.

Names for people are made here and nowhere else.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from design import metrics
from design.evaluation.runner import Lanes
from design.tasks import STEP
from plants.simulation.reference_profile import ReferenceProfile
from plants.wrist import SAMPLE_TIME, STARTS, Start, State, Wrist

LOAD = 1.0
"""Shift of the static angle by a load [deg]: the size at which the trace first tries a load step."""

STAIRS = (8.0, 15.0, 5.0, -10.0)
"""References of the staircase [deg]: two up, a reversal within the loop, one through 0."""

TREAD = 2.0
"""How long each of them holds [s]."""

HOLD = 5.0
"""How long the first angle of a return is held in the comparison [s]."""

SIDE_BY_SIDE = 8.0
"""Length [s] of tasks that run side by side."""

FAMILIES = {
    "steps": "steps of 15 deg, both signs, from every starting memory",
    "return": "return to 0 deg after 2 s at 15 deg, both signs",
    "staircase": "a staircase to " + ", ".join(f"{r:g}" for r in STAIRS) + f" deg, {TREAD:g} s each, and its "
    "mirror image",
    "load step": f"a load of {LOAD:g} deg, either way, after 1 s of holding 15 deg on either side",
}
"""Families of tasks that run side by side, and what they are."""


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


def steps() -> list[Task]:
    """Steps from rest at 0 deg, both signs, from every starting memory."""
    return [
        Task(f"step{_sign(r)}{start}", "steps", f"0 to {r:+g} deg, {start}", start, 0.0, (r,))
        for r in (STEP, -STEP)
        for start in STARTS
    ]


def returns(held: float = HOLD) -> list[Task]:
    """Returns to 0 deg from a step that was held for so long [s], both signs; 10 s are judged."""
    return [
        Task(
            f"return{_sign(r)}", "return", f"return from {r:+g} to 0 deg", "virgin", 0.0, (r, 0.0),
            (0.0, held), held + 10.0, held,
        )
        for r in (STEP, -STEP)
    ]  # fmt: skip


def staircases() -> list[Task]:
    """A staircase and its mirror image."""
    moments = tuple(TREAD * k for k in range(len(STAIRS)))
    return [
        Task(f"staircase{_sign(s)}", "staircase", name, "virgin", 0.0, tuple(s * r for r in STAIRS), moments)
        for s, name in ((1.0, "up first"), (-1.0, "down first"))
    ]


def load_steps() -> list[Task]:
    """Loads, either way, that come after 1 s of holding a step, on either side."""
    found = []
    for r in (STEP, -STEP):
        line: Start = "line1" if r > 0.0 else "line2"
        for load in (LOAD, -LOAD):
            name = f"{load:+g} deg of load at {r:+g} deg"
            id_ = f"load{_sign(load)}at{_sign(r)}"
            found.append(
                Task(id_, "load step", name, line, r, (r, r), (0.0, 1.0), judged_from=1.0, load=load)
            )
    return found


def comparison_tasks() -> list[Task]:
    """What controllers are compared on, on the plant as it is: steps and returns, each judged by itself."""
    return [*steps(), *returns()]


def side_by_side() -> list[Task]:
    """All families, as long as each other and judged against one band, 2 % of a 15 degree step, so that they
    may run as lanes of one batch on many plants."""
    given = [*steps(), *returns(2.0), *staircases(), *load_steps()]
    return [replace(t, duration=SIDE_BY_SIDE, relative_to=STEP) for t in given]


def batch(wrist: Wrist, state: State, given: Sequence[Task]) -> Lanes:
    """Tasks that are judged stair by stair as lanes, one a lane of the wrist; one with fewer references than
    others holds its last one on.  Raises ValueError for tasks that cannot run side by side."""
    ((step, duration),) = {(t.relative_to, t.duration) for t in given}
    if step is None:
        raise ValueError("tasks that are judged by a step of their own do not run side by side")
    most = len(STAIRS)  # the same for all, so that one compiled loop serves them
    samples = round(duration / SAMPLE_TIME)
    references = np.array([t.references + t.references[-1:] * (most - len(t.references)) for t in given])
    switches = np.full((most, len(given)), float(samples))
    for lane, task in enumerate(given):
        switches[: len(task.moments), lane] = np.round(np.array(task.moments) / SAMPLE_TIME)
    begins = np.round(np.array([t.judged_from for t in given]) / SAMPLE_TIME)
    before = np.array([t.angle for t in given], float)
    profile = ReferenceProfile(tuple(references.T), tuple(switches[1:]), before)
    return Lanes(wrist, state, profile, metrics.of_stairs(step, begins, samples - begins), duration)
