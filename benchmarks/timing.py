"""Times on a machine that is never quite quiet: contestants side by side, and medians."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from math import ceil
from statistics import median
from typing import Any

Work = Callable[[], Any]


@dataclass(frozen=True)
class Duel:
    """Median time of two contestants [s], and the median of the ratios first / second."""

    first: float
    second: float
    ratio: float


LEAST = 0.1
"""A measurement lasts at least this long [s]: waking a processor must not count."""


def seconds(work: Work, times: int = 1) -> float:
    """Wall time of one call [s], the mean of a number of calls in a row."""
    begin = time.perf_counter()
    for _ in range(times):
        work()
    return (time.perf_counter() - begin) / times


def duel(first: Work, second: Work, rounds: int) -> Duel:
    """Both run once unmeasured, then in turn in each round, the order alternating.

    Short ones are called as often as makes a measurement long enough.  The ratio
    is taken within each round, of two measurements that follow each other:
    whatever slows the machine for longer than a round slows both.
    """
    first(), second()
    often, as_often = (ceil(LEAST / seconds(work)) for work in (first, second))
    pairs = []
    for k in range(rounds):
        if k % 2:
            late, early = seconds(second, as_often), seconds(first, often)
            pairs.append((early, late))
        else:
            pairs.append((seconds(first, often), seconds(second, as_often)))
    return Duel(median(a for a, _ in pairs), median(b for _, b in pairs), median(a / b for a, b in pairs))
