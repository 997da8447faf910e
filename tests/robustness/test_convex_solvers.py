"""A convex program goes to the next solver where one fails, and to none where it has no solution."""

import cvxpy as cp
import pytest

from design.synthesis.convex import Unsolved, solve


def square():
    x = cp.Variable()
    return x, cp.Problem(cp.Minimize((x - 3.0) ** 2), [x <= 2.0])


def test_a_solver_that_is_not_there_is_followed_by_the_next():
    x, problem = square()
    assert solve(problem, ("NO_SUCH_SOLVER", "CLARABEL")) == "CLARABEL"
    assert float(x.value) == pytest.approx(2.0, abs=1e-6)


def test_where_all_fail_each_is_named():
    _, problem = square()
    with pytest.raises(Unsolved) as said:
        solve(problem, ("NO_SUCH_SOLVER", "NOR_THIS"))
    assert "NO_SUCH_SOLVER" in str(said.value)
    assert "NOR_THIS" in str(said.value)


def test_infeasible_is_an_answer_and_not_retried():
    x = cp.Variable()
    with pytest.raises(Unsolved, match=r"^CLARABEL: infeasible$"):
        solve(cp.Problem(cp.Minimize(x), [x >= 1.0, x <= 0.0]))


def test_unbounded_is_an_answer_too():
    x = cp.Variable()
    with pytest.raises(Unsolved, match="unbounded"):
        solve(cp.Problem(cp.Minimize(x)))
