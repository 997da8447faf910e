"""The tasks: what rigs are asked, each under an id that rows, bounds and figures refer to.

Names for people are made here and nowhere else.
"""

from dataclasses import dataclass, replace
from itertools import accumulate
from typing import Literal

import numpy as np

from plants.rig import Rig
from plants.simulation.disturbance import BEFORE
from plants.wrist import STARTS, Start

LOAD = 15.0
"""A load shifts the static angle by one part in so many of the step."""

STAIRS = (8.0 / 15.0, 1.0, 1.0 / 3.0, -2.0 / 3.0)
"""References of the staircase over the step: two up, a reversal within the loop, one through 0."""

SHARES = {"tread": 0.2, "return": 0.2, "load": 0.1, "side by side": 0.8}
"""Times over the duration of the rig's task: of a stair, before a return and before a load step in tasks that
run side by side, and of these tasks themselves."""

FAMILIES = ("steps", "return", "staircase", "load step")
"""Families of tasks that run side by side."""


def calm(rig: Rig) -> tuple[float, float]:
    """How long [s] the reference before the last is held, shortest and longest, where the last step is to
    begin calmly.

    A step that begins in full motion overshoots by what the wrist has of it, under any gains: 150 % of a step
    of 5 deg were found where it might begin after 0.3 s.  What is left after 3 s is the slow end of the
    motion, and memory; a rig that is slower says so by a longer hold.

    >>> from plants.rig import built_in_rig
    >>> calm(built_in_rig())
    (3.0, 5.0)
    """
    return CALM * rig.task.hold, rig.task.hold


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


Judged = Literal["own band", "task band", "stairs"]
"""How a task is judged: its last step by itself; likewise, but settled in the band of the step of the rig's
task; or references one by one, all relative to the step of the rig's task."""

CALM = 0.6
"""Share of the time for which a rig holds the first angle of a return, see `calm`."""


@dataclass(frozen=True)
class Task:
    """What is asked, of whatever plant: at rest at an angle [deg], having come there by `start`, it meets
    references [deg], each held for so many seconds of `holds`.

    A step that comes before the one before it has settled meets a wrist that still moves and an integrator
    that is still on its way: a state that no start from rest has.  counted: of stairs, how many of the last
    references are judged.  load [deg]: constant shift of the static angle, there from load_at [s] on, before
    the run where that is negative; with such a load the virgin wrist starts where the load puts it.  id,
    family and name: of those in a list.  Raises ValueError for references without times.
    """

    start: Start
    angle: float
    references: tuple[float, ...]
    holds: tuple[float, ...] = (10.0,)
    judged: Judged = "own band"
    load: float = 0.0
    load_at: float = BEFORE
    counted: int = 1
    id: str = ""
    family: str = ""
    name: str = ""

    def __post_init__(self) -> None:
        if not self.references or len(self.references) != len(self.holds):
            raise ValueError("a task needs references, and as many times to hold them")

    @property
    def reference(self) -> float:
        """The last reference [deg]."""
        return self.references[-1]

    @property
    def before(self) -> float:
        """What the last step is from [deg]."""
        return (self.angle, *self.references)[-2]

    @property
    def duration(self) -> float:
        """How long it takes [s]."""
        return sum(self.holds)

    @property
    def stages(self) -> list[tuple[float, float, float]]:
        """Each reference [deg], the moment from which it holds, and for how long [s]."""
        moments = accumulate(self.holds[:-1], initial=0.0)
        return list(zip(self.references, moments, self.holds, strict=True))

    @property
    def last(self) -> "Task":
        """The last step by itself, from rest on the line on which the one before it arrives."""
        if len(self.references) == 1:
            return self
        start: Start = "line1" if self.before > 0.0 else "line2"
        return Task(start, self.before, self.references[-1:], self.holds[-1:])


def _sign(value: float) -> str:
    return "+" if value > 0.0 else "-"


def steps(rig: Rig) -> list[Task]:
    """Steps from rest at 0, both signs, from every starting memory."""
    size, unit, T = rig.task.step, rig.units.angle, rig.task.duration
    return [
        Task(
            start, 0.0, (r,), (T,),
            id=f"step{_sign(r)}{start}", family="steps", name=f"0 to {r:+g} {unit}, {start}",
        )
        for r in (size, -size)
        for start in STARTS
    ]  # fmt: skip


def returns(rig: Rig, held: float | None = None) -> list[Task]:
    """Returns to 0 from a step that was held for so long [s], both signs; judged for the duration of a
    task."""
    size, unit = rig.task.step, rig.units.angle
    held = rig.task.hold if held is None else held
    return [
        Task(
            "virgin", 0.0, (r, 0.0), (held, rig.task.duration),
            id=f"return{_sign(r)}", family="return", name=f"return from {r:+g} to 0 {unit}",
        )
        for r in (size, -size)
    ]  # fmt: skip


def staircases(rig: Rig) -> list[Task]:
    """A staircase and its mirror image."""
    treads, tread = stairs(rig), lasts("tread", rig)
    return [
        Task(
            "virgin", 0.0, tuple(s * r for r in treads), (tread,) * len(treads), counted=len(treads),
            id=f"staircase{_sign(s)}", family="staircase", name=name,
        )
        for s, name in ((1.0, "up first"), (-1.0, "down first"))
    ]  # fmt: skip


def load_steps(rig: Rig) -> list[Task]:
    """Loads, either way, that come after some time of holding a step, on either side."""
    size, unit, before = rig.task.step, rig.units.angle, lasts("load", rig)
    found = []
    for r in (size, -size):
        line: Start = "line1" if r > 0.0 else "line2"
        for load in (size / LOAD, -size / LOAD):
            found.append(
                Task(
                    line, r, (r, r), (before, rig.task.duration), load=load, load_at=before,
                    id=f"load{_sign(load)}at{_sign(r)}", family="load step",
                    name=f"{load:+g} {unit} of load at {r:+g} {unit}",
                )
            )  # fmt: skip
    return found


def tuning_tasks(rig: Rig, duration: float | None = None) -> list[Task]:
    """What gains are tuned on, on any plant: steps from rest at 0, and returns from a step on which it rests;
    each for a duration [s], that of the rig's task where not given."""
    step, holds = rig.task.step, (rig.task.duration if duration is None else duration,)
    asked = [Task(start, 0.0, (r,), holds) for start in STARTS for r in (step, -step)]
    return [*asked, Task("line1", step, (0.0,), holds), Task("line2", -step, (0.0,), holds)]


def comparison_tasks(rig: Rig) -> list[Task]:
    """What controllers are compared on, on the plant as it is: steps and returns, each judged by itself."""
    return [*steps(rig), *returns(rig)]


def side_by_side(rig: Rig) -> list[Task]:
    """All families, as long as each other and judged against one band, that of a step, so that they
    may run as lanes of one batch on many plants."""
    given = [*steps(rig), *returns(rig, lasts("return", rig)), *staircases(rig), *load_steps(rig)]
    whole = lasts("side by side", rig)
    return [replace(t, holds=(*t.holds[:-1], whole - sum(t.holds[:-1])), judged="stairs") for t in given]
