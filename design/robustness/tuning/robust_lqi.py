"""A robust LQI tuned under the whole requirement, by the loop that tunes a PI.

Its state feedback is guaranteed on the nominal plant; all else that the requirement asks for is judged: cases
by simulation, Ms, Mt and the delay margin at the command on every branch of every corner with the dead time
in.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from design.alternatives.lqi_design import GENERATIONS, RobustLQI, design_lqi
from design.input_loop import InputLoop
from design.margins import BranchResponse, Margins
from design.robustness.requirement import Requirement
from design.robustness.tuning.robust_tuning import GUARD, RobustTuning, grow
from design.robustness.tuning.worse_branches import on_all_branches
from design.synthesis.requirements import Problem
from design.synthesis.tuning import Tuning

Tell = Callable[[str, float], None]


def tune_lqi(
    requirement: Requirement,
    base: Tuning,
    seed: int = 0,
    rounds: int = 15,
    jobs: int | None = None,
    progress: Tell | None = None,
    generations: int = GENERATIONS,
) -> RobustTuning[RobustLQI]:
    """Gains of an LQI of least worst cost that hold a requirement, as far as pool, search and fresh samples
    can tell; base: the tuning of a PI, with whose cases it begins; generations: of each search of the family,
    see `design_lqi`; otherwise as `tune_robustly`.

    Raises design.synthesis.convex.Unsolved where the plant has no such feedback.
    """

    def on_few(problem: Problem, known: RobustLQI | None) -> RobustLQI:
        return design_lqi(problem, seed, known, generations)

    def design(problem: Problem, known: RobustLQI | None) -> RobustLQI:
        return on_all_branches(requirement, on_few, _margins_at_command, problem, known)

    problem = replace(requirement.problem(dict(GUARD), jobs), adverse=base.problem.adverse)
    return grow(requirement, problem, design, seed, rounds, jobs, progress)


def _margins_at_command(controller: Any, branches: Sequence[BranchResponse]) -> Margins:
    return InputLoop.at_command(controller, branches).margins(branches)
