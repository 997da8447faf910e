"""Numbers that are sought, and matrices linear in them, as a convex program.

A matrix that is linear in the unknowns is an array (unknowns, m, m): cvxpy is handed the finished arrays, for
its own algebra takes longer than the solver.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.synthesis import convex

Array = NDArray[np.float64]

LEAST_MARGIN = 1e-6
"""By how much every inequality has to hold, as a share of the function's size, where that is not the goal."""


@dataclass(frozen=True)
class UnknownForm:
    """A `WindowForm` over the scaled vector, linear in the unknowns: P (unknowns, n, n), the rest
    (unknowns,)."""

    P: Array
    popov: Array
    S: Array
    R: Array


class MemoryUnknowns:
    """Numbers that are sought, handed out one after the other; `positive`: those not below 0."""

    def __init__(self, n: int, forms: int, numbers: int) -> None:
        self.n, self.count = n, forms * (n * (n + 1) // 2 + 3) + numbers
        self.used, self.positive = 0, list[int]()

    def vector(self, count: int) -> Array:
        """Numbers of any sign, (unknowns, count)."""
        found = np.zeros((self.count, count))
        found[range(self.used, self.used + count), range(count)] = 1.0
        self.used += count
        return found

    def number(self) -> Array:
        """A number that is not negative, (unknowns,)."""
        self.positive.append(self.used)
        return self.vector(1)[:, 0]

    def form(self) -> UnknownForm:
        """A function."""
        P = np.zeros((self.count, self.n, self.n))
        for i in range(self.n):
            for j in range(i + 1):
                P[self.used, i, j] = P[self.used, j, i] = 1.0
                self.used += 1
        return UnknownForm(P, self.number(), self.number(), self.number())


@dataclass(frozen=True)
class Program:
    """Matrices (unknowns, m, m) that are to be positive by the margin, numbers (unknowns,) that are not to be
    negative, the function's size.  Without `at` the margin is sought at the size n; else the least sum of the
    larger of the values `at` states, two arrays (unknowns, states), the one matrix of `floor` being no less
    than the other, and the margin a small share of the size."""

    unknowns: MemoryUnknowns
    matrices: list[Array]
    apart: list[Array] | None = None
    size: Any = None
    floor: tuple[Array, Array] | None = None
    at: tuple[Array, Array] | None = None

    def solve(self) -> tuple[Array, float, str]:
        """The unknowns, the margin, the solver; raises `convex.Unsolved`."""
        import cvxpy
        from cvxpy.atoms.affine.sum import sum as total
        from cvxpy.atoms.elementwise.maximum import maximum

        u = self.unknowns
        x, margin = cvxpy.Variable(u.count), cvxpy.Variable()
        constraints: list[Any] = [x[u.positive] >= 0.0, x @ self.size >= 0.0]
        constraints += [x @ a >= 0.0 for a in self.apart or []]
        constraints += [_matrix(x, m) - margin * np.eye(m.shape[1]) >> 0.0 for m in self.matrices]
        if self.at is None or self.floor is None:
            goal = cvxpy.Maximize(margin)
            constraints.append(x @ self.size == float(u.n))
        else:
            goal = cvxpy.Minimize(total(maximum(x @ self.at[0], x @ self.at[1])))
            constraints.append(margin == LEAST_MARGIN / u.n * (x @ self.size))
            constraints.append(_matrix(x, self.floor[0]) - self.floor[1] >> 0.0)
        solver = convex.solve(cvxpy.Problem(goal, constraints))
        return np.asarray(x.value, float), float(np.asarray(margin.value)), solver


def _matrix(x: Any, of: Array) -> Any:
    """The symmetric matrix sum_k x_k of_k."""
    from cvxpy.atoms.affine.reshape import reshape

    m = of.shape[1]
    symmetric = 0.5 * (of + of.transpose(0, 2, 1))
    return reshape(symmetric.reshape(len(of), -1).T @ x, (m, m), order="C")
