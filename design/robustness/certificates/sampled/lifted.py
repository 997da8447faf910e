"""Lyapunov functions that are quadratic in more than the state: forms, and functions of a window.

Homogeneous forms of degree 2d: the monomials of degree d of x, weighted so that |x^[d]| = |x|^d, move
linearly where x does, by the symmetric power of its matrix.  A quadratic function of them is a form of
degree 2d in x, and proves more than one of degree 2 (Brockett, Lie algebras and Lie groups in control
theory; Blondel & Nesterov 2005, doi 10.1137/040607009).  Different matrices belong to one form; using that
too makes the inequality a sum of squares (Parrilo & Jadbabaie, Approximation of the joint spectral radius
using sum of squares, Linear Algebra Appl. 428 (2008) 2385).

Behind a dead time of N samples: the state with moments of what is under way, instead of all of it.
"""

from dataclasses import dataclass
from itertools import combinations_with_replacement, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.reasons import NoneOfThisKind, NoSolver
from design.robustness.certificates.sampled.quadratic import (
    CONFIRMED,
    Search,
    SwitchedCertificate,
    best,
    common_quadratic,
    definite,
    number,
    rounded,
    share_of_least,
)
from design.robustness.certificates.sampled.switched import Switched, discrete, scaled
from design.robustness.certificates.sampled.words import Word, discrete_word
from design.synthesis.convex import Unsolved, solve

Array = NDArray[np.float64]

MOMENTS = 3
"""Moments of what is under way that a function of a delayed system knows of."""

INSIDE = 50
"""Random pairs of points of the polytope at which such a function is checked beside the vertices."""


def monomials(n: int, degree: int) -> Array:
    """Orthonormal basis of the symmetric tensors, shape (n^degree, number of monomials): the monomials
    of degree d in n variables, weighted by the root of their multinomial coefficient."""
    columns = {key: k for k, key in enumerate(combinations_with_replacement(range(n), degree))}
    found = np.zeros((n**degree, len(columns)))
    for row, key in enumerate(product(range(n), repeat=degree)):
        found[row, columns[tuple(sorted(key))]] = 1.0
    return np.asarray(found / np.linalg.norm(found, axis=0))


def power(matrix: Array, degree: int) -> Array:
    """Symmetric power of a matrix: (A x)^[d] = power(A, d) x^[d].

    >>> power(np.diag([2.0, 3.0]), 2).diagonal().round(9).tolist()
    [4.0, 6.0, 9.0]
    """
    found: Array = np.eye(1)
    for _ in range(degree):
        found = np.asarray(np.kron(found, matrix), float)
    basis = monomials(len(matrix), degree)
    return np.asarray(basis.T @ found @ basis)


def generator(matrix: Array, degree: int, dt: float = 0.0) -> Array:
    """Of the lifted system: x^[d] moves by dt generator(M, d, dt) x^[d] where x moves by dt M x, in the
    limit dt = 0 too.  dt [s], or whatever the matrix counts time in.

    >>> m, x = np.array([[-1.0, 2.0], [0.5, -3.0]]), np.eye(2)
    >>> np.allclose(power(x + 0.1 * m, 3), power(x, 3) + 0.1 * generator(m, 3, 0.1))
    True
    """
    # (1 + dt M) (x) ... - 1 without the difference of near equals: one factor after the other.
    n, total = len(matrix), np.zeros((1, 1))
    for _ in range(degree):
        total = np.kron(total, np.eye(n) + dt * matrix) + np.kron(np.eye(len(total)), matrix)
    basis = monomials(n, degree)
    return np.asarray(basis.T @ total @ basis)


def ties(n: int, degree: int) -> tuple[Array, ...]:
    """Basis of the symmetric L with z'Lz = 0 for every z = x^[d]: by how much a form leaves its
    matrix open.  None for two variables and degree 1."""
    keys = list(combinations_with_replacement(range(n), degree))
    weights = 1.0 / np.max(monomials(n, degree), axis=0)  # z = weight times monomial
    same: dict[tuple[int, ...], list[tuple[int, int]]] = {}
    for i, j in combinations_with_replacement(range(len(keys)), 2):
        same.setdefault(tuple(sorted(keys[i] + keys[j])), []).append((i, j))
    found = []
    for first, *others in same.values():
        for other in others:
            tie = np.zeros((len(keys), len(keys)))
            for (i, j), sign in ((first, 1.0), (other, -1.0)):
                tie[i, j] += sign / (weights[i] * weights[j])
                tie[j, i] += sign / (weights[i] * weights[j])
            found.append(tie / np.linalg.norm(tie))
    return tuple(found)


def lifted(system: Switched, degree: int) -> Switched:
    """The system of the monomials of degree d, whose quadratic functions are forms of degree 2d.

    >>> lifted(discrete([np.eye(3)]), 3).generators[0].shape
    (10, 10)
    """
    if degree == 1:
        return system
    n, dt = len(system.generators[0]), system.dt
    return Switched(tuple(generator(m, degree, dt) for m in system.generators), dt, degree, ties(n, degree))


