"""Linear matrix inequalities in a quadratic form and a few numbers, solved for the largest margin.

Each reads state' P rate + rate' P state + sum of number x matrix < 0 as a quadratic form in one
vector, `state` and `rate` being rows over it.  What a solver says of it is never the last word: see
`design.robustness.certificates.continuous.check`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.synthesis import convex

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Inequality:
    """state, rate (n, m): rows; shared: matrices (m, m) that numbers common to all inequalities
    multiply, by name; own: matrix that a number of this inequality alone, not negative, multiplies."""

    state: Array
    rate: Array
    shared: Mapping[str, Array] = field(default_factory=dict)
    own: Array | None = None


@dataclass(frozen=True)
class Solution:
    """P (n, n), the shared numbers by name, the own ones in the order of the inequalities, the margin
    that the solver claims in the scaled vector, and its name."""

    P: Array
    shared: dict[str, float]
    own: tuple[float, ...]
    margin: float
    solver: str


@dataclass(frozen=True)
class Unknowns:
    """The same as cvxpy expressions over the scaled vector, and constraints on them; `form` is what must
    be positive, `margin` what every inequality holds by, `size` (n,) the scale of the states."""

    P: Any
    form: Any
    shared: dict[str, Any]
    own: list[Any]
    margin: Any
    constraints: list[Any]
    size: Array

    def solution(self, solver: str) -> Solution:
        """What the last solver left in the variables, in the unscaled vector."""
        P = np.asarray(self.P.value, float)
        return Solution(
            0.5 * (P + P.T) / np.outer(self.size, self.size),
            {n: float(v.value) for n, v in self.shared.items()},
            tuple(float(v.value) for v in self.own),
            float(self.margin.value),
            solver,
        )


def unknowns(
    inequalities: Sequence[Inequality],
    scale: Array,
    bound: Mapping[str, Array] | None = None,
    least: Sequence[Mapping[str, float]] = (),
) -> Unknowns:
    """The inequalities as a convex program without its objective.

    scale (m,): sizes of the entries of the vector, of which the first n are the states; bound:
    matrices (n, n) that make P + sum of number x matrix positive; least: sums of the shared numbers
    that are not negative.
    """
    import cvxpy

    n = inequalities[0].state.shape[0]
    size, eye = scale[:n], np.eye(n)
    names = list(dict.fromkeys(name for i in inequalities for name in i.shared))
    P = cvxpy.Variable((n, n), symmetric=True)
    # Each number in the size that makes its matrix one of order one.
    units = {m: _unit(next(i.shared[m] for i in inequalities if m in i.shared), scale) for m in names}
    shared = {name: cvxpy.Variable(nonneg=True) / units[name] for name in names}
    margin = cvxpy.Variable()
    own = []
    form = P
    for name, matrix in (bound or {}).items():
        form = form + shared[name] * (matrix * np.outer(size, size))
    constraints = [form >> margin * eye]
    for i in inequalities:
        state, rate = i.state * scale / size[:, None], i.rate * scale / size[:, None]
        total = state.T @ P @ rate
        total = total + total.T
        for name, matrix in i.shared.items():
            total = total + shared[name] * (matrix * np.outer(scale, scale))
        if i.own is not None:
            own.append(cvxpy.Variable(nonneg=True) / _unit(i.own, scale))
            total = total + own[-1] * (i.own * np.outer(scale, scale))
        constraints.append(total << -margin * np.eye(len(scale)))
    constraints += [sum(c * shared[name] for name, c in of.items()) >= 0 for of in least]
    return Unknowns(P, form, shared, own, margin, constraints, size)


def _unit(matrix: Array, scale: Array) -> float:
    return float(np.abs(matrix * np.outer(scale, scale)).max()) or 1.0


def widest(u: Unknowns, solvers: tuple[str, ...] = convex.SOLVERS) -> Solution:
    """The solution of largest margin among those whose positive form has the trace n; raises
    `design.synthesis.convex.Unsolved`."""
    import cvxpy

    n = u.P.shape[0]
    trace = sum(u.form[i, i] for i in range(n))
    problem = cvxpy.Problem(cvxpy.Maximize(u.margin), [*u.constraints, trace == n])
    return u.solution(convex.solve(problem, solvers))


def widest_within(u: Unknowns, start: Array, weights: Mapping[str, float], planes: Array) -> Solution:
    """The solution of largest margin whose ellipsoid lies between planes and holds a start.

    start (n,): X' P X + the sum of weight x number is at most 1 there; planes (m, n): |g X| <= 1
    wherever the positive form is at most 1.  Raises `design.synthesis.convex.Unsolved`, where there is none
    too.
    """
    import cvxpy

    at = start / u.size
    inside = at @ u.P @ at + sum(w * u.shared[name] for name, w in weights.items() if name in u.shared)
    constraints = [*u.constraints, inside <= 1.0]
    wider = np.eye(len(start), len(start) + 1)
    for g in planes * u.size:
        border = np.block([[np.zeros((len(g), len(g))), g[:, None]], [g[None, :], np.ones((1, 1))]])
        constraints.append(wider.T @ u.form @ wider + border >> 0)  # Schur: g Q^-1 g <= 1
    return u.solution(convex.solve(cvxpy.Problem(cvxpy.Maximize(u.margin), constraints)))
