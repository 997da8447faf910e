"""The MPC's prediction is the exact sampled wrist of the one page, and its derivatives are those of finite
differences of that page."""

import numpy as np
import pytest

from design.mpc.prediction import coefficients, linearise, roll
from design.mpc.problem import MPCProblem
from plants import Wrist
from plants.kernel import pytrees as tree
from plants.one_page import wrist as one_page

PLAN = np.concatenate([np.full(9, 4.0), np.full(8, 2.6), np.linspace(2.0, 3.3, 13)])


def by_the_page(wrist: Wrist, plan: np.ndarray) -> np.ndarray:
    return np.array(one_page(wrist.values, np.repeat(plan, 20).tolist()))[20::20]


def about(wrist: Wrist, plan: np.ndarray):
    problem = MPCProblem(wrist)
    start = np.array(tree.leaves(wrist.rest()), float)
    return problem, linearise(
        problem, coefficients(wrist), problem.stage_weights, problem.move_hessian, start, 0.0, plan
    )


@pytest.mark.parametrize("wrist", [Wrist.flexion(), Wrist.deviation()], ids=["flexion", "deviation"])
def test_a_plan_goes_where_the_one_page_goes(wrist):
    page = by_the_page(wrist, PLAN)
    problem, found = about(wrist, PLAN)
    assert np.abs(found.angles - page[:, 2]).max() < 1e-11
    assert np.abs(found.states[:, [0, 1, 3]] - page).max() < 1e-11
    start = np.array(tree.leaves(wrist.rest()), float)
    assert np.abs(roll(problem, coefficients(wrist), start, 0.0, PLAN) - found.states).max() < 1e-12


@pytest.mark.parametrize("k", [0, 8, 12, 29])
def test_derivatives_by_a_command_are_those_of_the_one_page(k):
    wrist, small = Wrist.flexion(), 1e-5
    _, found = about(wrist, PLAN)
    up, down = PLAN.copy(), PLAN.copy()
    up[k] += small
    down[k] -= small
    by_difference = (by_the_page(wrist, up) - by_the_page(wrist, down))[:, 2] / (2.0 * small)
    assert np.abs(found.by_command[:, k] - by_difference).max() < 1e-6
    assert np.abs(found.by_command[:, k]).max() > 1e-3


def test_a_lack_of_pressure_acts_as_a_lower_command():
    wrist = Wrist.flexion()
    problem = MPCProblem(wrist)
    start = np.array(tree.leaves(wrist.rest("line1")), float)
    lack = roll(problem, coefficients(wrist), start, -4.94, PLAN)
    lower = roll(problem, coefficients(wrist), start, 0.0, PLAN - 0.1)
    assert np.abs(lack - lower).max() < 1e-11


def test_the_condensed_hessian_is_that_of_the_cost():
    problem, found = about(Wrist.flexion(), PLAN)
    D = np.eye(30) - np.eye(30, k=-1)
    swings = np.diff(found.by_command, axis=0)
    direct = found.by_command.T @ np.diag(problem.stage_weights) @ found.by_command
    direct += problem.weights.swing * swings.T @ swings
    assert np.abs(found.hessian - direct - problem.weights.move * D.T @ D).max() < 1e-10


def test_nothing_moves_the_angle_on_the_virgin_curve():
    """Why the nonlinear plan cannot start from a plan that stays there."""
    wrist = Wrist.flexion()
    _, found = about(wrist, np.full(30, wrist.hysteresis.rest_pressure / wrist.regulator.gain))
    assert np.abs(found.by_command).max() == 0.0
