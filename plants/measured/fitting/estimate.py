"""Robust nonlinear least squares from several starts, with errors that hold for coloured residuals."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
HUBER = 3.0
"""Residuals beyond this many spreads count linearly, not squared."""

JUMP = 50.0
"""A derivative so many times larger than its fellows was taken across a jump."""

HOPELESS = 3.0
"""Times the lowest cost beyond which a minimum is not followed further."""

STALLED = 0.25
"""Share of the cost that a Gauss-Newton step promises above which a search has not ended but stands before a
steep entry, such as the moment of a step: its short steps there are short in all others, and it goes on
scaled by the slopes."""

AGAIN = 3
"""How often it goes on at most, as long as the cost falls by that share."""

LINEAR = 1e9
"""A corner that no residual reaches."""


class LeastSquares(Protocol):
    """What is estimated: residuals (rows, lanes) of vectors (lanes, n), and the block of each row."""

    @property
    def blocks(self) -> NDArray[np.intp]:
        """The block of time that each row belongs to, (rows,)."""
        ...

    def residuals(self, x: Array) -> Array:
        """Residuals (rows, lanes) at parameters x (lanes, n)."""
        ...

    def off_jumps(self, x: Array) -> "LeastSquares":
        """The same with residuals off what is estimated in turn with x (n,)."""
        ...


@dataclass(frozen=True)
class EstimateErrors:
    """Standard errors of the n entries of an estimate, None for one that the data does not determine, and the
    correlation of their errors (n, n), zero for such an entry."""

    std_errors: list[float | None]
    correlation: Array


@dataclass(frozen=True)
class Estimate:
    """An estimate x (n,); std_errors, None where the data does not determine an entry, and the correlation of
    the errors (n, n); costs of the local minima from each start, best first; agreeing: starts that ended
    within 1 % of it."""

    x: Array
    std_errors: list[float | None]
    correlation: Array
    costs: tuple[float, ...]
    agreeing: int


def estimate(problem: LeastSquares, bounds: Array, starts: int, seed: int) -> Estimate:
    """Minimise a Huber loss of the residuals within `bounds`, rows start, lower, upper, shape (3, n).

    The loss's corner is set by the spread of the residuals themselves: first
    that of the start, then that of the minimum with the least squares, so that a
    model that misses something is not fitted to the few rows where it happens to
    be right.
    """
    x0, low, high = bounds
    draws = np.random.default_rng(seed).uniform(-1.0, 1.0, (max(starts - 1, 0), x0.size))
    reach = np.where(draws < 0.0, x0 - low, high - x0)
    candidates = np.vstack([x0, np.clip(x0 + 0.5 * draws * reach * np.abs(draws), low, high)])
    ends = [minimise(problem, x, bounds, corner_of(problem.residuals(x[None, :])[:, 0])) for x in candidates]
    left = [problem.residuals(x[None, :])[:, 0] for x, _ in ends]
    corner = corner_of(min(left, key=lambda r: float(np.mean(r**2))))
    # A minimum far above another will not come down by a better corner.
    nearest = min(cost for _, cost in ends)
    ends = [
        minimise(problem, x, bounds, corner) if cost <= HOPELESS * nearest else (x, cost) for x, cost in ends
    ]
    ends.sort(key=lambda end: end[1])
    best = ends[0][1]
    agreeing = sum(cost <= best * 1.01 for _, cost in ends)
    of = uncertainty(problem, ends[0][0], bounds, corner)
    return Estimate(ends[0][0], of.std_errors, of.correlation, tuple(cost for _, cost in ends), agreeing)


def corner_of(residuals: Array) -> float:
    """Corner of the Huber loss: some spreads of the residuals, never inside the noise."""
    return HUBER * max(1.0, 1.4826 * float(np.median(np.abs(residuals))))


def _scale(x: Array, bounds: Array) -> Array:
    """Typical size of each entry; half its range for one that may be zero."""
    scale: Array = np.where(np.abs(x) > 1e-6, np.abs(x), 0.5 * (bounds[2] - bounds[1]))
    return scale


def jacobian(problem: LeastSquares, x: Array, bounds: Array) -> tuple[Array, Array]:
    """Residuals (rows,) and their derivatives (rows, n): perturbed copies run side by side in lanes."""
    scale = _scale(x, bounds)
    step = 1e-5 * scale
    step = np.where(x + step > bounds[2], -step, step)
    lanes = problem.residuals(np.vstack([x, x + np.diag(step)]))
    # Column after column in memory, as linear algebra takes them.
    slopes = np.empty((len(lanes), x.size), order="F")
    np.subtract(lanes[:, 1:], lanes[:, :1], out=slopes)
    slopes /= step
    # A wrist that only just leaves its virgin curve, or just not, jumps with a parameter; a
    # derivative taken across such a jump is of no use, and on the other side there is none.
    sizes = np.linalg.norm(slopes, axis=0) * scale
    across = sizes > JUMP * np.median(sizes)
    if across.any() and not across.all():
        back = problem.residuals(x - np.diag(step)[across])
        other = (lanes[:, :1] - back) / step[across]
        smaller = np.linalg.norm(other, axis=0) * scale[across] < sizes[across]
        slopes[:, across] = np.where(smaller, other, slopes[:, across])
    return lanes[:, 0], slopes


def minimise(
    problem: LeastSquares,
    x: Array,
    bounds: Array,
    corner: float = LINEAR,
    evaluations: int = 40,
    tol: float = 1e-7,
) -> tuple[Array, float]:
    """Local minimum from x and its mean cost; least squares where no corner is given."""
    from scipy.optimize import least_squares

    at: dict[bytes, tuple[Array, Array]] = {}

    def both(x: Array) -> tuple[Array, Array]:
        key = x.tobytes()
        if key not in at:
            at.clear()
            at[key] = jacobian(problem, x, bounds)
        return at[key]

    if corner >= LINEAR:
        triangles: dict[bytes, Array] = {}

        def reduced(x: Array) -> Array:
            # Same cost, gradient and normal equations as all the rows, in a handful of them.
            key = x.tobytes()
            if key not in triangles:
                triangles[key] = _triangle(*both(x))
            return triangles[key]

        def descend(x: Array, scale: Any) -> Any:
            return least_squares(
                lambda x: reduced(x)[:, -1], x, lambda x: reduced(x)[:, :-1], bounds=(bounds[1], bounds[2]),
                x_scale=scale, max_nfev=evaluations, xtol=tol, ftol=tol,
            )  # fmt: skip

        found = descend(x, _scale(bounds[0], bounds))
        for _ in range(AGAIN):
            if not (found.success and _promised(reduced(found.x), found.active_mask == 0) > STALLED):
                break
            again = descend(found.x, "jac")
            if again.cost > (1.0 - STALLED) * found.cost:
                break
            found = again
        rows = next(iter(at.values()))[0].size
        return found.x, float(found.cost / rows)
    found = least_squares(
        lambda x: both(x)[0], x, lambda x: both(x)[1], bounds=(bounds[1], bounds[2]),
        x_scale=_scale(bounds[0], bounds), loss="huber", f_scale=corner,
        max_nfev=evaluations, xtol=tol, ftol=tol,
    )  # fmt: skip
    return found.x, float(found.cost / found.fun.size)


def _triangle(residual: Array, slopes: Array) -> Array:
    """The triangle (n + 1, n + 1) of the QR decomposition of slopes (rows, n) and residual (rows,)."""
    from scipy.linalg import qr

    side_by_side = np.empty((residual.size, slopes.shape[1] + 1), order="F")
    side_by_side[:, :-1], side_by_side[:, -1] = slopes, residual
    # In place and on columns: several times faster than numpy's, which lays rows out anew.
    found: Array = qr(side_by_side, mode="raw", overwrite_a=True, check_finite=False)[1]
    return found


def _promised(reduced: Array, free: NDArray[np.bool_]) -> float:
    """Share of the cost that a full Gauss-Newton step in the entries that are at no bound would take away, of
    the triangle of slopes and residual."""
    column = np.asarray(np.linalg.qr(reduced[:, np.append(free, True)], mode="r"), float)[:, -1]
    total = float(column @ column)
    return float(column[:-1] @ column[:-1]) / total if total > 0.0 else 0.0


def uncertainty(problem: LeastSquares, x: Array, bounds: Array, corner: float) -> EstimateErrors:
    """Standard errors and their correlation by the sandwich formula over blocks of time.

    Residuals within a block may be correlated in any way, so the errors hold
    where a missing effect colours them (Cameron & Miller, J. Human Resources 50
    (2015) 317).  An entry is undetermined where the data is blind to it or
    where it cannot be told from others, or from what is estimated in turn with it.
    """
    residual, slopes = jacobian(problem.off_jumps(x), x, bounds)
    weight = np.minimum(1.0, corner / np.maximum(np.abs(residual), 1e-300))
    scaled = slopes * _scale(x, bounds)
    bread = scaled.T @ (scaled * weight[:, None])
    count = int(problem.blocks.max()) + 1
    scores = np.zeros((count, x.size))
    np.add.at(scores, problem.blocks, scaled * (weight * residual)[:, None])
    vectors: Array
    sizes, vectors = np.linalg.eigh(bread)
    seen = sizes > 1e-9 * sizes.max(initial=0.0)
    inverse = (vectors[:, seen] / sizes[seen]) @ vectors[:, seen].T
    free = max(1, count - x.size)
    cov = inverse @ (scores.T @ scores) @ inverse * (count / free)
    blind = (vectors[:, ~seen] ** 2).sum(axis=1) > 1e-3
    spread = np.sqrt(np.maximum(np.diag(cov), 0.0))
    known = np.outer(spread, spread) * ~(blind[:, None] | blind[None, :])
    correlation = np.divide(cov, known, out=np.zeros_like(cov), where=known > 0.0)
    errors = spread * _scale(x, bounds)
    return EstimateErrors([None if b else float(e) for b, e in zip(blind, errors, strict=True)], correlation)
