"""A plant with all that is known of it before gains are chosen: made anew when its sliders move."""

from dataclasses import dataclass, replace

import numpy as np

from design.evaluation.scenarios import tuning_scenarios
from design.evaluation.sequence import batch
from design.margins import branch_responses
from design.synthesis.requirements import Limits, Problem
from design.tuner.setting import DELAY, Setting, plant, trouble
from plants.wrist import Wrist

COARSE = 200
"""Frequencies at which the map looks at each branch; a picture of one pair of gains looks at four times
as many."""


@dataclass(frozen=True)
class TunedPlant:
    """The plant of a setting as a problem of tuning: steps of 15 degrees of this plant alone, both ways from
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
    scenarios = tuple(s for s in tuning_scenarios(here) if s.plant == "nominal")
    lanes = len(scenarios)
    angles, references = (np.array([getattr(s, n) for s in scenarios], float) for n in ("angle", "reference"))
    # The state at rest in closed form where the wrist has no effects of its own: those of `Scenario` take
    # ten times as long, which a drag would feel.
    own = DELAY in wrist.values
    bare = here if own else wrist.made_of(here.values)
    rest = batch(
        bare, [s.start for s in scenarios], angles, references[None], np.ones((1, lanes)),
        None if own else setting.dead_time,
    )  # fmt: skip
    stacked = here.made_of({n: np.full(lanes, v) for n, v in here.values.items()})
    problem = Problem(
        here, scenarios, limits or Limits.of(here.rig), "iae", tuple(branch_responses(here)),
        (stacked, rest.state, references), here.rig.task.duration, jobs,
    )  # fmt: skip
    coarse = replace(problem, branches=tuple(branch_responses(here, COARSE)))
    return TunedPlant(problem, coarse, note=out_of_reach(problem))


def out_of_reach(problem: Problem) -> str | None:
    """What keeps the plant from a reference, the worst of them, in one line; None where nothing does.

    As `design.synthesis.evaluate.out_of_range`, from the states at rest that are known already: the
    scenarios hold those on each line at every reference.
    """
    pressure = np.asarray(problem.stacked[1].pressure, float)
    at_rest = {(s.start, s.angle): p for s, p in zip(problem.scenarios, pressure, strict=True)}
    found = []
    for s in problem.scenarios:
        needed = float(at_rest["line1" if s.reference > s.angle else "line2", s.reference])
        for effect in problem.wrist.effects:
            words = effect.obstacle(needed, s.reference)
            if words is not None:
                return f"{words} keeps the wrist from holding {s.reference:+g} deg"
        command = needed / problem.wrist.regulator.gain
        low, high = problem.wrist.rig.command_range
        found.append((max(low - command, command - high), s))
    lack, scenario = max(found, key=lambda pair: pair[0])
    if lack <= 0.0:
        return None
    return f"the command range is {lack:.3g} V too small to hold {scenario.reference:+g} deg"
