"""The plant without a loop around it: driven by commands, or by a pressure that is given."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plants.dynamics import QUIET, SampledWrist, State, bend, press, read, settled, step
from plants.effects.effect import Around
from plants.errors import InputError
from plants.kernel import pytrees
from plants.kernel.batches import run_lanes

if TYPE_CHECKING:
    from plants.wrist import Wrist

Array = NDArray[np.float64]


@dataclass(frozen=True)
class OpenLoopResponse:
    """An open-loop response: time [s]; pressure [kPa], static angle and angle [deg], each
    of shape (rows,) or, for a wrist with arrays as parameters, (rows, lanes)."""

    time: Array
    pressure: Array
    static_angle: Array
    angle: Array
    state: State


class OpenLoop(NamedTuple):
    """The plant, and what its sensor shows of the angle [deg] where that is not the angle itself."""

    plant: State
    reading: Any = ()


class SampledOpenLoop(NamedTuple):
    """Coefficients of the plant, and the sample time [s]."""

    plant: SampledWrist
    dt: float


@cache
def law(names: tuple[str, ...]) -> Callable[..., OpenLoop]:
    """The law of one sample with its signals in the order of some names: ``command`` [V] or, for a plant
    whose regulator takes no part, ``pressure`` [kPa] at its end; ``other``, pressure of the other motion
    [kPa], and ``time`` [s] where there are effects."""

    def open_loop(s: OpenLoop, inputs: tuple[Any, ...], c: SampledOpenLoop) -> OpenLoop:
        given: dict[str, Any] = dict(zip(names, inputs, strict=True))
        time: Any = given.get("time", QUIET.time)
        other = given.get("other", QUIET.other_pressure)
        around = Around(time, other)
        if "pressure" in given:
            after = bend(s.plant, given["pressure"], s.plant.effects, c.plant, around)
        else:
            after = step(s.plant, given["command"], c.plant, around)
        shown = not isinstance(s.reading, tuple)
        return OpenLoop(after, read(after, c.plant, Around(time + c.dt, other)) if shown else ())

    return open_loop


@cache
def regulator_law(names: tuple[str, ...]) -> Callable[..., State]:
    """As `law`, of the regulator alone: loop and joint take no part, and have no state."""

    def pressed(s: State, inputs: tuple[Any, ...], c: SampledOpenLoop) -> State:
        given: dict[str, Any] = dict(zip(names, inputs, strict=True))
        around = Around(given.get("time", QUIET.time), given.get("other", QUIET.other_pressure))
        pressure, effects = press(s, given["command"], c.plant, around)
        return s._replace(pressure=pressure, effects=effects)

    return pressed


def surroundings(
    wrist: "Wrist", samples: int, begin: float = 0.0, other_pressure: Any = None
) -> dict[str, Any]:
    """The signals that a plant with effects needs beside its command, from a time `begin` [s] on; others need
    none."""
    if not wrist.effects:
        return {}
    other = np.zeros(samples) if other_pressure is None else other_pressure - wrist.rig.rest_pressure
    return {"other": other, "time": _times(samples, begin, wrist.rig.sample_time)}


def _times(samples: int, begin: float, dt: float) -> Array:
    return np.asarray(begin + np.arange(samples) * dt, float)


def open_loop(
    wrist: "Wrist",
    commands: Any,
    state: State | None = None,
    every: int = 1,
    jobs: int | None = None,
    other_pressure: Any = None,
    begin: float = 0.0,
) -> OpenLoopResponse:
    """Response of a wrist to commands [V], one per sample, from rest unless told otherwise.

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
        raise InputError("commands: need one finite number of volts per sample")
    start, c, dt = wrist.rest() if state is None else state, wrist.sampled(), wrist.rig.sample_time
    signals = {"command": v, **surroundings(wrist, len(v), begin, other_pressure)}
    seen: Any = ()
    if wrist.effects:
        first = Around(begin, signals["other"][0] if len(v) else QUIET.other_pressure)
        start = settled(start, c, first) if state is None else start
        seen = read(start, c, first)
    angle = "reading" if wrist.effects else "plant.angle"
    last, rows = run_lanes(
        law(tuple(signals)), OpenLoop(start, seen), SampledOpenLoop(c, dt), len(v), signals, tuple(signals),
        every, ("plant.pressure", "plant.memory.h", angle), jobs,
    )  # fmt: skip
    after = last.plant
    if not any(np.ndim(x) for x in pytrees.leaves((c, start))):
        rows, after = rows[:, :, 0], pytrees.like(after, [float(x[0]) for x in pytrees.leaves(after)])
    return OpenLoopResponse(
        np.arange(rows.shape[1], dtype=float) * (every * dt), rows[0], rows[1], rows[2], after
    )


def pressed(
    wrist: "Wrist",
    commands: Any,
    state: State | None = None,
    every: int = 1,
    jobs: int | None = None,
    other_pressure: Any = None,
    begin: float = 0.0,
) -> Array:
    """The pressure [kPa] of `open_loop`, of a wrist whose effects are those of its regulator: nothing behind
    it acts back on it, so that a third of the arithmetic will do.

    Arguments and shape as there.

    >>> from plants import Wrist
    >>> round(float(pressed(Wrist.deviation(), [2.5] * 5000)[-1]), 3)
    123.336
    """
    v = np.asarray(commands, float)
    start, c, dt = wrist.rest() if state is None else state, wrist.sampled(), wrist.rig.sample_time
    signals = {"command": v, **surroundings(wrist, len(v), begin, other_pressure)}
    own = State(start.pressure, (), 0.0, start.effects)
    _, rows = run_lanes(
        regulator_law(tuple(signals)), own, SampledOpenLoop(c, dt), len(v), signals, tuple(signals), every,
        ("pressure",), jobs,
    )  # fmt: skip
    single = not any(np.ndim(x) for x in pytrees.leaves((c, own)))
    found: Array = rows[0, :, 0] if single else rows[0]
    return found


def driven(
    wrist: "Wrist",
    pressures: Any,
    state: State | None = None,
    every: int = 1,
    jobs: int | None = None,
    other_pressure: Any = None,
    begin: float = 0.0,
    dt: float | None = None,
) -> Array:
    """What the sensor shows [deg], shape (rows, lanes), of a wrist whose pressure [kPa] is given.

    `pressures` has one value more than there are samples, the first being that
    of the start; samples are `dt` [s] apart, the rig's sample time where not given; it may be another,
    since neither loop nor lag depends on it.  The regulator and its effects take no part.
    Other arguments as in `open_loop`.
    """
    p = np.asarray(pressures, float)
    steps, dt = len(p) - 1, wrist.rig.sample_time if dt is None else dt
    other = np.zeros(steps) if other_pressure is None else other_pressure - wrist.rig.rest_pressure
    c, first = wrist.sampled(dt), Around(begin, other[0] if steps else QUIET.other_pressure)
    start = (settled(wrist.rest(), c, first) if state is None else state)._replace(pressure=p[0])
    signals = {"pressure": p[1:], "other": other, "time": _times(steps, begin, dt)}
    _, rows = run_lanes(
        law(tuple(signals)), OpenLoop(start, read(start, c, first)), SampledOpenLoop(c, dt), steps, signals,
        tuple(signals), every, ("reading",), jobs,
    )  # fmt: skip
    seen_rows: Array = rows[0]
    return seen_rows
