"""Limits at their edge, zero or none at all, are held or broken like any other."""

import numpy as np
import pytest

from design.evaluation.cases import Case
from design.evaluation.tasks import Task
from design.synthesis.evaluate import evaluate
from design.synthesis.requirements import Limits, Problem
from design.synthesis.tuning import Region, tune
from plants import Wrist


def problem(limits: Limits) -> Problem:
    wrist = Wrist.flexion()
    return Problem.of(wrist, [Case(Task("virgin", 0.0, (15.0,)), wrist)], limits, duration=4.0)


def test_no_overshoot_at_all_is_held_by_slow_gains():
    at = evaluate(problem(Limits(overshoot_percent=0.0)), [0.8, 12.0], [0.7, 60.0])
    assert at.values["overshoot_percent"][0] == 0.0
    assert at.excess["overshoot_percent"][0] <= 0.0
    assert at.excess["overshoot_percent"][1] > 0.0


def test_a_delay_margin_of_zero_is_no_limit():
    at = evaluate(problem(Limits(delay_margin_s=0.0)), [1.2], [2.2])
    assert at.excess["delay_margin_s"][0] <= 0.0


def test_without_limits_everything_is_feasible():
    free = Limits.none()
    found = tune(problem(free), Region(points=5), starts=1)
    assert found.feasible
    assert found.active is None


def test_where_nothing_holds_the_limits_the_least_excess_of_the_map_is_not_undercut():
    wrist = Wrist.flexion()
    scenarios = [Case(Task("virgin", 0.0, (15.0,)), wrist), Case(Task("line1", 15.0, (0.0,)), wrist)]
    limits = Limits(total_variation_V=0.3, steady_error_percent=0.5)
    region = Region((0.5, 40.0), (1.0, 200.0), 9)
    found = tune(Problem.of(wrist, scenarios, limits, duration=4.0), region, starts=3)
    assert not found.feasible
    assert found.at.worst_excess[0] <= np.min(found.map.worst_excess) + 1e-12


def test_an_unknown_cost_is_refused():
    wrist = Wrist.flexion()
    with pytest.raises(ValueError, match="unknown cost 'beauty'"):
        Problem.of(wrist, [], cost="beauty")
