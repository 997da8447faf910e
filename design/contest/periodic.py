"""Controllers that act once a period, such as an MPC, on the cases of the contest.

A QP cannot be part of a law that is compiled, so the loop is cut at the periods: the plants of all
lanes advance together by compiled code, the command held, and the controller steps lane by lane.  Judge,
plants, rests, courses, sensor and noise are those that every other controller meets.  As in
`design.mpc.loop`, transport is kept here, since it is the command that is late.

Two motions that move each other are played together, period by period: with the commands of a period known,
the plants alone are relaxed as in `design.contest.coupled`.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from design.contest.coupled import CLOSE
from design.contest.run import Result, Tally, at, finish, judge, start_of
from design.contest.tasks import DURATION, Course
from design.controllers.controller import Measured
from design.robustness.samples.noisy_loop import HOLD, Sensor, rounded
from plants import wrist as plant
from plants.delay import arriving
from plants.effects.effect import Around
from plants.errors import InputError
from plants.simulate import run_lanes
from plants.wrist import QUIET, SAMPLE_TIME, SampledWrist, State, Wrist

Number = Any
Array = NDArray[np.float64]

MOST_TURNS = 50
"""Turns in a period after which the coupling is too strong for this way."""


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


class Played(NamedTuple):
    """State of plant and judge."""

    plant: State
    tally: Tally


class SampledPlayed(NamedTuple):
    """Coefficients of plant and course."""

    plant: SampledWrist
    course: Course


@dataclass(frozen=True)
class Side:
    """One motion under way: its controller, coefficients, sensor and noise, delay of each lane in samples,
    commands [V] before the start (lanes,) and of every sample so far (samples, lanes), the controller's
    state of each lane, plants with judges."""

    controller: Periodic
    c: SampledPlayed
    sensor: Sensor
    noise: Array
    late: Array
    before: Array
    commands: Array
    memories: list[Any]
    played: Played

    @property
    def substeps(self) -> int:
        """Samples in a period."""
        return int(self.controller.problem.substeps)


def step(s: Played, inputs: tuple[Number, ...], c: SampledPlayed) -> Played:
    """One sample: move and judge.  inputs: index of the sample, its time [s], command that was given and
    command that arrives [V], pressure of the other motion [kPa]."""
    sample, time, given, arrives, other = inputs
    after = plant.step(s.plant, arrives, c.plant, Around(time, other))
    tally = judge(s.tally, sample, s.plant, given, after.pressure, at(sample, c.course), c.course)
    return Played(after, tally)


def play_periodic(
    wrist: Wrist, controller: Periodic, state: State, asked: Course, sensor: Sensor, noise: Array
) -> Result:
    """Run lanes through their courses, as `design.contest.run.run`.

    Raises InputError where the window is no whole number of periods.
    """
    s = begin(wrist, controller, state, asked, sensor, noise)
    for first in range(0, s.commands.shape[0], s.substeps):
        s = decide(s, first, QUIET.other_pressure)
        s = replace(s, played=advance(s, first)[0])
    return finish(s.played.tally, noise.shape[1])


def play_coupled(
    controllers: tuple[Periodic, Periodic], lanes: tuple[dict[str, Any], dict[str, Any]]
) -> tuple[Result, Result]:
    """Run two motions that move each other, lane by lane; `lanes`: what `play_periodic` takes of each.

    Raises InputError where the coupling is too strong for turns to come to an end, for periods of unequal
    length, and as `play_periodic`.
    """
    one, two = (begin(controller=c, **of) for c, of in zip(controllers, lanes, strict=True))
    if one.substeps != two.substeps:
        raise InputError("contest: controllers of two coupled motions need the same period")
    for first in range(0, one.commands.shape[0], one.substeps):
        rests = one.played.plant.pressure, two.played.plant.pressure
        one, two = decide(one, first, rests[1]), decide(two, first, rests[0])
        after, path = advance(one, first, np.broadcast_to(rests[1], (one.substeps, one.late.size)))
        for _ in range(MOST_TURNS):
            other, beside = advance(two, first, path[:-1])
            after, renewed = advance(one, first, beside[:-1])
            change, path = float(np.abs(renewed - path).max()), renewed
            if change < CLOSE:
                break
        else:
            raise InputError("contest: two coupled motions did not agree; give a weaker coupling")
        one, two = replace(one, played=after), replace(two, played=other)
    return finish(one.played.tally, one.late.size), finish(two.played.tally, two.late.size)


def begin(
    wrist: Wrist, controller: Periodic, state: State, asked: Course, sensor: Sensor, noise: Array
) -> Side:
    """A motion before its first period, its controller having seen it at rest.

    Raises InputError for a period that does not divide the duration.
    """
    substeps, samples, lanes = controller.problem.substeps, round(DURATION / SAMPLE_TIME), noise.shape[1]
    if samples % substeps:
        raise InputError(
            f"contest: {DURATION:g} s are no whole number of periods; give a period that divides it"
        )
    late = np.broadcast_to(wrist.values["dead-time.delay"], (lanes,)) / SAMPLE_TIME
    c = SampledPlayed(wrist.with_values(**{"dead-time.delay": np.zeros(lanes)}).sampled(), asked)
    seen = shown(state, c.plant, sensor, noise[0], QUIET)
    pressure = np.broadcast_to(state.pressure, (lanes,))
    memories = [
        controller.init(Measured(0.0, float(y), float(P))) for y, P in zip(seen, pressure, strict=True)
    ]
    before = np.array([m.command for m in memories])
    commands = np.empty((samples, lanes))
    return Side(
        controller, c, sensor, noise, late, before, commands, memories, Played(state, start_of(before))
    )


def shown(state: State, c: SampledWrist, sensor: Sensor, noise: Array, around: Around) -> Array:
    """The angle [deg] of each lane that the sensor shows, (lanes,)."""
    return np.broadcast_to(rounded(plant.read(state, c, around) + sensor.noise * noise, sensor), noise.shape)


def decide(s: Side, first: int, other: Number) -> Side:
    """The motion with the commands of the period from a sample on; other: pressure of the other motion then
    [kPa]."""
    around = Around(first * SAMPLE_TIME, other)
    seen = shown(s.played.plant, s.c.plant, s.sensor, s.noise[first // HOLD], around)
    error = np.broadcast_to(at(float(first), s.c.course).reference, seen.shape) - seen
    pressure = np.broadcast_to(s.played.plant.pressure, seen.shape)
    memories = []
    for lane, memory in enumerate(s.memories):
        measured = Measured(float(error[lane]), float(seen[lane]), float(pressure[lane]))
        after, command, _ = s.controller.step(memory, measured)
        s.commands[first : first + s.substeps, lane] = command
        memories.append(after)
    return replace(s, memories=memories)


def advance(s: Side, first: int, other: Array | None = None) -> tuple[Played, Array]:
    """Plants and judges after the period from a sample on, and the pressures [kPa] on the way, (substeps + 1,
    lanes); other: those of the other motion at the start of each sample, (substeps, lanes), at rest where
    not given."""
    index = np.arange(first, first + s.substeps, dtype=float)
    given = s.commands[first : first + s.substeps]
    own = {
        "given": given,
        "arrives": arriving(s.commands, s.before, s.late, index),
        "other": np.full(given.shape, QUIET.other_pressure) if other is None else np.ascontiguousarray(other),
    }
    signals = {"index": index, "time": index * SAMPLE_TIME}
    played, rows = run_lanes(
        step, s.played, s.c, s.substeps, signals, ("index", "time", *own), 1, ("plant.pressure",),
        jobs=1, held=own, hold=1,
    )  # fmt: skip
    return played, rows[0]
