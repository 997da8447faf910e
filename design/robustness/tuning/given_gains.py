"""Gains that were found elsewhere, such as by a design, as a tuning that shows them: nothing is searched."""

from dataclasses import replace

import numpy as np

from design.controllers.pi import PI
from design.robustness.requirement import Requirement
from design.robustness.samples.hunt import Hunted
from design.robustness.tuning.case_pool import pool_of
from design.robustness.tuning.gain_search import evaluate_law, law_with, with_evidence
from design.synthesis.answer import out_of_reach
from design.synthesis.requirements import COSTS
from design.synthesis.structure import PLAIN_PI, TWO_DOF_PI
from design.synthesis.tuning import Region, Tuning

NEAR, DEAR = 48, 16
"""Cases of the pool, those nearest to a limit and the dearest, that gains and their map are shown on."""


def given_gains(
    requirement: Requirement, controller: PI, region: Region | None = None, jobs: int | None = None
) -> Tuning:
    """A tuning that was given its gains: judged, with a map of the region around, on the nominal steps, the
    margins, and the cases of the tuning's pool that come nearest to a limit under them or cost most.

    Judged by the limits themselves: the guard below them was the tuning's.
    """
    region = region or Region.of(requirement.wrist)
    problem = requirement.problem(jobs=jobs)
    settings = {n: float(getattr(controller, n)) for n in controller.TUNED}
    law = law_with(TWO_DOF_PI if settings else PLAIN_PI, settings)
    Kp, Ki = (np.array([float(g)]) for g in (controller.Kp, controller.Ki))
    if out_of_reach(problem) is None:
        pool = pool_of(requirement)
        values = requirement.run(pool, controller, jobs=jobs)
        cost = np.where(requirement.space.of_task(pool), values[COSTS[requirement.cost]], 0.0)
        near, dear = Hunted(pool, requirement.excess(values)), Hunted(pool, cost)
        chosen = np.unique(np.concatenate([near.worst(NEAR), dear.worst(DEAR)]))
        problem = replace(problem, adverse=tuple(requirement.space.case(pool[:, i])[0] for i in chosen))
    at = evaluate_law(problem, law, Kp, Ki)
    found = Tuning(problem, region, at, at, (), given=True)
    return found if out_of_reach(problem) is not None else with_evidence(found, 0)
