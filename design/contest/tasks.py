"""What is asked in the contest: courses of references, a step of load, from given rests.

All tasks last equally long and are judged against the same band of +-0.3 deg, 2 % of a 15 degree step, so
that they may run side by side as lanes of one batch.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from design import metrics
from design.metrics import Yardstick
from design.tasks import STEP
from plants.simulation.reference_profile import ReferenceProfile
from plants.wrist import SAMPLE_TIME, STARTS, Start

DURATION = 8.0
"""Length of every task [s]."""

LOAD = 1.0
"""Shift of the static angle by a load [deg]: the size at which the trace first tries a load step."""

STAIRS = (8.0, 15.0, 5.0, -10.0)
"""References of the staircase [deg]: two up, a reversal within the loop, one through 0."""

TREAD = 2.0
"""How long each of them holds [s]."""

FAMILIES = {
    "steps": "steps of 15 deg, both signs, from every starting memory",
    "return": "return to 0 deg after 2 s at 15 deg, both signs",
    "staircase": "a staircase to " + ", ".join(f"{r:g}" for r in STAIRS) + f" deg, {TREAD:g} s each, and its "
    "mirror image",
    "load step": f"a load of {LOAD:g} deg, either way, after 1 s of holding 15 deg on either side",
}
"""Families of tasks, and what they are."""


@dataclass(frozen=True)
class Task:
    """One run: a wrist at rest at an angle [deg], having come there by `start`, meets a course.

    references [deg] and the moments [s] from which they hold, the first 0; judged from a moment [s] on;
    a load [deg] that comes at that moment.
    """

    family: str
    name: str
    start: Start
    angle: float
    references: tuple[float, ...]
    moments: tuple[float, ...]
    judged_from: float = 0.0
    load: float = 0.0


@dataclass(frozen=True)
class Asked:
    """What lanes are asked: their reference profiles, their judge, for a duration [s]."""

    profile: ReferenceProfile
    judge: Yardstick
    duration: float


def tasks() -> list[Task]:
    """All tasks of one motion, the families in order."""
    found = []
    for sign in (1.0, -1.0):
        for start in STARTS:
            name = f"0 to {sign * STEP:+g} deg, {start}"
            found.append(Task("steps", name, start, 0.0, (sign * STEP,), (0.0,)))
    for sign in (1.0, -1.0):
        name = f"return from {sign * STEP:+g} to 0 deg"
        found.append(Task("return", name, "virgin", 0.0, (sign * STEP, 0.0), (0.0, 2.0), 2.0))
    for sign, word in ((1.0, "up first"), (-1.0, "down first")):
        stairs = tuple(sign * r for r in STAIRS)
        moments = tuple(TREAD * k for k in range(len(STAIRS)))
        found.append(Task("staircase", word, "virgin", 0.0, stairs, moments))
    for sign in (1.0, -1.0):
        line: Start = "line1" if sign > 0.0 else "line2"
        for load in (LOAD, -LOAD):
            name = f"{load:+g} deg of load at {sign * STEP:+g} deg"
            held = (sign * STEP, sign * STEP)
            found.append(Task("load step", name, line, sign * STEP, held, (0.0, 1.0), 1.0, load))
    return found


def course(given: Sequence[Task], duration: float = DURATION) -> Asked:
    """Tasks as lanes, for a duration [s]; one with fewer references than others holds its last one on."""
    most = len(STAIRS)  # the same for all, so that one compiled loop serves them
    samples = round(duration / SAMPLE_TIME)
    references = np.array(
        [t.references + t.references[-1:] * (most - len(t.references)) for t in given], float
    )
    switches = np.full((most, len(given)), float(samples))
    for lane, task in enumerate(given):
        switches[: len(task.moments), lane] = np.round(np.array(task.moments) / SAMPLE_TIME)
    begins = np.round(np.array([t.judged_from for t in given]) / SAMPLE_TIME)
    before = np.array([t.angle for t in given], float)
    profile = ReferenceProfile(tuple(references.T), tuple(switches[1:]), before)
    return Asked(profile, metrics.of_stairs(STEP, begins, samples - begins), duration)
