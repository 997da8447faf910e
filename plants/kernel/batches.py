"""Rollouts side by side: a law compiled once, run over many lanes on any number of threads."""

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from threading import Lock
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from plants.kernel import pytrees
from plants.kernel.cache import load
from plants.kernel.templates import LANES, emit

Array = NDArray[np.float64]
T = TypeVar("T")
R = TypeVar("R")

WORTH_A_THREAD = 30_000
"""Steps of `LANES` lanes that take longer than waking threads: some milliseconds."""

_LOADING = Lock()
_KERNELS: dict[Any, Callable[..., None]] = {}
"""Those of this process, by step function, structures of the trees and names of the signals."""


def kernel(
    step: Callable[..., Any],
    state: Any,
    inputs: tuple[str, ...],
    coefficients: Any,
    held: tuple[str, ...] = (),
) -> Callable[..., None]:
    """The compiled ``run`` of a step function; `state` and `coefficients` are examples of the trees.

    Threads may ask for the same one at once: it is made by one of them.
    """
    key = (step, pytrees.structure(state), inputs, pytrees.structure(coefficients), held)
    if (known := _KERNELS.get(key)) is not None:
        return known
    with _LOADING:
        if key not in _KERNELS:
            s, c = (pytrees.like(tree, pytrees.names(tree)) for tree in (state, coefficients))
            _KERNELS[key] = load(emit(f"{step.__module__}.{step.__name__}", step, s, inputs, c, held))
        return _KERNELS[key]


def default_jobs() -> int:
    """Threads used where none are asked for: the processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def _pool(threads: int, name: str = "lanes") -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix=name)


def in_turn_or_side_by_side(work: Callable[[T], R], items: Sequence[T], steps: int) -> list[R]:
    """Results of `work` on each of some items, which run kernels over so many steps in all, of `LANES` lanes.

    In threads where that takes long against waking them, which on a busy machine takes milliseconds.
    """
    jobs = min(default_jobs(), len(items))
    if jobs < 2 or steps < WORTH_A_THREAD:
        return [work(i) for i in items]
    # A pool of its own: what waits here for rollouts must not take their threads.
    return list(_pool(jobs, "items").map(work, items))


def run_lanes(
    law: Callable[..., Any],
    state: Any,
    coefficients: Any,
    steps: int | NDArray[np.intp],
    signals: dict[str, Any] | None = None,
    inputs: tuple[str, ...] = (),
    every: int = 0,
    record: tuple[str, ...] = (),
    jobs: int | None = None,
    held: dict[str, Array] | None = None,
    hold: int = 1,
) -> tuple[Any, Array]:
    """Advance ``law(state, inputs, coefficients)`` by a number of steps in every lane, or by at least so many
    of each lane, (lanes,): those that are side by side, `LANES` of them, go on as long as the longest.

    Leaves of `state` and `coefficients` are floats (the same in every lane) or
    arrays of one length, the number of lanes.  `signals` are shared by the
    lanes: one, of at least `steps` values, for each name in `inputs` but
    ``sample``, which is the index of the step, and those of `held`, of which each
    lane has its own: shape (rows, lanes), a row for every `hold` steps.  Returns
    the last state, leaves of shape (lanes,), and the leaves named in `record` after
    every `every` steps, shape (len(record), rows, lanes), row 0 being the start.
    Lanes do not depend on each other: results are the same to the bit for any
    number of threads.  Raises ValueError for numbers of lanes that differ, for a signal that is too
    short, and for steps of each lane where something is recorded.
    """
    own = held or {}
    flat_s, flat_c = pytrees.leaves(state), pytrees.leaves(coefficients)
    sizes = {np.size(x) for x in (*flat_s, *flat_c) if np.ndim(x)}
    sizes |= {np.shape(x)[1] for x in own.values()}
    lanes = max(sizes, default=1)
    if sizes - {1, lanes}:
        raise ValueError(f"lanes differ in number: {sorted(sizes)}")
    blocks = -(-lanes // LANES)
    if np.ndim(steps) and (every or own):
        raise ValueError("lanes of lengths of their own are not recorded, and have no signals of their own")
    each = np.broadcast_to(steps, (lanes,)) if np.ndim(steps) else None  # steps of each lane
    ends = [] if each is None else [int(np.max(each[i : i + LANES])) for i in range(0, lanes, LANES)]
    most = int(np.max(steps))
    shared = [np.asarray((signals or {})[name], float) for name in inputs if name not in ("sample", *own)]
    if any(len(signal) < most for signal in shared) or any(len(x) * hold < most for x in own.values()):
        raise ValueError(f"a signal is shorter than the {most} steps asked for")
    given = np.array([signal[:most] for signal in shared]) if shared else np.zeros((1, 1))
    names = pytrees.names(state) if record else []
    recorded = np.array([names.index(r) for r in record], dtype=np.int64) + len(flat_c)

    run = kernel(law, state, inputs, coefficients, tuple(own))
    memory = _in_blocks([*flat_c, *flat_s, *[0.0] * len(own)], lanes, blocks)
    rows = np.empty((len(record), most // every + 1 if every else 0, blocks * LANES))
    if every:
        rows[:, 0] = _side_by_side(memory[:, recorded])
    by_lane = _by_lane(own, lanes, blocks * LANES)
    more = (by_lane, hold) if own else ()

    def work(some: Iterable[int]) -> None:
        for i in some:
            run(memory[i], i * LANES, given, *more, ends[i] if ends else most, every, recorded, rows)

    threads = min(jobs or default_jobs(), blocks)
    # In turns, so that each thread has as much to do.
    order = sorted(range(blocks), key=ends.__getitem__, reverse=True) if ends else range(blocks)
    if threads == 1:
        work(order)
    else:
        list(_pool(threads).map(work, [order[i::threads] for i in range(threads)]))
    last = _side_by_side(memory[:, len(flat_c) : len(flat_c) + len(flat_s)])
    return pytrees.like(state, last[:, :lanes]), rows[..., :lanes]


def _in_blocks(flat: Sequence[Any], lanes: int, blocks: int) -> Array:
    """Leaves as rows of blocks, (blocks, rows, `LANES`), the last lane repeated to fill the last block."""
    made = np.empty((len(flat), blocks * LANES))
    for row, value in zip(made, flat, strict=True):
        row[:lanes] = value
    made[:, lanes:] = made[:, lanes - 1 : lanes]
    return np.ascontiguousarray(made.reshape(len(flat), blocks, LANES).transpose(1, 0, 2))


def _side_by_side(blocks: Array) -> Array:
    """Rows of blocks, (blocks, rows, `LANES`), as rows of all lanes, (rows, lanes)."""
    return blocks.transpose(1, 0, 2).reshape(blocks.shape[1], blocks.shape[0] * LANES)


def _by_lane(held: dict[str, Array], lanes: int, padded: int) -> Array:
    """Signals of each lane's own, shape (names, rows, padded), the last lane repeated; one that fits is not
    copied."""
    if not held:
        return np.empty((0, 0, padded))
    if [x.shape[1] for x in held.values()] == [padded]:
        return np.ascontiguousarray(next(iter(held.values())), float)[None]
    found = np.empty((len(held), len(next(iter(held.values()))), padded))
    for rows, x in zip(found, held.values(), strict=True):
        rows[:, :lanes] = x
        rows[:, lanes:] = rows[:, lanes - 1 : lanes]
    return found
