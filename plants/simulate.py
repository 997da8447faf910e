"""Rollouts of a sampled system: one or a batch of lanes, open loop, on any number of threads."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plants import tree
from plants.compiled import LANES, kernel
from plants.effects.effect import Around
from plants.errors import InputError
from plants.wrist import QUIET, SAMPLE_TIME, State, Wrist, bend, read, settled, step

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Response:
    """An open-loop response: time [s]; pressure [kPa], static angle and angle [deg], each
    of shape (rows,) or, for a wrist with arrays as parameters, (rows, lanes)."""

    time: Array
    pressure: Array
    static_angle: Array
    angle: Array
    state: State


def default_jobs() -> int:
    """Threads used where none are asked for: the processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="lanes")


def run_lanes(
    law: Callable[..., Any],
    state: Any,
    coefficients: Any,
    steps: int,
    signals: dict[str, Any] | None = None,
    inputs: tuple[str, ...] = (),
    every: int = 0,
    record: tuple[str, ...] = (),
    jobs: int | None = None,
    held: dict[str, Array] | None = None,
    hold: int = 1,
) -> tuple[Any, Array]:
    """Advance ``law(state, inputs, coefficients)`` by a number of steps in every lane.

    Leaves of `state` and `coefficients` are floats (the same in every lane) or
    arrays of one length, the number of lanes.  `signals` are shared by the
    lanes: one, of at least `steps` values, for each name in `inputs` but
    ``sample``, which is the index of the step, and those of `held`, of which each
    lane has its own: shape (rows, lanes), a row for every `hold` steps.  Returns
    the last state, leaves of shape (lanes,), and the leaves named in `record` after
    every `every` steps, shape (len(record), rows, lanes), row 0 being the start.
    Lanes do not depend on each other: results are the same to the bit for any
    number of threads.  Raises ValueError for numbers of lanes that differ and for a signal that is too
    short.
    """
    own = held or {}
    sizes = {np.size(x) for x in tree.leaves(state) + tree.leaves(coefficients) if np.ndim(x)}
    sizes |= {np.shape(x)[1] for x in own.values()}
    lanes = max(sizes, default=1)
    if sizes - {1, lanes}:
        raise ValueError(f"lanes differ in number: {sorted(sizes)}")
    padded = -(-lanes // LANES) * LANES
    s, c = _stack(state, lanes, padded), _stack(coefficients, lanes, padded)
    shared = [np.asarray((signals or {})[name], float) for name in inputs if name not in ("sample", *own)]
    if any(len(signal) < steps for signal in shared) or any(len(x) * hold < steps for x in own.values()):
        raise ValueError(f"a signal is shorter than the {steps} steps asked for")
    given = np.array([signal[:steps] for signal in shared]) if shared else np.zeros((1, 1))
    names = tree.names(state)
    recorded = np.array([names.index(r) for r in record], dtype=np.int64)

    trees = tree.like(state, names), inputs, tree.like(coefficients, tree.names(coefficients))
    run = kernel(law, *trees, tuple(own))
    by_lane = _by_lane(own, lanes, padded)
    blocks, threads = padded // LANES, min(jobs or default_jobs(), padded // LANES)
    edges = np.linspace(0, blocks, threads + 1).astype(int) * LANES
    pieces = [slice(int(a), int(b)) for a, b in pairwise(edges)]

    def work(piece: slice) -> tuple[Array, Array]:
        part = np.ascontiguousarray(s[:, piece])
        rows = np.empty((len(record), steps // every + 1 if every else 0, part.shape[1]))
        if every:
            rows[:, 0] = part[recorded]
        more = (by_lane, hold, piece.start) if own else ()
        run(np.ascontiguousarray(c[:, piece]), part, given, *more, steps, every, recorded, rows)
        return part, rows

    if len(pieces) == 1:
        last, rows = work(pieces[0])
    else:
        done = list(_pool(threads).map(work, pieces))
        last, rows = (np.concatenate(parts, axis=-1) for parts in zip(*done, strict=True))
    return tree.like(state, last[:, :lanes]), rows[:, :, :lanes]


def _stack(values: Any, lanes: int, padded: int) -> Array:
    """Leaves as rows of one array, the last lane repeated to fill the last block."""
    flat = tree.leaves(values)
    out = np.empty((len(flat), padded))
    for row, value in zip(out, flat, strict=True):
        row[:lanes] = value
    out[:, lanes:] = out[:, lanes - 1 : lanes]
    return out


def _by_lane(held: dict[str, Array], lanes: int, padded: int) -> Array:
    """Signals of each lane's own, shape (names, rows, padded); one that fits is not copied."""
    if [x.shape[1] for x in held.values()] == [padded]:
        return np.ascontiguousarray(next(iter(held.values())), float)[None]
    whole = (np.broadcast_to(x, (len(x), lanes)) for x in held.values())
    return np.array([np.pad(x, ((0, 0), (0, padded - lanes)), "edge") for x in whole], float)


def _open_loop_step(state: State, inputs: tuple[Any, ...], c: Any) -> State:
    return step(state, inputs[0], c)


class Logged(NamedTuple):
    """A wrist, and what its sensor shows of the angle [deg]."""

    plant: State
    reading: Any


def _times(steps: int, begin: float, dt: float = SAMPLE_TIME) -> Array:
    return np.asarray(begin + np.arange(steps) * dt, float)


def _logged_step(state: Logged, inputs: tuple[Any, ...], c: Any) -> Logged:
    command, other, time = inputs
    plant = step(state.plant, command, c, Around(time, other))
    return Logged(plant, read(plant, c, Around(time + SAMPLE_TIME, other)))


def open_loop(
    wrist: Wrist,
    commands: Any,
    state: State | None = None,
    every: int = 1,
    jobs: int | None = None,
    other_pressure: Any = None,
    begin: float = 0.0,
) -> Response:
    """Response of a wrist to commands [V], one per sample of 1 ms, from rest unless told otherwise.

    Row k is the wrist before command ``k * every`` acts; the last row follows
    the last command.  `angle` is what the sensor shows.  other_pressure [kPa]:
    of the other motion, one per sample; at rest where not given.  begin [s]: time
    of the start, for effects that depend on it.  Raises InputError for a command
    that is not finite.

    >>> from plants import Wrist
    >>> r = open_loop(Wrist.deviation(), [2.5] * 5000)
    >>> len(r.time), round(float(r.angle[-1]), 2)
    (5001, 3.25)
    """
    v = np.asarray(commands, float)
    if v.ndim != 1 or not np.isfinite(v).all():
        raise InputError("commands: need one finite number of volts per sample of 1 ms")
    start, c = wrist.rest() if state is None else state, wrist.sampled()
    if wrist.effects:
        other = np.full(len(v), QUIET.other_pressure) if other_pressure is None else other_pressure
        first = Around(begin, other[0] if len(v) else QUIET.other_pressure)
        start = settled(start, c, first) if state is None else start
        seen = read(start, c, first)
        signals = {"command": v, "other": other, "time": _times(len(v), begin)}
        logged, rows = run_lanes(
            _logged_step, Logged(start, seen), c, len(v), signals, ("command", "other", "time"),
            every, ("plant.pressure", "plant.memory.h", "reading"), jobs,
        )  # fmt: skip
        last = logged.plant
    else:
        last, rows = run_lanes(
            _open_loop_step, start, c, len(v), {"command": v}, ("command",), every,
            ("pressure", "memory.h", "angle"), jobs,
        )  # fmt: skip
    if not any(np.ndim(x) for x in tree.leaves((c, start))):
        rows, last = rows[:, :, 0], tree.like(last, [float(x[0]) for x in tree.leaves(last)])
    return Response(
        np.arange(rows.shape[1], dtype=float) * (every * SAMPLE_TIME), rows[0], rows[1], rows[2], last
    )


def _driven_step(state: Logged, inputs: tuple[Any, ...], c: Any) -> Logged:
    pressure, other, time = inputs
    wrist, dt = c
    plant = bend(state.plant, pressure, state.plant.effects, wrist, Around(time, other))
    return Logged(plant, read(plant, wrist, Around(time + dt, other)))


def driven(
    wrist: Wrist,
    pressures: Any,
    state: State | None = None,
    every: int = 1,
    jobs: int | None = None,
    other_pressure: Any = None,
    begin: float = 0.0,
    dt: float = SAMPLE_TIME,
) -> Array:
    """What the sensor shows [deg], shape (rows, lanes), of a wrist whose pressure [kPa] is given.

    `pressures` has one value more than there are samples, the first being that
    of the start; samples are `dt` [s] apart, which need not be 1 ms, since neither
    loop nor lag depends on it.  The regulator and its effects take no part.
    Other arguments as in `open_loop`.
    """
    p = np.asarray(pressures, float)
    steps = len(p) - 1
    other = np.full(steps, QUIET.other_pressure) if other_pressure is None else other_pressure
    c, first = wrist.sampled(dt), Around(begin, other[0] if steps else QUIET.other_pressure)
    start = (settled(wrist.rest(), c, first) if state is None else state)._replace(pressure=p[0])
    seen = read(start, c, first)
    signals = {"pressure": p[1:], "other": other, "time": _times(steps, begin, dt)}
    _, rows = run_lanes(
        _driven_step, Logged(start, seen), (c, dt), steps, signals, ("pressure", "other", "time"),
        every, ("reading",), jobs,
    )  # fmt: skip
    seen_rows: Array = rows[0]
    return seen_rows
