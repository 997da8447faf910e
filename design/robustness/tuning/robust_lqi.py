"""A robust LQI tuned under the whole requirement, by the loop that tunes a PI.

Its state feedback is guaranteed on the nominal plant; all else that the requirement asks for is judged: cases
by simulation, Ms, Mt and the delay margin at the command on every branch of every corner with the dead time
in.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from design.alternatives.lqi_design import RobustLQI, design_lqi
from design.input_loop import InputLoop
from design.margins import BranchResponse
from design.robustness.requirement import LINEAR, Requirement
from design.robustness.tuning.robust_tuning import GUARD, RobustTuning, grow
from design.synthesis.requirements import Problem, excesses
from design.synthesis.tuning import Tuning

Tell = Callable[[str, float], None]


def tune_lqi(
    requirement: Requirement,
    base: Tuning,
    seed: int = 0,
    rounds: int = 15,
    jobs: int | None = None,
    progress: Tell | None = None,
) -> RobustTuning[RobustLQI]:
    """Gains of an LQI of least worst cost that hold a requirement, as far as pool, search and fresh samples
    can tell; base: the tuning of a PI, with whose cases it begins; otherwise as `tune_robustly`.

    Raises design.synthesis.convex.Unsolved where the plant has no such feedback.
    """

    def design(problem: Problem, known: RobustLQI | None) -> RobustLQI:
        while True:
            found = design_lqi(problem, seed, known)
            more = _worse_branches(requirement, found)
            if not more:
                return found
            problem, known = replace(problem, branches=(*problem.branches, *more)), found

    problem = replace(requirement.problem(dict(GUARD), jobs), adverse=base.problem.adverse)
    return grow(requirement, problem, design, seed, rounds, jobs, progress)


def _worse_branches(requirement: Requirement, found: RobustLQI) -> tuple[BranchResponse, ...]:
    """Branches of the requirement on which margins break a limit that they hold on those of the problem; none
    of what breaks one there already."""
    held = {n: v for n, v in found.problem.held_to.items() if n in LINEAR}
    if not held or any(found.at.excess[n][0] > 0.0 for n in held):
        return ()
    branches = requirement.branches
    at = InputLoop.at_command(found.controller, branches).margins(branches)
    values = {n: np.array([float(getattr(at, n))]) for n in held}
    broken = [n for n, e in excesses(values, held).items() if e[0] > 0.0]
    places = {"Ms": at.Ms_at, "Mt": at.Mt_at, "delay_margin_s": at.delay_at}
    return tuple(branches[int(i)] for i in {int(places[n]) for n in broken})
