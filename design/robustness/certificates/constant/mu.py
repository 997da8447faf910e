"""The mixed structured singular value at one frequency: an upper bound with D and G scalings.

For M complex, (n, n), and Delta block diagonal, 1/mu is the size of the smallest Delta with
det(I - M Delta) = 0.  A number beta is above mu where matrices that commute with Delta exist, D = D' > 0
and G = G' (0 at complex blocks), with

    M' D M + j (G M - M' G) - N D N < 0,     N = beta at each block, 1 at a block of fixed size,

since w = Delta z, z = M w would make w' (...) w at least 0.  Blocks of fixed size (skewed mu) do not
grow with the others.

Sources: Fan, Tits, Doyle, Robustness in the presence of mixed parametric uncertainty and unmodeled
dynamics, IEEE TAC 36 (1991) 25; Young, Newlin, Doyle, Computing bounds for the mixed mu problem,
Int. J. Robust Nonlinear Control 5 (1995) 573, doi 10.1002/rnc.4590050604.
"""

from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from design.synthesis.convex import Unsolved, solve

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

LEAST_D, LARGEST_G = 1e-6, 1e3
"""Least eigenvalue of D and largest of G where D <= I: keeps the program well posed; only costs tightness."""

FLOOR = 1e-8
"""What is added to each entry before balancing, as a share of the largest: a row or column that is empty
has no balance, and M of a high frequency is nearly nilpotent."""


@dataclass(frozen=True)
class Block:
    """One block of Delta: a scalar times the identity of a size (kind real or complex), or any complex
    matrix of that size (kind full); fixed: no larger than 1 whatever the others are."""

    kind: Literal["real", "complex", "full"] = "real"
    size: int = 1
    fixed: bool = False


Blocks = tuple[Block, ...]


@dataclass(frozen=True)
class Scalings:
    """D (n, n), Hermitian and positive, and G (n, n), Hermitian; solver: that found them."""

    D: Complex
    G: Complex
    solver: str


def sizes(blocks: Blocks, beta: float) -> Array:
    """The diagonal of N, shape (n,)."""
    return np.concatenate([np.full(b.size, 1.0 if b.fixed else beta) for b in blocks])


def margin(M: Complex, s: Scalings, blocks: Blocks, beta: float) -> float:
    """By how much the inequality holds: the largest m with M'DM + j(GM - M'G) <= (1 - m) N D N.

    Without unit; above 0 where beta is proved to be above mu.  M: (n, n), or (m, n, n), of which the
    least is taken.  -inf where D is not positive or its eigenvalues cannot be had.
    """
    N = sizes(blocks, beta)
    try:
        root = np.linalg.inv(np.linalg.cholesky(N[:, None] * s.D * N))
        return float(1.0 - np.max(np.linalg.eigvalsh(root @ quadratic(M, s) @ root.conj().T)))
    except np.linalg.LinAlgError:
        return -np.inf


def quadratic(M: Complex, s: Scalings) -> Complex:
    """M'DM + j(GM - M'G), of the shape of M; Hermitian."""
    adjoint = np.conj(np.swapaxes(M, -1, -2))
    found: Complex = adjoint @ s.D @ M + 1j * (s.G @ M - adjoint @ s.G)
    return found


def scalings(M: Complex, blocks: Blocks, beta: float) -> Scalings | None:
    """Scalings that prove beta to be above mu of M, with as much to spare as is to be had, or None.

    What they prove is confirmed outside the solver, by `margin`.
    """
    T = balance(M, blocks)
    scaled = (T[:, None] * M / T) / sizes(blocks, beta)  # beta and N are taken into M
    terms, variable, problem = _program(blocks)
    n, (D_basis, G_basis) = len(M), _bases(blocks)
    D_terms = scaled.conj().T @ D_basis @ scaled - D_basis
    half = 1j * G_basis @ scaled
    F = np.concatenate([D_terms, half + half.conj().swapaxes(-1, -2)])
    terms.value = _real(F).reshape(len(F), 4 * n * n)
    try:
        solver = solve(problem)
    except Unsolved:
        return None
    x = np.asarray(variable.value)
    D = np.asarray(np.tensordot(x[: len(D_basis)], D_basis, 1), complex)
    G = np.asarray(np.tensordot(x[len(D_basis) :], G_basis, 1) * sizes(blocks, beta), complex)
    found = Scalings(T[:, None] * D * T, T[:, None] * G * T, solver)
    return found if margin(M, found, blocks, beta) > 0.0 else None


def upper_bound(M: Complex, blocks: Blocks, accuracy: float = 1e-3) -> tuple[float, Scalings | None]:
    """An upper bound of mu, confirmed in NumPy, and the scalings that prove it.

    The smallest that the scalings of this form give, within `accuracy` as a share of it, but
    no less than 1e-6 of the norm of M.  (inf, None) where blocks of fixed size alone make
    I - M Delta singular.

    >>> bound, _ = upper_bound(np.array([[0.5 + 0j]]), (Block("real"),))
    >>> round(bound, 3)
    0.5
    """
    T = balance(M, blocks)
    largest = max(float(np.linalg.norm(T[:, None] * M / T, 2)), 1e-12)
    high, best = 2.0 * largest, None
    for _ in range(20):  # with blocks of fixed size the norm need not be enough
        best = scalings(M, blocks, high)
        if best is not None:
            break
        high *= 2.0
    if best is None:
        return np.inf, None
    floor = 1e-6 * largest
    high, step = max(proved(M, best, blocks), floor), 0.5
    while step < 1.0 - accuracy and high > floor:
        found = scalings(M, blocks, step * high)
        if found is None:
            step = np.sqrt(step)
        else:  # scalings that prove a bound prove a smaller one too
            high, best = max(proved(M, found, blocks), floor), found
    return high, best


