"""The dense QP of a period, by daqp, a dual active-set method that starts from a guess of the active set.

Arnstrom, Bemporad & Axehill, IEEE Trans. Automatic Control 67 (2022) 4362, doi 10.1109/TAC.2022.3176430.
"""

from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plants.errors import InputError

Array = NDArray[np.float64]
Active = NDArray[np.int32]

AT_UPPER, AT_LOWER = 1, 3
"""How daqp marks a constraint that is active at its upper, its lower bound."""


class QPSolution(NamedTuple):
    """Minimiser, which constraints are active there (as daqp marks them), and whether it was found; how
    many iterations it took, and why it was not found."""

    x: Array
    active: Active
    found: bool
    iterations: int
    reason: str


Solve = Callable[[Array, Array, Array, Array, Active], QPSolution]
"""``(H, f, low, high, active) -> QPSolution``, minimising x'Hx/2 + f'x, low <= (x, A x) <= high."""

_REASONS = {-1: "infeasible", -2: "cycling", -3: "unbounded", -4: "iteration limit", -5: "not convex",
            -6: "start not feasible", -7: "time limit"}  # fmt: skip


def _daqp() -> Any:
    try:
        return import_module("daqp")
    except ModuleNotFoundError:
        raise InputError(
            "the MPC needs the QP solver daqp: pip install daqp, or compare without MPC"
        ) from None


def solver(A: Array) -> Solve:
    """A solver for problems whose constraint matrix is A.

    It keeps a workspace, which holds nothing that an answer depends on: each call is given its guess
    of the active set, and a Hessian is factorised again unless it is the very array of the call before.
    Raises InputError where daqp is not installed.
    """
    model = _daqp().Model()
    last: list[Any] = [None]
    matrix = np.ascontiguousarray(A, float)

    def solve(H: Array, f: Array, low: Array, high: Array, active: Active) -> QPSolution:
        if last[0] is None:
            flag = model.setup(H, f, matrix, high, low, active.copy())[0]
        elif last[0] is H:
            flag = model.update(f=f, bupper=high, blower=low, sense=active.copy())
        else:
            flag = model.update(H=H, f=f, bupper=high, blower=low, sense=active.copy())
        last[0] = H
        if flag < 0:
            last[0] = None
            return QPSolution(f, active * 0, False, 0, _REASONS.get(flag, f"daqp says {flag}"))
        x, _, flag, info = model.solve()
        if flag < 1 or not np.isfinite(x).all():
            last[0] = None  # whatever state that left behind goes with it
            return QPSolution(
                x, active * 0, False, info["iterations"], _REASONS.get(flag, f"daqp says {flag}")
            )
        lam = info["lam"]
        marks = np.where(lam > 0.0, AT_UPPER, np.where(lam < 0.0, AT_LOWER, 0)).astype(np.int32)
        return QPSolution(np.array(x), marks, True, info["iterations"], "")

    return solve


def shifted(active: Active, horizon: int) -> Active:
    """The guess of the active set one period later."""
    bounds, changes = active[:horizon], active[horizon:]
    return np.concatenate([bounds[1:], bounds[-1:], changes[1:], changes[-1:]]).astype(np.int32)
