"""A plant with all that is known of it before gains are chosen: made anew when its sliders move."""

from dataclasses import dataclass, replace

import numpy as np

from design.evaluation.cases import Case, on_lanes
from design.evaluation.tasks import tuning_tasks
from design.margins import branch_responses
from design.synthesis.requirements import Limits, Problem
from design.tuner.setting import DELAY, Setting, plant, trouble
from plants.wrist import Wrist

COARSE = 200
"""Frequencies at which the map looks at each branch; a picture of one pair of gains looks at four times
as many."""


@dataclass(frozen=True)
class TunedPlant:
    """The plant of a setting as a problem of tuning: steps of the task of this plant alone, both ways from
    every starting memory, and back; coarse: the same with fewer frequencies, for the map.

    trouble: why there is no such plant, in one line, or None; there is no problem then.  note: what keeps
    it from a reference, in one line, or None.
    """

    problem: Problem | None
    coarse: Problem | None
    trouble: str | None = None
    note: str | None = None


def case(wrist: Wrist, setting: Setting, limits: Limits | None = None, jobs: int | None = None) -> TunedPlant:
    """The case of the user's wrist under a setting, whose gains take no part.

    >>> case(Wrist.flexion(), Setting(transit=3.0, lines=0.5)).trouble
    'transit slope s = 0.2409 is not below a1 = 0.18, so the loop runs backwards'
    >>> len(case(Wrist.flexion(), Setting()).problem.scenarios)
    10
    """
    here = plant(wrist, setting)
    wrong = trouble(here)
    if wrong is not None:
        return TunedPlant(None, None, wrong)
    tasks, own = tuning_tasks(here.rig), DELAY in wrist.values
    # The dead time beside the wrist, where it has none of its own: then the rest is known in closed form, and
    # need not be looked for, which takes so long that a drag would feel it.
    bare, late = (here, None) if own else (wrist.made_of(here.values), setting.dead_time)
    problem = Problem(
        here, tuple(Case(t, here) for t in tasks), limits or Limits.of(here.rig), "iae",
        tuple(branch_responses(here)), on_lanes(bare, tasks, late), jobs,
    )  # fmt: skip
    coarse = replace(problem, branches=tuple(branch_responses(here, COARSE)))
    return TunedPlant(problem, coarse, note=out_of_reach(problem))


def out_of_reach(problem: Problem) -> str | None:
    """What keeps the plant from a reference, the worst of them, in one line; None where nothing does.

    As `design.synthesis.evaluate.out_of_range`, from the states at rest that are known already: the
    scenarios hold those on each line at every reference.
    """
    pressure = np.asarray(problem.lanes.state.pressure, float)
    tasks, units = [s.task for s in problem.scenarios], problem.wrist.rig.units
    at_rest = {(t.start, t.angle): p for t, p in zip(tasks, pressure, strict=True)}
    found = []
    for t in tasks:
        needed = float(at_rest["line1" if t.reference > t.angle else "line2", t.reference])
        for effect in problem.wrist.effects:
            words = effect.obstacle(needed, t.reference)
            if words is not None:
                return f"{words} keeps the wrist from holding {t.reference:+g} {units.angle}"
        command = needed / problem.wrist.regulator.gain
        low, high = problem.wrist.rig.command_range
        found.append((max(low - command, command - high), t))
    lack, task = max(found, key=lambda pair: pair[0])
    if lack <= 0.0:
        return None
    return (
        f"the command range is {lack:.3g} {units.command} too small to hold {task.reference:+g} {units.angle}"
    )
