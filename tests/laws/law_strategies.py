"""Loops, regulators, wrists and commands that hypothesis draws from."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from hypothesis import strategies as st

from plants import FourSegment, HysteresisLaw, Regulator, Wrist

REST = 100.0
LOW, HIGH = 0.0, 200.0


def between(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_subnormal=False)


@st.composite
def loops(draw: st.DrawFn, parallel: bool = False) -> FourSegment:
    """Loops that are open between 0 and 200 kPa, their transit flatter than both lines and the
    dead zone within 60 kPa of rest; with parallel lines they are open everywhere."""
    a1 = draw(between(0.1, 1.0))
    w1, w2 = draw(between(1.0, 30.0)) * a1, draw(between(1.0, 30.0)) * a1
    a2 = a1 + (0.0 if parallel else draw(between(-0.8, 0.8))) * (w1 + w2) / 100.0
    return FourSegment(a1, w1, a2, w2, draw(between(0.0, 0.9)) * min(a1, a2), REST)


@st.composite
def symmetric_loops(draw: st.DrawFn) -> FourSegment:
    """Loops with the same slope and offset in both directions."""
    a = draw(between(0.1, 1.0))
    w = draw(between(1.0, 30.0)) * a
    return FourSegment(a, w, a, w, draw(between(0.0, 0.9)) * a, REST)


pressures = between(LOW, HIGH)
paths = st.lists(pressures, min_size=1, max_size=12)
"""Turning points of a pressure that starts from rest."""

regulators = st.builds(
    Regulator, gain=between(30.0, 80.0), k_fast=between(2.0, 50.0), k_slow=between(0.05, 2.0),
    e0=between(0.5, 60.0),
)  # fmt: skip


@st.composite
def wrists(draw: st.DrawFn, loop: st.SearchStrategy[FourSegment] | None = None) -> Wrist:
    """Wrists whose loop is open over the whole command range."""
    air, shape = draw(regulators), draw(loops() if loop is None else loop)
    fair = Regulator(HIGH / 4.0, air.k_fast, air.k_slow, air.e0)
    return Wrist(fair, shape, draw(between(0.01, 1.0)))


@st.composite
def commands(draw: st.DrawFn) -> list[float]:
    """Levels within the command range, each held for a while."""
    levels = draw(st.lists(st.tuples(between(0.0, 4.0), st.integers(1, 80)), min_size=1, max_size=10))
    return [level for level, samples in levels for _ in range(samples)]


def walk(loop: HysteresisLaw, path: Sequence[float], start: float = REST, memory: Any = None) -> Any:
    """The loop's memory after monotone moves from one turning point of a path to the next."""
    memory = loop.initial() if memory is None else memory
    for after in path:
        memory = loop.step(memory, start, after)
        start = after
    return memory


def trace(
    loop: HysteresisLaw, path: Sequence[float], start: float, memory: Any, cuts: int = 40
) -> tuple[np.ndarray, np.ndarray, Any]:
    """Pressures and angles along a path, each of its moves cut into pieces, and the last memory."""
    x, h = [start], [float(memory.h)]
    for after in path:
        for p in np.linspace(start, after, cuts + 1)[1:]:
            memory = loop.step(memory, x[-1], p)
            x.append(float(p))
            h.append(float(memory.h))
        start = after
    return np.array(x), np.array(h), memory
