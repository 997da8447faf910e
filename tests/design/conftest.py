"""Small tuning problems, solved once for all tests: a few scenarios, a coarse map, a short run."""

from functools import cache

import pytest

from design.evaluation.cases import Case
from design.evaluation.tasks import Task
from design.synthesis.requirements import Limits, Problem
from design.synthesis.tuning import Region, Tuning, tune
from plants import Wrist

REGION = Region(Kp=(0.5, 40.0), Ki=(1.0, 200.0), points=9)
FOUR_SECONDS = 4.0


@cache
def solved(axis: str, limits: Limits, cost: str = "iae") -> Tuning:
    wrist = getattr(Wrist, axis)()
    scenarios = [
        Case(Task("virgin", 0.0, (15.0,)), wrist),
        Case(Task("line2", 0.0, (15.0,)), wrist),
        Case(Task("inside", 0.0, (-15.0,)), wrist),
        Case(Task("line1", 15.0, (0.0,)), wrist),
    ]
    problem = Problem.of(wrist, scenarios, limits, cost, duration=FOUR_SECONDS)
    return tune(problem, REGION, starts=3)


@pytest.fixture
def solve():
    """``solve(axis, limits, cost)`` -> the tuning of a small problem."""
    return solved