@dataclass(frozen=True)
class Delayed:
    """Modes x+ = A_i x + b z[k-N] that read what they send themselves N samples later, z = dt c_i x.

    loops A_i (n, n), entry b (n,), reads c_i (n,), dt [s], samples N.
    """

    loops: tuple[Array, ...]
    entry: Array
    reads: tuple[Array, ...]
    dt: float
    samples: int

    @property
    def full(self) -> list[Array]:
        """Each mode with all that is under way as states, (n + N, n + N), what was sent last first."""
        n, found = len(self.entry), []
        for a, c in zip(self.loops, self.reads, strict=True):
            m = np.eye(n + self.samples, k=-1)
            m[: n + 1] = 0.0
            m[:n, :n] = a if self.samples else a + np.outer(self.entry, self.dt * c)
            if self.samples:
                m[:n, -1], m[n, :n] = self.entry, self.dt * c
            found.append(m)
        return found


def gram_polynomials(samples: int, count: int) -> tuple[Array, Array, Array]:
    """Discrete Legendre polynomials p_j of degree 0 to count - 1 on i = 1 .. N, mean p_j p_l = (j = l).

    p(1) and p(N + 1), each (count,), and T, (count, count), with p_j(i + 1) = sum_l T_jl p_l(i): a
    polynomial shifted is a polynomial, so that the moments of a moving window move on their own
    (Abramowitz & Stegun, chapter 22).
    """
    x = (2.0 * np.arange(1.0, samples + 2.0) - samples - 1.0) / samples
    powers = np.polynomial.legendre.legvander(x, count - 1)
    values = powers @ np.linalg.inv(np.linalg.qr(powers[:-1])[1]) * np.sqrt(samples)
    return values[0], values[-1], values[1:].T @ values[:-1] / samples


def window_quadratic(loop: Delayed, follows: bool = False, moments: int = MOMENTS) -> Search:
    """Search for a quadratic function of x and of what is under way; `follows`: P may follow the mode.

    With u = z/dt, O_j = mean_i p_j(i) u[k-i] for i = 1 .. N, and w = (x, O),

        V = w'P w + dt sum_i (s + r (N + 1 - i) dt) u[k-i]^2,     s, r >= 0.

    The moments close exactly, O+ = T O + (p(1) u - p(N+1) u[k-N])/N; Bessel's mean u^2 >= sum O_j^2
    bounds what they leave open, so that the inequality is one in (x, O, u[k-N]) however long the window
    (in continuous time: Seuret & Gouaisbaut, Systems & Control Letters 81 (2015) 1).  The rate is
    taken out first: what is multiplied by exp(rate t) has to be stable.  V is a nonnegative form of x
    and the window, hence convex in the matrix that moves them: the vertices are enough.  Where P
    follows the mode, the argument is that of `poly_quadratic`.
    """
    undelayed = [a + np.outer(loop.entry, loop.dt * c) for a, c in zip(loop.loops, loop.reads, strict=True)]
    back = scaled(discrete(undelayed, loop.dt))[1]
    return lambda loss: _window(loop, back, loss, follows, min(moments, loop.samples))


def _window(loop: Delayed, back: Array, loss: float, follows: bool, moments: int) -> SwitchedCertificate:
    import cvxpy

    rate = Switched((), loop.dt).rate(loss)
    moves, reads = _moves(loop, back, rate, moments)
    modes, n, dt = len(moves), len(moves[0]), loop.dt
    size, span = max(float(np.linalg.norm(m, 2)) for m in moves), loop.samples * dt
    p, t = cvxpy.Variable((n, n), symmetric=True), cvxpy.Variable()
    s, r = cvxpy.Variable(nonneg=True), cvxpy.Variable(nonneg=True)
    extra = [cvxpy.Variable((n, n), symmetric=True) for _ in range(modes)] if follows else []
    each = [p + dt * size * d for d in extra] or [p]
    window = np.diag([0.0] * len(back) + [1.0] * moments)
    constraints: list[Any] = [sum(p[k, k] for k in range(n)) + span * ((moments + 1) * s + span * r) == n]
    constraints += [sum(extra) == 0.0] if follows else []
    constraints += [q + span * s * window >> t * np.eye(n) for q in each]
    for i, (m, c) in enumerate(zip(moves, reads, strict=True)):
        for j, after in enumerate(each):
            step = (extra[j] - extra[i]) * size if follows else np.zeros((n, n))
            left = _loss(m, c, after, step, s, r, span, dt, moments) / size
            constraints.append((left + left.T) / 2.0 >> t * np.eye(n + 1))
    try:
        solver = solve(cvxpy.Problem(cvxpy.Maximize(t), constraints))
    except Unsolved as error:
        return SwitchedCertificate(loss, rate, -1.0, reason=NoSolver(str(error)))
    shapes = tuple(np.asarray(q.value, float) for q in each)
    weights = max(number(s), 0.0), max(number(r), 0.0)
    margin = _window_margin(moves, reads, shapes, *weights, span, dt, moments)
    none = None if margin > CONFIRMED else NoneOfThisKind(solver, number(t), "function")
    return SwitchedCertificate(loss, rate, margin, solver, shapes, none, weights)


