"""Margins on every branch of a requirement, for gains that were designed on those that decide for a PI."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from design.margins import LINEAR, BranchResponse, Margins
from design.robustness.requirement import Requirement
from design.robustness.tuning.tuned_controller import TunedController
from design.synthesis.requirements import Problem, excesses

T = TypeVar("T", bound=TunedController)


def on_all_branches(
    requirement: Requirement,
    design: Callable[[Problem, T | None], T],
    margins_of: Callable[[Any, Sequence[BranchResponse]], Margins],
    problem: Problem,
    known: T | None,
) -> T:
    """The gains that a design finds, designed again with every branch on which their margins break a limit
    that they hold on those of the problem, until there is none."""
    while True:
        found = design(problem, known)
        more = _worse(requirement, found, margins_of)
        if not more:
            return found
        problem, known = replace(problem, branches=(*problem.branches, *more)), found


def _worse(
    requirement: Requirement,
    found: T,
    margins_of: Callable[[Any, Sequence[BranchResponse]], Margins],
) -> tuple[BranchResponse, ...]:
    """Branches of the requirement on which margins break a limit that they hold on those of the problem; none
    of what breaks one there already."""
    held = {n: v for n, v in found.problem.held_to.items() if n in LINEAR}
    if not held or any(found.at.excess[n][0] > 0.0 for n in held):
        return ()
    branches = requirement.branches
    at = margins_of(found.controller, branches)
    values = {n: np.array([float(at.values[n])]) for n in held}
    broken = [n for n, e in excesses(values, held).items() if e[0] > 0.0]
    return tuple(branches[int(i)] for i in {int(at.at[n]) for n in broken})
