"""Quadratic functions that prove switched linear systems stable.

A proof is a positive definite function V that loses more than `loss` V per unit of time, whatever i:
V+ - V < -dt loss V, or dV/dt < -loss V.  The solver proposes P; eigenvalues in NumPy decide.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.reasons import NoneOfThisKind, NoSolver
from design.robustness.certificates.sampled.switched import Switched, scaled
from design.synthesis.convex import Unsolved, solve

Array = NDArray[np.float64]

CONFIRMED = 1e-9
"""Least margin, as a share, of an inequality that counts as confirmed: well above what rounding does."""

INSIDE = 200
"""Random points of the convex hull at which a quadratic function is checked beside the vertices."""


BACKED = 0.2
"""How far `rounded` stays from the best ellipsoid, as a share of what the slowest mode would allow."""


@dataclass(frozen=True)
class SwitchedCertificate:
    """A function that loses `loss` per unit of time, or what kept it from being found.

    margin: of the check outside the solver: the least eigenvalue of the worst inequality as a share of
    the largest, in states in which P is the identity; the proof holds where it exceeds `CONFIRMED`.
    shapes: P, or P_i of each mode, each (n, n), positive definite; weights: s and r of a window
    (`lifted.window_quadratic`); reason: why it does not hold.
    """

    loss: float
    rate: float
    margin: float
    solver: str = ""
    shapes: tuple[Array, ...] = ()
    reason: NoSolver | NoneOfThisKind | None = None
    weights: tuple[float, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether the check confirmed it."""
        return self.margin > CONFIRMED


Search = Callable[[float], SwitchedCertificate]
"""Looks for a function that loses at least so much per unit of time."""


def common_quadratic(system: Switched) -> Search:
    """Search for V = x'Px common to all modes: M'P + PM + dt M'PM < -loss P for every M.

    The program asks for the largest t with P > t and every inequality by t, trace P given: it always
    has a solution, so that "there is none" and "the solver failed" cannot be confused.  In lifted
    states it searches for a form of a higher degree.
    """
    import cvxpy

    n, size = len(system.generators[0]), _size(system)
    p, t = cvxpy.Variable((n, n), symmetric=True), cvxpy.Variable()
    loss = cvxpy.Parameter()
    constraints: list[Any] = [p >> t * np.eye(n), sum(p[k, k] for k in range(n)) == n]
    slack = [cvxpy.Variable(len(system.ties)) if system.ties else None for _ in system.generators]
    for m, free in zip(system.generators, slack, strict=True):
        left = -_drift(m, p, system.dt) / size - loss * p
        if free is not None:
            left = left + sum(free[k] * tie for k, tie in enumerate(system.ties))
        constraints.append((left + left.T) / 2.0 >> t * np.eye(n))
    problem = cvxpy.Problem(cvxpy.Maximize(t), constraints)

    def confirm(wanted: float) -> tuple[tuple[Array, ...], float]:
        mixes = [np.zeros(0) if free is None else np.asarray(free.value) * size for free in slack]
        shape = np.asarray(p.value, float)
        return (shape,), common_margin(system, shape, wanted, mixes)

    return _searching(system, problem, loss, t, confirm, "P")


def _searching(
    system: Switched,
    problem: Any,
    loss: Any,
    best: Any,
    confirm: Callable[[float], tuple[tuple[Array, ...], float]],
    what: str,
) -> Search:
    """A search that sets the parameter `loss` of a program, solves it, and has `confirm` tell the matrices
    that were found and their margin at a loss; best: the variable that is positive where it has `what`."""
    size = _size(system)

    def search(wanted: float) -> SwitchedCertificate:
        loss.value = wanted / size
        rate = system.rate(wanted)
        try:
            solver = solve(problem)
        except Unsolved as error:
            return SwitchedCertificate(wanted, rate, -1.0, reason=NoSolver(str(error)))
        shapes, margin = confirm(wanted)
        none = None if margin > CONFIRMED else NoneOfThisKind(solver, number(best), what)
        return SwitchedCertificate(wanted, rate, margin, solver, shapes, none)

    return search


def common_margin(
    system: Switched, p: Array, loss: float, mixes: list[Array] | None = None, seed: int = 1
) -> float:
    """Margin of a common quadratic function, by eigenvalues alone; -1 where P is not positive definite.

    Checked at the vertices and, for a system that is not lifted, at random points of their convex hull
    (a lift is not linear in its matrix; there the hull is covered by the theorem that a set of matrices
    and its convex hull have the same joint spectral radius: Jungers 2009, The Joint Spectral
    Radius).  mixes: weights of the ties at each vertex, each (ties,).
    """
    if not definite(p):
        return -1.0
    root = np.linalg.inv(np.linalg.cholesky(p))
    worst = np.inf
    for k, m in enumerate(system.generators):
        left = -_drift(m, p, system.dt) - loss * p
        if mixes is not None and system.ties:
            left = left + np.tensordot(mixes[k], np.array(system.ties), 1)
        worst = min(worst, share_of_least(root @ left @ root.T))
    if system.degree == 1:
        for w in np.random.default_rng(seed).dirichlet(np.full(len(system.generators), 0.5), INSIDE):
            m = np.tensordot(w, np.array(system.generators), 1)
            worst = min(worst, share_of_least(root @ (-_drift(m, p, system.dt) - loss * p) @ root.T))
    return float(worst)


