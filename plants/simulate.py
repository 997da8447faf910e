"""Rollouts of a sampled system: one or a batch of lanes, open loop, on any number of threads."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plants.effects.effect import Around
from plants.errors import InputError
from plants.kernel import pytrees as tree
from plants.kernel.batches import default_jobs, run_lanes
from plants.wrist import QUIET, SAMPLE_TIME, State, Wrist, bend, read, settled, step

Array = NDArray[np.float64]

__all__ = ["Response", "default_jobs", "driven", "open_loop", "run_lanes"]


@dataclass(frozen=True)
class Response:
    """An open-loop response: time [s]; pressure [kPa], static angle and angle [deg], each
    of shape (rows,) or, for a wrist with arrays as parameters, (rows, lanes)."""

    time: Array
    pressure: Array
    static_angle: Array
    angle: Array
    state: State


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
