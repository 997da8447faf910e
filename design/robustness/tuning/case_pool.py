"""The pool of cases that every tuning under a requirement begins with, the same for every seed."""

import numpy as np
from numpy.typing import NDArray

from design.robustness.requirement import Requirement
from design.synthesis.requirements import COSTS

Array = NDArray[np.float64]

POOL = 8192
"""Cases of the pool."""


def pool_of(requirement: Requirement, count: int = POOL) -> Array:
    """Places that every tuning begins with, the same for all seeds: half of them at corners of the box, with
    the ends of dead time and load, within reach."""
    space = requirement.space
    x = np.random.default_rng(0).random((space.size, count))
    n = len(space.box.intervals)
    corner = slice(0, count // 2)
    x[:n, corner] = np.round(x[:n, corner])
    ends = slice(n + 2 * space.steps, space.size - (len(space.kinds) > 1))
    x[ends, corner] = np.round(x[ends, corner])
    return np.asarray(x[:, space.reachable(x)])


def harshest(requirement: Requirement, pool: Array, values: dict[str, Array], of: int) -> NDArray[np.intp]:
    """The quarter of a pool that comes nearest to the limits in what runs gave, and its dearest cases."""
    cost = np.where(requirement.space.of_task(pool), values[COSTS[requirement.cost]], 0.0)
    near, dear = np.argsort(-requirement.excess(values)), np.argsort(-cost)
    return np.unique(np.concatenate([near[: of // 4], dear[: of // 32]]))
