"""Which parts a law of friction has: chosen on blocks of the runs left out, the plainest that does as well.

Weights are those of least squares with a small penalty on their size, where rows that no weights describe
count little (Huber, Ann. Math. Statist. 35, 1964).  Of laws in the order of their parts the first is taken
whose error on the blocks left out is the least, or above it by no more than its uncertainty (Breiman et al.,
Classification and Regression Trees, 1984: the rule of one standard error).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plants.measured.friction.law import FrictionLaw, FrictionParts, Range, behind_lag, columns
from plants.measured.friction.run import ForceRun
from plants.measured.guess.rough_models import lagged

Array = NDArray[np.float64]
BLOCKS = 5
"""Blocks that are left out in turn, at most: whole runs, or parts of a single one."""

LAGS = (0.0, 0.01, 0.02, 0.04, 0.08)
"""Time constants [s] between the law and the force that are tried."""

OFFERED = (
    FrictionParts(),
    FrictionParts(presliding=True),
    FrictionParts(presliding=True, knots=8),
    FrictionParts(presliding=True, knots=32),
    FrictionParts(presliding=True, knots=32, running_in=True),
)
"""Laws in the order of their parts."""

PENALTY, OF_CURVES = 1e-4, 1e-2
"""Weight of the penalty, a row, on weights of columns of unit size, and on those of curves."""

ROUNDS = 4
"""Rounds of reweighting."""

OUTLYING = 2.0
"""Standard deviations from which on a row counts less."""

MOVING = 0.1
"""Share of the largest speed from which on a run that is to be fitted begins sliding, not at rest."""


@dataclass(frozen=True)
class FrictionChoice:
    """The law that was chosen, and the error [N] on blocks left out of each that was offered, in order."""

    law: FrictionLaw
    errors: dict[FrictionParts, float]


def fit_friction(runs: Sequence[ForceRun], offered: Sequence[FrictionParts] = OFFERED) -> FrictionChoice:
    """The law of friction of some runs.

    offered: laws in the order of their parts; the lag of each is found with the others.
    Raises ValueError where there is nothing to fit, or a run of fewer rows than a speed is found from.
    """
    if not runs or min(len(r.force) for r in runs) < 2 * BLOCKS:
        raise ValueError(f"friction: a run has fewer than {2 * BLOCKS} rows, or there is none")
    within, block = Range.of(runs), _blocks(runs)
    force = np.concatenate([r.force for r in runs])
    errors: dict[FrictionParts, Array] = {}
    for parts in offered:
        plain = [columns(r, parts, within, _sliding(r, within)) for r in runs]
        tried = {}
        for lag in LAGS:
            behind = np.vstack([lagged(c, r.dt, lag, 0.0) for c, r in zip(plain, runs, strict=True)])
            tried[replace(parts, lag=lag)] = _left_out(behind, force, block, 2 * parts.knots)
        best = min(tried, key=lambda p: float(tried[p].mean()))
        errors[best] = tried[best]
    least = min(errors, key=lambda p: float(errors[p].mean()))
    chosen = next(p for p, e in errors.items() if _as_good(e, errors[least]))
    whole = np.vstack([behind_lag(r, chosen, within, _sliding(r, within)) for r in runs])
    law = FrictionLaw(chosen, within, _weights(whole, force, 2 * chosen.knots))
    return FrictionChoice(law, {p: float(np.sqrt(e.mean())) for p, e in errors.items()})


def _blocks(runs: Sequence[ForceRun]) -> NDArray[np.int64]:
    """The block of every row of all runs: that of its run, or of a single run the part that it is in."""
    if len(runs) > 1:
        return np.concatenate([np.full(len(r.force), i % BLOCKS) for i, r in enumerate(runs)])
    return np.arange(len(runs[0].force)) * BLOCKS // len(runs[0].force)


def _sliding(run: ForceRun, within: Range) -> float:
    """The memory that a run begins with: all springs slip where it moves, none is bent where it rests."""
    first = run.speed[0] / within.fast
    return float(np.sign(first)) if abs(first) > MOVING else 0.0


def _left_out(a: Array, force: Array, block: NDArray[np.int64], of_curves: int) -> Array:
    """Mean squares of the errors on each block, fitted on the others, of shape (blocks,)."""
    found = []
    for k in np.unique(block):
        out = block == k
        weights = _weights(a[~out], force[~out], of_curves)
        found.append(np.mean((force[out] - a[out] @ weights) ** 2))
    return np.array(found)


def _as_good(errors: Array, least: Array) -> bool:
    """Whether mean squares on blocks are above the least ones by no more than their uncertainty."""
    more = errors - least
    return bool(float(more.mean()) <= float(more.std(ddof=1)) / len(more) ** 0.5)


def _weights(a: Array, force: Array, of_curves: int) -> Array:
    """Weights (m,) of columns (n, m), of which the last `of_curves` are those of curves."""
    size = np.maximum(np.sqrt(np.mean(a**2, axis=0)), 1e-12)
    z, n = a / size, len(force)
    penalty = np.full(a.shape[1], n * PENALTY)
    penalty[0], penalty[a.shape[1] - of_curves :] = 0.0, n * OF_CURVES
    counts = np.ones(n)
    for _ in range(ROUNDS):
        counted = z * counts[:, None]
        found = np.linalg.solve(counted.T @ z + np.diag(penalty), counted.T @ force)
        left = np.abs(force - z @ found)
        limit = OUTLYING * 1.4826 * float(np.median(left))
        counts = limit / np.maximum(left, limit) if limit > 0.0 else counts
    weights: Array = found / size
    return weights
