"""An MPC plans on the memory that its plant's hysteresis law has, with derivatives that are exact."""

import numpy as np
import pytest

from design.mpc import loop
from design.mpc.formulations import hybrid
from design.mpc.formulations.linear import linear_mpc
from design.mpc.formulations.real_time import real_time_mpc
from design.mpc.observer import begin
from design.mpc.prediction import coefficients, differentiated, linearise, roll
from design.mpc.problem import MPCProblem
from plants import Wrist
from plants.errors import InputError
from plants.kernel import pytrees as tree
from tests.laws.second_law import second_law_set

PLAN = np.concatenate([np.full(9, 4.0), np.full(8, 2.6), np.linspace(2.0, 3.3, 13)])
SMALL = 1e-5


@pytest.fixture(scope="module")
def problem():
    return MPCProblem(Wrist.of(second_law_set()))


def test_derivatives_along_a_plan_are_those_of_finite_differences(problem):
    c, start = coefficients(problem.wrist), np.array(tree.leaves(problem.wrist.rest()), float)
    found = linearise(problem, c, problem.stage_weights, problem.move_hessian, start, 0.0, PLAN)
    response = problem.wrist.simulate(np.repeat(PLAN, problem.substeps)).angle
    assert np.abs(response[problem.substeps :: problem.substeps] - found.angles).max() < 1e-11

    def moved(at: np.ndarray, plan: np.ndarray) -> np.ndarray:
        return roll(problem, c, at, 0.0, plan)[:, -1]

    def difference(i: int, of_plan: bool) -> np.ndarray:
        by = SMALL * np.eye(len(PLAN) if of_plan else len(start))[i]
        both = [moved(start, PLAN + d) if of_plan else moved(start + d, PLAN) for d in (by, -by)]
        return (both[0] - both[1]) / (2.0 * SMALL)

    for k in (0, 8, 12, 29):
        assert np.abs(found.by_command[:, k] - difference(k, True)).max() < 1e-6
    for column, leaf in enumerate(differentiated(problem.shape)):
        assert np.abs(found.by_start[:, column] - difference(leaf, False)).max() < 1e-6
    assert np.abs(found.by_start).max(axis=0).min() > 1e-3


@pytest.mark.parametrize("make", [linear_mpc, real_time_mpc])
@pytest.mark.parametrize(("start", "reference"), [("virgin", 15.0), ("line1", -15.0)])
def test_it_settles_a_step_of_its_own_plant_within_half_a_second(problem, make, start, reference):
    wrist = problem.wrist
    went = loop.run(wrist, make(problem), reference, wrist.rest(start, 0.0), duration=2.0)
    assert {p.rung for p in went.periods} == {"solved"}
    assert went.metrics.settling_time_s[0] < 0.5
    assert went.metrics.overshoot_percent[0] < 3.0


def test_the_hybrid_plan_says_that_it_needs_four_segments(problem):
    believed = begin(0.0, 100.0, problem.wrist)
    with pytest.raises(InputError, match="four straight segments, not 'prandtl-ishlinskii'"):
        hybrid.solve(problem, believed, 2.0, 15.0)
