"""The closed loop around a controller that acts once a period, such as an MPC.

A QP cannot be part of a law that is compiled, so the loop is cut at the periods: plants and judges of all
lanes advance together by compiled code, the command held, and the controller steps lane by lane.  Law,
sensor, reference profile and judge are those of every other loop (`plants.simulation.closed_loop`).  A dead
time of transport is kept here, since the line of a delay does not outlast a call of the compiled plant: it is
the command that is late.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from plants import dynamics as plant
from plants.actuator.delay import arriving
from plants.dynamics import QUIET, State
from plants.effects.effect import Around
from plants.errors import InputError
from plants.simulation.closed_loop import ClosedLoop, SampledClosedLoop, advance
from plants.simulation.reference_profile import ReferenceProfile
from plants.simulation.sensor import HOLD, PERFECT, Measured, Sensor

if TYPE_CHECKING:
    from plants.wrist import Wrist

Number = Any
Array = NDArray[np.float64]

DELAY = "dead-time.delay"
"""Parameter of the plant that holds its transport, whatever the form of the dead time."""


@runtime_checkable
class Periodic(Protocol):
    """A controller with pure `init` and `step`, `problem.substeps` samples apart."""

    @property
    def problem(self) -> Any:
        """Whose `substeps` is the number of samples of 1 ms in a period."""
        ...

    def init(self, seen: Measured) -> Any:
        """State in which a wrist that is seen to rest is held, with the command [V] as `command`."""
        ...

    def step(self, state: Any, seen: Measured) -> tuple[Any, float, Any]:
        """State after, command [V] of, and a record of one period."""
        ...


@dataclass(frozen=True)
class PeriodicLoop:
    """A loop under way: its controller, coefficients, noise of its sensor of standard deviation 1 (rows,
    lanes), a row for every `HOLD` samples, delay of each lane in samples, commands [V] before the start
    (lanes,) and of every sample so far (samples, lanes), the controller's state of each lane, what it told of
    each period, plants with judges, time of the start [s]."""

    controller: Periodic
    c: SampledClosedLoop
    noise: Array | None
    late: Array
    before: Array
    commands: Array
    memories: list[Any]
    periods: list[Any]
    loop: ClosedLoop
    begin: float
    dt: float

    @property
    def substeps(self) -> int:
        """Samples in a period."""
        return int(self.controller.problem.substeps)

    def period(self, first: int) -> slice:
        """The samples of the period that begins with a sample; the last one may be cut short."""
        return slice(first, min(first + self.substeps, self.commands.shape[0]))

    def around(self, sample: int, other: Number) -> Around:
        """Surroundings at a sample; other: how far the other motion's pressure is from rest [kPa]."""
        return Around(self.begin + sample * self.dt, other)


def prompt(wrist: "Wrist") -> "Wrist":
    """The wrist with the transport of its dead time taken out."""
    return wrist.with_values(**{DELAY: 0.0 * wrist.values[DELAY]}) if DELAY in wrist.values else wrist


def begin(
    wrist: "Wrist",
    controller: Periodic,
    state: State,
    reference: ReferenceProfile,
    judge: Any,
    duration: float,
    lanes: int = 1,
    sensor: Sensor = PERFECT,
    noise: Array | None = None,
    begin: float = 0.0,
    memories: list[Any] | None = None,
) -> PeriodicLoop:
    """A loop before its first period, the controller having seen the plant at rest unless it comes with
    `memories` of its own.  Where a duration [s] is no whole number of periods, its last one is cut short.

    Raises InputError for a duration without a sample.
    """
    dt = wrist.rig.sample_time
    samples = round(duration / dt)
    if samples < 1:
        raise InputError(f"duration of {duration:g} s: give at least a sample, {dt:g} s")
    late = np.broadcast_to(wrist.values.get(DELAY, 0.0), (lanes,)) / dt
    c = SampledClosedLoop(prompt(wrist).sampled(), (), reference, judge, sensor)
    first = ClosedLoop(state)
    s = PeriodicLoop(
        controller, c, noise, late, np.empty(0), np.empty((samples, lanes)), [], [], first, begin, dt
    )
    if memories is None:
        seen, pressure = shown(s, 0, QUIET.other_pressure), np.broadcast_to(state.pressure, (lanes,))
        memories = [
            controller.init(Measured(0.0, float(y), float(P))) for y, P in zip(seen, pressure, strict=True)
        ]
    before = np.array([m.command for m in memories], float)
    first = first._replace(judge=judge.begin(before, state.angle))
    return replace(s, before=before, memories=memories, loop=first)


def shown(s: PeriodicLoop, sample: int, other: Number) -> Array:
    """The angle [deg] of each lane that the sensor shows at a sample, (lanes,)."""
    angle = plant.read(s.loop.plant, s.c.plant, s.around(sample, other))
    noise = 0.0 if s.noise is None else s.noise[sample // HOLD]
    return np.broadcast_to(s.c.sensor.shows(angle, noise), s.late.shape)


def decide(s: PeriodicLoop, first: int, other: Number = QUIET.other_pressure) -> PeriodicLoop:
    """The loop with the commands of the period from a sample on; other: how far the other motion's
    pressure is from rest then [kPa]."""
    seen = shown(s, first, other)
    error = np.broadcast_to(s.c.reference.at(float(first)).reference, seen.shape) - seen
    pressure = np.broadcast_to(s.loop.plant.pressure, seen.shape)
    memories = []
    for lane, memory in enumerate(s.memories):
        measured = Measured(float(error[lane]), float(seen[lane]), float(pressure[lane]))
        after, command, told = s.controller.step(memory, measured)
        s.commands[s.period(first), lane] = command
        memories.append(after)
        s.periods.append(told)
    return replace(s, memories=memories)


def move(
    s: PeriodicLoop, first: int, other: Array | None = None, record: tuple[str, ...] = ("plant.pressure",)
) -> tuple[ClosedLoop, Array]:
    """Plants and judges after the period from a sample on, and what is recorded on the way, (signals,
    samples + 1, lanes); other: how far the other motion's pressure is from rest [kPa] at the start of
    each sample, (samples, lanes), at rest where not given."""
    period = s.period(first)
    index = np.arange(period.start, period.stop, dtype=float)
    own = {
        "command": s.commands[period],
        "arriving": arriving(s.commands, s.before, s.late, index),
    }
    if other is not None:
        own["other_pressure"] = np.ascontiguousarray(other)
    shared = {"index": index, "time": s.begin + index * s.dt}
    return advance(s.loop, s.c, index.size, shared, own, every=1, record=record, jobs=1)


def play(s: PeriodicLoop, record: tuple[str, ...] = ()) -> tuple[PeriodicLoop, Array]:
    """The loop after its last period, and what is recorded in every sample, (signals, samples + 1, lanes)."""
    pieces = []
    for first in range(0, s.commands.shape[0], s.substeps):
        s = decide(s, first)
        after, rows = move(s, first, record=record)
        s = replace(s, loop=after)
        pieces.append(rows[:, :-1])
    return s, np.concatenate([*pieces, rows[:, -1:]], axis=1)