def _moves(loop: Delayed, back: Array, rate: float, moments: int) -> tuple[list[Array], list[Array]]:
    """(w+ - w)/dt = move (w, u[k-N]) and u = read (w, u[k-N]) of each mode, for x = back times a state and
    u in units of what the modes read; all multiplied by exp(rate t)."""
    n, dt, samples = len(back), loop.dt, loop.samples
    first, beyond, shift = gram_polynomials(samples, moments)
    unit = max(float(np.linalg.norm(c @ back)) for c in loop.reads)
    moves, reads = [], []
    for a, c in zip(loop.loops, loop.reads, strict=True):
        m, read = np.zeros((n + moments, n + moments + 1)), np.zeros(n + moments + 1)
        read[:n] = c @ back / unit
        m[:n, :n] = (np.exp(rate * dt) * np.linalg.solve(back, a @ back) - np.eye(n)) / dt
        m[:n, -1] = np.exp(rate * dt * (samples + 1)) * np.linalg.solve(back, loop.entry) * unit
        m[n:, n:-1] = (shift - np.eye(moments)) / dt
        m[n:, :n] = np.outer(first, read[:n]) / (samples * dt)
        m[n:, -1] = -beyond / (samples * dt)
        moves.append(m)
        reads.append(read)
    return moves, reads


def _loss(m: Array, c: Array, p: Any, step: Any, s: Any, r: Any, span: float, dt: float, moments: int) -> Any:
    """(V - V+)/dt as a quadratic form of (w, u[k-N]), with Bessel's bound of the window; P+ = P + dt step."""
    n = len(m)
    keep, last = np.eye(n, n + 1), np.diag([0.0] * n + [1.0])
    window = np.diag([0.0] * (n - moments) + [1.0] * moments + [0.0])
    drift = keep.T @ p @ m + m.T @ p @ keep + dt * (m.T @ p @ m) + keep.T @ step @ keep
    return s * last + r * span * window - drift - (s + r * span) * np.outer(c, c)


def _window_margin(
    moves: list[Array], reads: list[Array], shapes: tuple[Array, ...], s: float, r: float, span: float,
    dt: float, moments: int, seed: int = 1,
) -> float:  # fmt: skip
    """Margin of the inequality at pairs of vertices and of random points of the polytope, by eigenvalues
    alone; -1 where V is not positive definite."""
    n, modes = len(moves[0]), len(moves)
    window = np.diag([0.0] * (n - moments) + [1.0] * moments)
    if s < 0.0 or r < 0.0 or not all(definite(p + span * s * window) for p in shapes):
        return -1.0
    every = np.array(shapes if len(shapes) == modes else shapes * modes)
    ends = np.eye(modes)
    inside = np.random.default_rng(seed).dirichlet(np.full(modes, 0.5), (INSIDE, 2))
    worst = np.inf
    for now, then in [(v, w) for v in ends for w in ends] + [(v, w) for v, w in inside]:
        m, c = np.tensordot(now, np.array(moves), 1), now @ np.array(reads)
        before, after = np.tensordot(now, every, 1), np.tensordot(then, every, 1)
        left = _loss(m, c, after, (after - before) / dt, s, r, span, dt, moments)
        root = np.eye(n + 1)
        root[:n, :n] = np.linalg.inv(np.linalg.cholesky(before + span * s * window))
        root[n, n] = 1.0 / np.sqrt(s + r * span + 1e-300)
        worst = min(worst, share_of_least(root @ left @ root.T))
    return float(worst)


@dataclass(frozen=True)
class RadiusBounds:
    """Bounds of a joint spectral radius: `lower` by the word, `upper` by a form that the check
    confirmed."""

    lower: float
    upper: float
    word: Word
    form: SwitchedCertificate


def radius_bounds(matrices: list[Array], degree: int = 2, length: int = 8) -> RadiusBounds:
    """Bounds of the joint spectral radius of matrices of shape (n, n): of the largest growth a step
    of their products, in any order.

    degree: of the form, an even number; length: of the longest word tried.  The upper bound is at most
    C(n + d - 1, d)^(1/(2d)) times the radius, with d half the degree (Parrilo & Jadbabaie 2008).
    Raises ValueError for an odd degree.

    >>> golden = radius_bounds([np.array([[1.0, 1], [0, 1]]), np.array([[1.0, 0], [1, 1]])], 4)
    >>> round(golden.lower, 3), round(golden.upper, 3)
    (1.618, 1.618)
    """
    if degree < 2 or degree % 2:
        raise ValueError(f"radius_bounds: degree {degree} is not an even number from 2 on")
    found = lifted(rounded(discrete(matrices))[0], degree // 2)
    worst = max(float(np.linalg.norm(np.eye(len(m)) + m, 2)) for m in found.generators)
    form = best(common_quadratic(found), 1.0 - (1.01 * worst + 1e-9) ** 2, float(np.min(found.fates)), 30)
    word = discrete_word(matrices, length)
    return RadiusBounds(word.radius ** (1.0 / len(word.letters)), float(np.exp(-form.rate)), word, form)
