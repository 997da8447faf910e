"""The QPs of the MPCs are solved to the optimality conditions, whatever the guess of the active set."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from design.mpc import qp


def problem(seed: int):
    rng = np.random.default_rng(seed)
    J = np.tril(rng.normal(size=(12, 12)))
    D = np.eye(12) - np.eye(12, k=-1)
    H = J.T @ J + 0.05 * D.T @ D
    f = rng.normal(size=12) * 3.0
    low = np.concatenate([np.full(12, -1.0), np.full(12, -0.7)])
    return H, f, low, -low, D


def test_optimality_conditions_hold():
    for seed in range(20):
        H, f, low, high, D = problem(seed)
        found = qp.solver(D)(H, f, low, high, np.zeros(24, dtype=np.int32))
        assert found.found
        A = np.vstack([np.eye(12), D])
        values = A @ found.x
        assert (values >= low - 1e-6).all()
        assert (values <= high + 1e-6).all()
        upper, lower = found.active == qp.AT_UPPER, found.active == qp.AT_LOWER
        assert upper.any() or lower.any()
        # Stationary with multipliers of the right sign on the active constraints alone.
        signed = np.concatenate([A[upper], -A[lower]])
        fit = lsq_linear(signed.T, -(H @ found.x + f), bounds=(0.0, np.inf))
        assert np.abs(signed.T @ fit.x + H @ found.x + f).max() < 1e-6
        assert np.abs(values[upper] - high[upper]).max(initial=0.0) < 1e-6
        assert np.abs(values[lower] - low[lower]).max(initial=0.0) < 1e-6


def test_the_answer_does_not_depend_on_the_guess_nor_on_what_was_solved_before():
    rng = np.random.default_rng(5)
    H, f, low, high, D = problem(3)
    solve = qp.solver(D)
    first = solve(H, f, low, high, np.zeros(24, dtype=np.int32))
    for seed in range(10):
        other = problem(seed + 50)
        solve(*other[:4], np.zeros(24, dtype=np.int32))
        guess = rng.choice([0, 0, qp.AT_UPPER, qp.AT_LOWER], 24).astype(np.int32)
        again = solve(H, f, low, high, guess)
        assert again.found
        assert np.abs(again.x - first.x).max() < 1e-8


def test_an_infeasible_problem_is_said_to_be_and_does_no_lasting_harm():
    H, f, low, high, D = problem(1)
    solve = qp.solver(D)
    idle = np.zeros(24, dtype=np.int32)
    good = solve(H, f, low, high, idle)
    impossible = low.copy()
    impossible[12], top = 5.0, high.copy()
    top[12] = 6.0
    bad = solve(H, f, impossible, top, idle)
    assert not bad.found
    assert "infeasible" in bad.reason
    assert np.abs(solve(H, f, low, high, idle).x - good.x).max() < 1e-9


def test_the_guess_for_the_next_period_is_that_of_this_one_a_step_on():
    assert qp.shifted(np.arange(10, dtype=np.int32), 5).tolist() == [1, 2, 3, 4, 4, 6, 7, 8, 9, 9]


class Failing:
    """A model of daqp that fails with a flag, at its setup or at its solution."""

    def __init__(self, setup, solution):
        self.flags = setup, solution

    def setup(self, *_):
        return (self.flags[0],)

    def solve(self):
        return np.zeros(2), 0.0, self.flags[1], {"iterations": 7, "lam": np.zeros(4)}


@pytest.mark.parametrize(
    ("flag", "words"),
    [
        (-1, "infeasible"),
        (-2, "cycling"),
        (-3, "unbounded"),
        (-4, "iteration limit"),
        (-5, "not convex"),
        (-6, "start not feasible"),
        (-99, "daqp says -99"),
        (0, "daqp says 0"),
    ],
)
def test_why_nothing_was_found_is_said_as_daqp_means_it(monkeypatch, flag, words):
    """Its exit flags, of `daqp/constants.h`."""
    for setup, solution in ((flag, 1), (1, flag)) if flag < 0 else ((1, flag),):
        module = SimpleNamespace(Model=lambda: Failing(setup, solution))  # noqa: B023
        monkeypatch.setitem(sys.modules, "daqp", module)
        solve = qp.solver(np.eye(2))
        found = solve(np.eye(2), np.ones(2), -np.ones(4), np.ones(4), np.ones(4, np.int32))
        assert (found.found, found.reason) == (False, words)
        assert found.iterations == (7 if setup == 1 else 0)
        assert not found.active.any()
