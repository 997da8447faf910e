"""Controllers that act once a period, such as an MPC, on the cases of the contest.

A QP cannot be part of a law that is compiled, so the loop is cut at the periods: the plants of all
lanes advance together by compiled code, the command held, and the controller steps lane by lane.  Judge,
plants, rests, courses, sensor and noise are those that every other controller meets.  As in
`design.mpc.loop`, transport is kept here, since it is the command that is late, and the controller is told
the memory of the wrist at rest (others take it from angle and pressure).
"""

from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from design.contest.run import Result, Tally, at, finish, judge, start_of
from design.contest.tasks import DURATION, Course
from design.controllers.controller import Measured
from design.robustness.samples.noisy_loop import HOLD, Sensor, rounded
from plants import tree
from plants import wrist as plant
from plants.effects.effect import Around
from plants.errors import InputError
from plants.simulate import run_lanes
from plants.wrist import SAMPLE_TIME, SampledWrist, State, Wrist

Number = Any
Array = NDArray[np.float64]


@runtime_checkable
class Periodic(Protocol):
    """A controller with pure `init` and `step`, `problem.substeps` samples apart."""

    @property
    def problem(self) -> Any:
        """Whose `substeps` is the number of samples of 1 ms in a period."""
        ...

    def init(self, wrist_at_rest: State) -> Any:
        """State in which a wrist at rest is held, with the command [V] as `command`."""
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


def step(s: Played, inputs: tuple[Number, ...], c: SampledPlayed) -> Played:
    """One sample: move and judge.  inputs: index of the sample, its time [s], command that was given and
    command that arrives [V]."""
    sample, time, given, arrives = inputs
    after = plant.step(s.plant, arrives, c.plant, Around(time))
    tally = judge(s.tally, sample, s.plant, given, after.pressure, at(sample, c.course), c.course)
    return Played(after, tally)


def play_periodic(
    wrist: Wrist, controller: Periodic, state: State, asked: Course, sensor: Sensor, noise: Array
) -> Result:
    """Run lanes through their courses, as `design.contest.run.run`.

    Raises InputError where the window is no whole number of periods.
    """
    substeps, samples, lanes = controller.problem.substeps, round(DURATION / SAMPLE_TIME), noise.shape[1]
    if samples % substeps:
        raise InputError(
            f"contest: {DURATION:g} s are no whole number of periods; give a period that divides it"
        )
    late = np.broadcast_to(wrist.values["dead-time.delay"], (lanes,)) / SAMPLE_TIME
    prompt = wrist.with_values(**{"dead-time.delay": np.zeros(lanes)})
    c = SampledPlayed(prompt.sampled(), asked)
    bare = np.array([np.broadcast_to(x, (lanes,)) for x in tree.leaves(state._replace(effects=()))])
    memories = [
        controller.init(tree.like(state._replace(effects=()), [float(x) for x in bare[:, lane]]))
        for lane in range(lanes)
    ]
    before = np.array([m.command for m in memories])
    commands = np.empty((samples, lanes))
    loop = Played(state, start_of(before))
    for first in range(0, samples, substeps):
        time = first * SAMPLE_TIME
        reading = plant.read(loop.plant, c.plant, Around(time)) + sensor.noise * noise[first // HOLD]
        seen = np.broadcast_to(rounded(reading, sensor), (lanes,))
        error = np.broadcast_to(at(float(first), asked).reference, (lanes,)) - seen
        pressure = np.broadcast_to(loop.plant.pressure, (lanes,))
        for lane in range(lanes):
            measured = Measured(float(error[lane]), float(seen[lane]), float(pressure[lane]))
            memories[lane], command, _ = controller.step(memories[lane], measured)
            commands[first : first + substeps, lane] = command
        index = np.arange(first, first + substeps, dtype=float)
        own = {
            "given": commands[first : first + substeps],
            "arrives": arriving(commands, before, late, index),
        }
        signals = {"index": index, "time": index * SAMPLE_TIME}
        loop, _ = run_lanes(
            step, loop, c, substeps, signals, ("index", "time", *own), jobs=1, held=own, hold=1
        )  # fmt: skip
    return finish(loop.tally, lanes)


def arriving(commands: Array, before: Array, late: Array, index: Array) -> Array:
    """Commands [V] as they arrive at samples, `late` samples (lanes,) after they were given, linear between
    two samples as `plants.delay` has it; `before` (lanes,) was held until the start."""
    whole = np.floor(late + 1e-9).astype(int)
    share, lanes = np.maximum(late - whole, 0.0), np.arange(late.size)

    def given(at_: NDArray[np.intp]) -> Array:
        return np.where(at_ >= 0, commands[np.maximum(at_, 0), lanes], before)

    near = index.astype(int)[:, None] - whole
    found: Array = (1.0 - share) * given(near) + share * given(near - 1)
    return found
