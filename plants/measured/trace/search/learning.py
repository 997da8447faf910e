"""A learnt block for what no effect explains: splines fitted to the residual, adopted where rows left out are
the better for it.

The coefficients are linear in the residual, so that a few ways of a turn and time constants of the slow
pressure are tried by one linear least squares each; from the best, all of the block is fitted.  The
parameters of the wrist and of its effects stay what they are: the block adds to what is known.
"""

from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from plants.effects.wrist.learnt_block import LearntBlock
from plants.measured.fitting.blocks import lower
from plants.measured.fitting.estimate import jacobian
from plants.measured.trace.search.candidate import FOLDS, PARTIAL_FIT, Candidate
from plants.measured.trace.search.worth import SHARE
from plants.measured.trace.stages.model import Model
from plants.measured.trace.stages.remainders import remainders

Array = NDArray[np.float64]
Rows = NDArray[np.bool_] | None
TURNS = (0.02, 0.08, 0.25)
"""Ways of a turn that are tried, as shares of the range of the pressure."""

MEMORIES = (0.2, 1.0, 5.0, 25.0)
"""Time constants of the slow pressure that are tried [s]."""

EDGE = 0.005
"""Share of the rows that lie beyond each end of the pressures that a block is learnt on."""

RIDGE = 1e-2
"""Weight of a coefficient against the largest column: one that hardly shows stays small."""

TINY = 1e-12
"""Room that a bounded least squares asks for between two bounds."""

ENDS = (f"{LearntBlock.NAME}.low", f"{LearntBlock.NAME}.high")
"""What is taken from the rows, and not fitted."""


def learn(now: Candidate) -> Candidate | None:
    """The model with a learnt block; None where it does not lower the error of a free run from the command on
    rows left out, by more than its uncertainty (`blocks.lower`) and by the share of what is above the noise
    that an effect must take away (`choose.SHARE`).

    Each part of the rows is judged by a block that was learnt from nothing on the others: one that was
    learnt on all of them and only refitted would remember some of what is left out.
    """
    model = now.model
    blocks = model.stage.left_out_blocks
    fold, free = blocks % FOLDS, np.empty(blocks.size)
    for k in range(FOLDS):
        apart = fold == k
        others = _learnt(model.fitted(*PARTIAL_FIT, ~apart), ~apart)
        free[apart] = others.freely.residual[apart]
    before = now.left_out.free
    left = float(np.mean(before**2))
    if not lower(before, free, blocks) or left - np.mean(free**2) <= SHARE * (left - 1.0):
        return None
    return Candidate(_learnt(model, None))


def _learnt(model: Model, rows: Rows) -> Model:
    """The model with a block that was learnt on some of the rows."""
    begun = min((_linear_fit(m, rows) for m in _begins(model)), key=lambda found: found[1])[0]
    return begun.fitted(rows=rows)


def _begins(model: Model) -> list[Model]:
    """The model with a block that is nothing yet, of every way of a turn and time constant that is tried."""
    pressure = np.concatenate([r.variables["pressure_kPa"] for r in remainders(model)])
    low, high = map(float, np.quantile(pressure, (EDGE, 1.0 - EDGE)))
    nothing = dict.fromkeys(LearntBlock.kinds(), 0.0)
    found = []
    for turn, memory in product(TURNS, MEMORIES):
        own = {"low": low, "high": high, "turn": turn * (high - low), "memory": memory}
        begun = model.plus(LearntBlock, {**nothing, **own})
        found.append(replace(begun, fixed=(*model.fixed, *model.names, *ENDS)))
    return found


def _linear_fit(model: Model, rows: Rows) -> tuple[Model, float]:
    """The model at the least squares of its linearisation in the block, and its chi-square on these rows."""
    residual, columns = jacobian(model.problem.on(rows), model.vector, model.bounds)
    x, low, high = model.bounds
    ridge = RIDGE * np.linalg.norm(columns, axis=0).max() * np.eye(x.size)
    aim = np.concatenate([-residual, np.zeros(x.size)])
    step = lsq_linear(np.vstack([columns, ridge]), aim, (low - x, high - x + TINY)).x
    begun = model.at(np.clip(x + step, low, high))
    left = begun.residual if rows is None else begun.residual[rows]
    return begun, float(np.mean(left**2))
