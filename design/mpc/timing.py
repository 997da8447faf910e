"""The deadline ledger: how long the steps of an MPC took, and how many missed their period."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from design.mpc.fallback import Info


@dataclass(frozen=True)
class Times:
    """Of one part of a step [s]: median, 99 % quantile, maximum."""

    median: float
    p99: float
    most: float


@dataclass(frozen=True)
class Ledger:
    """Times of whole steps and of their parts; period [s], number of steps and of those that took longer
    than the period; how many steps each rung of the ladder of fallbacks gave."""

    total: Times
    preparation: Times
    solve: Times
    wrapper: Times
    period: float
    steps: int
    misses: int
    rungs: dict[str, int]

    @property
    def p99_share(self) -> float:
        """The 99 % quantile of a step's time as a share of the period."""
        return self.total.p99 / self.period


def ledger(infos: Sequence[Info], period: float, leave_out: int = 0) -> Ledger:
    """What the records of steps add up to, the first `leave_out` set aside (code is loaded there).

    period: within which each should have been done [s].

    >>> steps = [Info("solved", "", 3, 1000, 2000, k * 1000) for k in range(100)]
    >>> found = ledger(steps, 0.02)
    >>> round(found.total.median * 1e6, 6), found.misses
    (52.5, 0)
    """
    kept = list(infos)[leave_out:]
    total = np.array([i.total_ns for i in kept], float) * 1e-9
    parts = {
        name: _times(np.array([getattr(i, f"{name}_ns") for i in kept], float) * 1e-9)
        for name in ("preparation", "solve", "wrapper")
    }
    rungs: dict[str, int] = {}
    for info in kept:
        rungs[info.rung] = rungs.get(info.rung, 0) + 1
    return Ledger(
        _times(total), parts["preparation"], parts["solve"], parts["wrapper"], period, len(kept),
        int(np.sum(total > period)), rungs,
    )  # fmt: skip


def _times(seconds: np.ndarray) -> Times:
    return Times(float(np.median(seconds)), float(np.quantile(seconds, 0.99)), float(np.max(seconds)))