def poly_quadratic(system: Switched) -> Search:
    """Search for V = x'P(i)x that follows the mode: A_i' P_j A_i < (1 - dt loss) P_i for every i, j.

    Daafouz & Bernussou, Systems & Control Letters 43 (2001) 355, for a sampled system only.  With
    P(w) = sum w_i P_i it holds on the whole polytope A(w) = sum w_i A_i, since by Schur complement
    [P_i, A_i'P_j; P_j A_i, P_j] > 0 is linear in what carries i and in what carries j; their slack
    form, with S_i = 1/P_i, is solvable exactly where this one is, and needed only where gains are
    sought.  P_i = P + dt D_i keeps it well conditioned; it also shows that at a short sample time all
    P_i are nearly equal where the mode may change at every sample, so that little is gained there.
    Raises ValueError for a system in continuous time.
    """
    import cvxpy

    if system.dt <= 0.0:
        raise ValueError("poly_quadratic: needs a sampled system; in continuous time all P_i are equal")
    n, modes, size, dt = len(system.generators[0]), len(system.generators), _size(system), system.dt
    p, t, loss = cvxpy.Variable((n, n), symmetric=True), cvxpy.Variable(), cvxpy.Parameter()
    extra = [cvxpy.Variable((n, n), symmetric=True) for _ in range(modes)]
    each = [p + dt * size * d for d in extra]
    constraints: list[Any] = [
        sum(p[k, k] for k in range(n)) == n,
        sum(extra) == 0.0,
        *(q >> t * np.eye(n) for q in each),
    ]
    for i, m in enumerate(system.generators):
        for j in range(modes):
            left = -_drift(m, each[j], dt) / size - (extra[j] - extra[i]) - loss * each[i]
            constraints.append((left + left.T) / 2.0 >> t * np.eye(n))
    problem = cvxpy.Problem(cvxpy.Maximize(t), constraints)

    def confirm(wanted: float) -> tuple[tuple[Array, ...], float]:
        shapes = tuple(np.asarray(q.value, float) for q in each)
        return shapes, poly_margin(system, shapes, wanted)

    return _searching(system, problem, loss, t, confirm, "P_i")


def poly_margin(system: Switched, shapes: tuple[Array, ...], loss: float, seed: int = 1) -> float:
    """Margin of a poly-quadratic function at every pair of vertices and at random pairs of points of
    the polytope, by eigenvalues alone; -1 where one P_i is not positive definite."""
    if not all(definite(p) for p in shapes):
        return -1.0
    ends = np.eye(len(shapes))
    inside = np.random.default_rng(seed).dirichlet(np.full(len(shapes), 0.5), (INSIDE, 2))
    pairs = [(v, w) for v in ends for w in ends] + [(v, w) for v, w in inside]
    every, generators = np.array(shapes), np.array(system.generators)
    worst = np.inf
    for now, then in pairs:
        m, p, after = (np.tensordot(w, of, 1) for w, of in ((now, generators), (now, every), (then, every)))
        left = -_drift(m, after, system.dt) - (after - p) / system.dt - loss * p
        root = np.linalg.inv(np.linalg.cholesky(p))
        worst = min(worst, share_of_least(root @ left @ root.T))
    return float(worst)


def best(search: Search, low: float, high: float, steps: int = 14) -> SwitchedCertificate:
    """The function that loses most, by bisection between two losses, in ratios where both are positive;
    what was found at `low` if not even that holds.  Only what the check confirmed counts."""
    held = search(low)
    if not held.holds:
        return held
    for _ in range(steps):
        middle = float(np.sqrt(low * high)) if low > 0.0 else (low + high) / 2.0
        tried = search(middle)
        low, high, held = (middle, high, tried) if tried.holds else (low, middle, held)
    return held


def rounded(system: Switched) -> tuple[Switched, Array]:
    """The system in states in which no mode adds more to |x| than in others, as nearly as a bisection
    finds, and T, x = T times such a state: what forms of a higher degree are best searched for in."""
    found, back = scaled(system)
    drifts = [np.eye(len(m)) + found.dt * m for m in found.generators]
    if found.dt == 0.0:
        low = -max(float(np.linalg.eigvalsh(m + m.T)[-1]) for m in found.generators)
    else:
        low = (1.0 - max(float(np.linalg.norm(a, 2)) for a in drifts) ** 2) / found.dt
    high = float(np.min(found.fates))
    search = common_quadratic(found)
    form = best(search, low - 0.01 * (high - low) - 1e-9, high, 7)
    # At its best the ellipsoid is at the edge of what is possible, and may be thin as a needle.
    form = search(form.loss - BACKED * (high - form.loss))
    if not form.holds:
        return found, back
    turn = np.linalg.inv(np.linalg.cholesky(form.shapes[0])).T
    moved = tuple(np.asarray(np.linalg.solve(turn, m @ turn), float) for m in found.generators)
    return replace(found, generators=moved), back @ turn


def definite(p: Array) -> bool:
    """Whether a symmetric matrix is positive definite beyond rounding."""
    values = np.linalg.eigvalsh((p + p.T) / 2.0)
    return bool(values[0] > 1e-12 * values[-1])


def share_of_least(matrix: Array) -> float:
    """Least eigenvalue of a symmetric matrix as a share of its norm."""
    values = np.linalg.eigvalsh((matrix + matrix.T) / 2.0)
    return float(values[0] / max(np.max(np.abs(values)), 1e-300))


def _drift(m: Any, p: Any, dt: float) -> Any:
    """(A'PA - P)/dt of A = 1 + dt M."""
    return m.T @ p + p @ m + dt * (m.T @ p @ m)


def _size(system: Switched) -> float:
    """A rate that the generators are measured by."""
    return max([float(np.linalg.norm(m, 2)) for m in system.generators] + [1e-12])


def number(variable: Any) -> float:
    """Value of a scalar variable that was solved for."""
    return float(variable.value)
