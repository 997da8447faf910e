"""Times on a machine that is never quite quiet: contestants side by side, and medians."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from typing import Any

Work = Callable[[], Any]


@dataclass(frozen=True)
class Duel:
    """Median time of two contestants [s], and the median of the ratios first / second."""

    first: float
    second: float
    ratio: float


def seconds(work: Work) -> float:
    """Wall time of one call [s]."""
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def duel(first: Work, second: Work, rounds: int) -> Duel:
    """Both run once unmeasured, then once each per round, the order alternating.

    The ratio is taken within each round, of two measurements that follow each other: whatever
    slows the machine for longer than a round slows both.
    """
    first(), second()
    pairs = []
    for k in range(rounds):
        if k % 2:
            late, early = seconds(second), seconds(first)
            pairs.append((early, late))
        else:
            pairs.append((seconds(first), seconds(second)))
    return Duel(median(a for a, _ in pairs), median(b for _, b in pairs), median(a / b for a, b in pairs))
