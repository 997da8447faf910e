"""Convex programs: solved by one solver, retried with another, and never trusted beyond their status."""

import warnings
from threading import Lock
from typing import Any

SOLVERS = ("CLARABEL", "SCS")
"""Tried in this order; both come with cvxpy, both under permissive licences."""

SETTINGS: dict[str, dict[str, Any]] = {
    "CLARABEL": {},
    "SCS": {"eps_abs": 1e-8, "eps_rel": 1e-8, "max_iters": 20_000},  # its defaults leave 1e-4
}

_FILTERS = Lock()
"""Which warnings are shown is one for the whole process: of two threads that put it aside at once, one would
put back what the other had set."""


class Unsolved(Exception):
    """No solver came to an end; the message names each and what it said."""


def solve(problem: Any, solvers: tuple[str, ...] = SOLVERS) -> str:
    """Solve a cvxpy problem in place; the name of the solver that did.

    A status of ``optimal_inaccurate`` counts as solved, since what is claimed of a solution is
    checked outside the solver.  Raises Unsolved where each solver failed or called the problem
    infeasible or unbounded.
    """
    import cvxpy

    said = []
    for name in solvers:
        try:
            with _FILTERS, warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of inaccuracy, which the status tells too
                problem.solve(solver=name, **SETTINGS.get(name, {}))
        except (cvxpy.error.SolverError, ArithmeticError, ValueError) as error:
            said.append(f"{name}: {str(error).splitlines()[0]}")
            continue
        if problem.status in ("optimal", "optimal_inaccurate"):
            return name
        said.append(f"{name}: {problem.status}")
        if problem.status in ("infeasible", "unbounded"):
            break  # an answer, not a failure
    raise Unsolved("; ".join(said))
