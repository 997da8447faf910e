"""Guaranteed-cost state feedback for all branches and both regulator rates, by a semidefinite program.

Of all w = K x it is the one with the least bound on

    integral of (r - y)^2 + damping (h - y)^2 + lack q^2 + effort w^2  dt

for the wrist without offsets (`design.robustness.loop_model`: x = (r - y, h - y, q), A linear in the
slope and in the rate) whose slope and rate wander between the vertices {transit, lines} x {k_slow,
k_fast} as they like.  With Q = P^-1, Y = K Q and W, R the weights, the vertex i gives

    [ A_i Q + B Y + (.)'   (W^1/2 Q)'   (R^1/2 Y)' ]
    [ W^1/2 Q              -1            0         ]   <= 0,
    [ R^1/2 Y               0           -1         ]

and x' P x bounds the cost from x.  Slope 0 is no vertex: on the virgin curve the angle does not follow
the pressure, and no feedback could be shown to work.  Boyd, El Ghaoui, Feron & Balakrishnan, Linear Matrix
Inequalities in System and Control Theory (SIAM, 1994), doi 10.1137/1.9781611970777.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.synthesis.convex import Unsolved, solve
from plants.linearisation import branch_slopes
from plants.wrist import Wrist

Array = NDArray[np.float64]

STARTS = (1.0, 0.1, 0.1)
"""Squares of the states [deg^2, deg^2, kPa^2] over which the bound is taken: an error of the angle, and
a little of the others, without which the bound from a step alone would leave their price open."""

INTO = np.array([[0.0], [0.0], [1.0]])
"""B: the speed of the command moves q."""

_ONE = Lock()
"""The program is one for the whole process, and motions are designed side by side."""

SLACK = 1e-6
"""How far inside its inequalities the program is solved, so that rounding does not leave them."""


@dataclass(frozen=True)
class LQIWeights:
    """Prices [1 / (deg^2 s)] beside that of the squared error: damping of (h - y)^2, lack [deg^2/kPa^2] of
    q^2, effort [deg^2 s^2/kPa^2] of w^2; all positive."""

    damping: float
    lack: float
    effort: float

    @property
    def matrix(self) -> Array:
        """W, (3, 3)."""
        return np.diag([1.0, self.damping, self.lack])


@dataclass(frozen=True)
class Feedback:
    """State feedback w = gains @ x and what is guaranteed of it.

    gains (3,): [kPa/(deg s), kPa/(deg s), 1/s]; bound (3, 3): P, where x' P x is at least the cost from x;
    decay [1/s]: every trajectory of the class decays at least as fast, in the norm of P; margin: least
    eigenvalue of -(A' P + P A) over the vertices, as a share of its largest; both from NumPy alone.
    """

    gains: Array
    bound: Array
    decay: float
    margin: float
    solver: str

    @property
    def holds(self) -> bool:
        """Whether the check outside the solver confirmed it."""
        return self.margin > 0.0 and bool(np.linalg.eigvalsh(self.bound).min() > 0.0)

    @property
    def jump(self) -> float:
        """The jump of the command [kPa] per degree of a step for which the bound is least."""
        return float(-self.bound[2, 0] / self.bound[2, 2])


def vertices(wrist: Wrist) -> list[tuple[float, float]]:
    """Slope [deg/kPa] and rate [1/s] at every vertex, without repetition."""
    p = wrist.regulator
    slopes = dict.fromkeys(branch_slopes(wrist, wrist.reach).values())
    return [(s, float(k)) for s in slopes for k in dict.fromkeys((p.k_slow, p.k_fast))]


def plant(slope: float, rate: float, Tw: float) -> Array:
    """A of dx/dt = A x + B w, (3, 3)."""
    return np.array([[0.0, -1.0 / Tw, 0.0], [0.0, -1.0 / Tw, slope * rate], [0.0, 0.0, -rate]])


def synthesise(wrist: Wrist, weights: LQIWeights) -> Feedback:
    """The feedback of least guaranteed cost.  Raises design.synthesis.convex.Unsolved where there is none,
    or no solver finds it.

    >>> found = synthesise(Wrist.flexion(), LQIWeights(damping=1.0, lack=0.01, effort=0.01))
    >>> found.holds, found.gains.round(0)
    (True, array([ 51., -51., -15.]))
    """
    corners, Tw = tuple(vertices(wrist)), float(wrist.Tw)
    root = _scale(corners, Tw, weights)
    back = np.linalg.inv(root.T)
    with _ONE:
        problem, given, (Q, Y) = _program(len(corners))
        for place, corner in zip(given.moves, corners, strict=True):
            place.value = root.T @ plant(*corner, Tw) @ back
        given.into.value = root.T @ INTO / np.sqrt(weights.effort)
        given.price.value = np.sqrt(weights.matrix) @ back
        given.starts.value = root.T @ np.diag(STARTS) @ root
        solver = solve(problem)
        scaled, solved = np.linalg.inv(Q.value), Y.value
    gains = (solved @ scaled @ root.T)[0] / np.sqrt(weights.effort)
    bound = root @ (0.5 * (scaled + scaled.T)) @ root.T
    return checked(corners, Tw, weights, gains, bound, solver)


def _scale(corners: Sequence[tuple[float, float]], Tw: float, weights: LQIWeights) -> Array:
    """L of P = L L', the linear-quadratic regulator's at the middle of the vertices, (3, 3): in L' x the
    sought P is of the size of 1, without which the solver would leave two digits.  Raises Unsolved where the
    Riccati equation has no solution to be found."""
    from scipy.linalg import solve_continuous_are

    slope, rate = np.exp(np.mean(np.log(corners), axis=0))
    middle = plant(float(slope), float(rate), Tw)
    try:
        root: Array = np.linalg.cholesky(solve_continuous_are(middle, INTO, weights.matrix, weights.effort))
    except np.linalg.LinAlgError as said:  # a gain or a rate that is next to nothing in its units
        raise Unsolved(f"the Riccati equation of the middle vertex: {said}") from None
    return root


class ProgramData(NamedTuple):
    """What the program leaves open: A of each vertex, B, the root of W, and the starts' squares."""

    moves: list[Any]
    into: Any
    price: Any
    starts: Any


@cache
def _program(corners: int) -> tuple[Any, ProgramData, tuple[Any, Any]]:
    """The program for a number of vertices, set up once for many plants and weights."""
    import cvxpy

    cp: Any = cvxpy
    Q, Z = cp.Variable((3, 3), symmetric=True), cp.Variable((3, 3), symmetric=True)
    Y = cp.Variable((1, 3))
    given = ProgramData(
        [cp.Parameter((3, 3)) for _ in range(corners)], cp.Parameter((3, 1)), cp.Parameter((3, 3)),
        cp.Parameter((3, 3)),
    )  # fmt: skip
    error = given.price @ Q
    limits = [cp.bmat([[Z, np.eye(3)], [np.eye(3), Q]]) >> 0]
    for move in given.moves:
        moved = move @ Q + given.into @ Y
        whole = cp.bmat([
            [moved + moved.T, error.T, Y.T],
            [error, -np.eye(3), np.zeros((3, 1))],
            [Y, np.zeros((1, 3)), -np.eye(1)],
        ])  # fmt: skip
        limits.append(0.5 * (whole + whole.T) << -SLACK * np.eye(7))
    return cp.Problem(cp.Minimize(cp.trace(given.starts @ Z)), limits), given, (Q, Y)


def checked(
    corners: tuple[tuple[float, float], ...],
    Tw: float,
    weights: LQIWeights,
    gains: Array,
    bound: Array,
    solver: str,
) -> Feedback:
    """What NumPy confirms of a feedback: P is enlarged by what the solver fell short by, so that it bounds
    the cost at every vertex, and therefore wherever slope and rate may be between them."""
    cost = weights.matrix + weights.effort * np.outer(gains, gains)
    factor, decay, margin = 1.0, np.inf, np.inf
    root = np.linalg.cholesky(bound) if np.linalg.eigvalsh(bound).min() > 0.0 else np.eye(3)
    for slope, rate in corners:
        a = plant(slope, rate, Tw)
        a[2] += gains
        falls = -(a.T @ bound + bound @ a)
        sizes = np.linalg.eigvalsh(falls)
        margin = min(margin, float(sizes[0] / np.abs(sizes).max()))
        if sizes[0] > 0.0:
            inner = np.linalg.inv(np.linalg.cholesky(falls))
            factor = max(factor, float(np.linalg.eigvalsh(inner @ cost @ inner.T)[-1]))
        back = np.linalg.inv(root)
        decay = min(decay, 0.5 * float(np.linalg.eigvalsh(back @ falls @ back.T)[0]))
    return Feedback(gains, factor * bound, decay, margin, solver)