def proved(M: Complex, s: Scalings, blocks: Blocks) -> float:
    """The least beta that given scalings prove to be above or at mu; inf where they prove none."""
    free = np.concatenate([np.full(b.size, not b.fixed) for b in blocks])
    X = quadratic(M, s)
    X[np.ix_(~free, ~free)] -= s.D[np.ix_(~free, ~free)]
    X11, X12, X22 = X[np.ix_(free, free)], X[np.ix_(free, ~free)], X[np.ix_(~free, ~free)]
    if not free.any():
        return np.inf
    if len(X22):
        if np.max(np.linalg.eigvalsh(X22)) >= 0.0:
            return np.inf
        X11 = X11 - X12 @ np.linalg.solve(X22, X12.conj().T)  # Schur complement
    root = np.linalg.inv(np.linalg.cholesky(s.D[np.ix_(free, free)]))
    return float(np.sqrt(max(0.0, np.max(np.linalg.eigvalsh(root @ X11 @ root.conj().T)))))


def balance(M: Complex, blocks: Blocks) -> Array:
    """Factors T, shape (n,), one a block, that make T M / T even (Osborne 1960): units no longer matter."""
    at = np.repeat(np.arange(len(blocks)), [b.size for b in blocks])
    gains = np.zeros((len(blocks), len(blocks)))
    for i, j in product(range(len(blocks)), repeat=2):
        gains[i, j] = np.linalg.norm(M[np.ix_(at == i, at == j)])
    gains += FLOOR * max(float(gains.max()), 1e-300)
    np.fill_diagonal(gains, 0.0)
    factors = np.ones(len(blocks))
    for _ in range(20 if len(blocks) > 1 else 0):
        for i in range(len(blocks)):
            row, column = factors[i] * gains[i] / factors, gains[:, i] * factors / factors[i]
            factors[i] *= np.sqrt(np.linalg.norm(column) / np.linalg.norm(row))
    return factors[at]


@cache
def _bases(blocks: Blocks) -> tuple[Complex, Complex]:
    """Bases of the matrices D and of the matrices G, shapes (., n, n)."""
    n = sum(b.size for b in blocks)
    D: list[Complex] = []
    G: list[Complex] = []
    start = 0
    for b in blocks:
        if b.kind == "full":
            one = np.zeros((n, n), complex)
            one[range(start, start + b.size), range(start, start + b.size)] = 1.0
            D.append(one)
        else:
            own = _hermitian(n, start, b.size)
            D += own
            G += own if b.kind == "real" else []
        start += b.size
    return np.array(D), np.array(G).reshape(len(G), n, n)


def _hermitian(n: int, start: int, size: int) -> list[Complex]:
    """A basis of the Hermitian matrices of one block."""
    found = []
    for i in range(start, start + size):
        for j in range(i, start + size):
            for unit in (1.0, 1j)[: 1 if i == j else 2]:
                one = np.zeros((n, n), complex)
                one[j, i], one[i, j] = np.conj(unit), unit
                found.append(one)
    return found


def _real(X: Complex) -> Array:
    """Hermitian matrices as symmetric ones of twice the size, definite where they are."""
    found: Array = np.block([[X.real, -X.imag], [X.imag, X.real]])
    return found


@cache
def _program(blocks: Blocks) -> tuple[Any, Any, Any]:
    """The program of a structure, written once: its parameter, its variable, itself.

    Maximise t with F(D, G) <= -t I, LEAST_D <= D <= I, |G| <= LARGEST_G.
    """
    import cvxpy

    D_basis, G_basis = _bases(blocks)
    n = D_basis.shape[-1]
    x = cvxpy.Variable(len(D_basis) + len(G_basis))
    t = cvxpy.Variable()
    terms = cvxpy.Parameter((x.size, 4 * n * n))

    def total(coefficients: Any, matrices: Any) -> Any:
        return (coefficients @ matrices).reshape((2 * n, 2 * n), order="C")

    def symmetric(expression: Any) -> Any:
        return 0.5 * (expression + expression.T)  # which it is already; cvxpy cannot know

    eye = np.eye(2 * n)
    D = symmetric(total(x[: len(D_basis)], _real(D_basis).reshape(len(D_basis), -1)))
    limits = [D >> LEAST_D * eye, D << eye]
    if len(G_basis):
        G = symmetric(total(x[len(D_basis) :], _real(G_basis).reshape(len(G_basis), -1)))
        off = eye[:n, :n].astype(complex)  # places without G are 0 on both sides
        limits += [G << LARGEST_G * _real(off), G >> -LARGEST_G * _real(off)]
    F = symmetric(total(x, terms))
    problem = cvxpy.Problem(cvxpy.Maximize(t), [F << -t * eye, *limits])
    return terms, x, problem
