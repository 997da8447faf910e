"""One run of the contest: loop, sensor and judge in one law, many lanes at once.

The judge sees the true angle; the controller sees what the sensor shows of it, with noise, in whole quanta.
A stair is settled from the sample on after which the angle stays within the band until the next one begins.
"""

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.contest.tasks import DURATION, Course
from design.controllers.controller import Controller, Measured
from design.loop import holding
from design.metrics import SETTLING_BAND
from design.robustness.samples.noisy_loop import HOLD, Sensor, rounded
from design.tasks import STEP
from plants import tree
from plants import wrist as plant
from plants.effects.effect import Around
from plants.rest import at_rest
from plants.simulate import run_lanes
from plants.wrist import QUIET, SAMPLE_TIME, SampledWrist, State, Wrist

Number = Any
Array = NDArray[np.float64]

BAND = SETTLING_BAND * STEP
"""Half-width of the settling band [deg], the same for all tasks."""


class Tally(NamedTuple):
    """Sums and marks of one run: integral of the error's size [deg s], travel of the command [V] and of
    the pressure [kPa], the command before [V], how far the angle went beyond a reference [deg], samples
    until this stair was settled and the most of any stair, whether one was not."""

    iae: Number
    variation: Number
    travel: Number
    command: Number
    beyond: Number
    outside: Number
    latest: Number
    unsettled: Number


class Run(NamedTuple):
    """State of plant, controller and judge."""

    plant: State
    controller: Any
    tally: Tally


class SampledRun(NamedTuple):
    """Coefficients of plant, controller, sensor and course."""

    plant: SampledWrist
    controller: Any
    sensor: Sensor
    course: Course


@dataclass(frozen=True)
class Result:
    """Judgement of runs, arrays of one shape.

    iae_deg_s; settling_time_s: the slowest stair's, the whole window where one is not settled before the
    next or the end, which `unsettled` (0 or 1) says; overshoot_percent of 15 deg; total_variation_V:
    travel of the command; pressure_travel_kPa: of the pressure, which is the air that was moved.
    """

    iae_deg_s: Array
    settling_time_s: Array
    unsettled: Array
    overshoot_percent: Array
    total_variation_V: Array
    pressure_travel_kPa: Array


METRICS = tuple(f.name for f in fields(Result))


def step(s: Run, inputs: tuple[Number, ...], c: SampledRun) -> Run:
    """One sample: measure, control, judge by the true angle, move.

    inputs: index of the sample, its time [s], noise of standard deviation 1, pressure of the other
    motion [kPa].
    """
    sample, time, noise, other = inputs
    around, asked = Around(time, other), at(sample, c.course)
    seen = rounded(plant.read(s.plant, c.plant, around) + c.sensor.noise * noise, c.sensor)
    measured = Measured(asked.reference - seen, seen, s.plant.pressure)
    controller, command = c.controller.act(s.controller, measured)
    after = plant.step(s.plant, command, c.plant, around)
    tally = judge(s.tally, sample, s.plant, command, after.pressure, asked, c.course)
    return Run(after, controller, tally)


class Asked(NamedTuple):
    """What is asked at a sample: reference [deg], the one before it, the samples at which it begins and
    ends."""

    reference: Number
    before: Number
    begins: Number
    ends: Number


def at(sample: Number, course: Course) -> Asked:
    """What a course asks at a sample; before its first reference stands 0."""
    reference: Number = course.references[0]
    before: Number = 0.0
    begins, ends = course.switches[0], course.end
    for k in range(len(course.switches) - 1, 0, -1):  # the end of the stair that is under way
        ends = np.where(sample < course.switches[k], course.switches[k], ends)
    for earlier, later, switch in zip(
        course.references, course.references[1:], course.switches[1:], strict=False
    ):
        here = sample >= switch
        before = np.where(here, earlier, before)
        reference = np.where(here, later, reference)
        begins = np.where(here, switch, begins)
    return Asked(reference, before, begins, ends)


def judge(
    tally: Tally, sample: Number, s: State, command: Number, pressure: Number, asked: Asked, course: Course
) -> Tally:
    """The tally with one more sample: the state at its start, the command [V] given for it, and the
    pressure [kPa] at its end."""
    counts = np.where(sample >= course.judged_from, 1.0, 0.0)
    error = s.angle - asked.reference
    size = np.abs(error)
    up, down = asked.reference > asked.before, asked.reference < asked.before
    way = np.where(up, 1.0, np.where(down, -1.0, 0.0))
    far = size >= BAND
    outside = np.where(far, sample - asked.begins + 1.0, np.where(sample == asked.begins, 0.0, tally.outside))
    last = sample == asked.ends - 1.0
    return Tally(
        tally.iae + counts * size * SAMPLE_TIME,
        tally.variation + counts * np.abs(command - tally.command),
        tally.travel + counts * np.abs(pressure - s.pressure),
        command,
        np.maximum(tally.beyond, counts * way * error),
        outside,
        np.maximum(tally.latest, counts * outside),
        np.maximum(tally.unsettled, np.where(last, counts * np.where(far, 1.0, 0.0), 0.0)),
    )


def start_of(command: Number) -> Tally:
    """The tally before the first sample, a command [V] having been held until then."""
    return Tally(0.0, 0.0, 0.0, command, 0.0, 0.0, 0.0, 0.0)


def finish(tally: Tally, lanes: int) -> Result:
    """What a tally says after the last sample, leaves (lanes,)."""
    t = Tally(*(np.broadcast_to(np.asarray(x, float), (lanes,)) for x in tally))
    settled = np.where(t.unsettled > 0.0, DURATION, t.latest * SAMPLE_TIME)
    return Result(t.iae, settled, t.unsettled, 100.0 * t.beyond / STEP, t.variation, t.travel)


def run(
    wrist: Wrist,
    controller: Controller,
    state: State,
    asked: Course,
    sensor: Sensor,
    noise: Array,
    other: Array | None = None,
    jobs: int | None = None,
    record: bool = False,
) -> tuple[Result, Array]:
    """Run lanes through their courses; the results, leaves (lanes,), and the pressures [kPa] (samples + 1,
    lanes) where they are recorded.

    noise: of standard deviation 1, (rows, lanes), a row for every 10 samples; other: pressure of the other
    motion [kPa], (samples, lanes), at rest where not given.
    """
    samples = round(DURATION / SAMPLE_TIME)
    lanes = noise.shape[1]
    held = holding(wrist, controller, state)
    first = Run(state, held, start_of(controller.command(held)))
    c = SampledRun(wrist.sampled(), controller.sampled(), sensor, asked)
    own = {
        "noise": np.repeat(noise, HOLD, axis=0)[:samples],
        "other": np.full((samples, lanes), QUIET.other_pressure) if other is None else other,
    }
    time = np.arange(samples) * SAMPLE_TIME
    last, rows = run_lanes(
        step, first, c, samples, {"time": time}, ("sample", "time", *own), int(record),
        ("plant.pressure",) if record else (), jobs, own,
    )  # fmt: skip
    return finish(last.tally, lanes), rows[0] if record else np.empty((0, lanes))


def lanes_of(wrist: Wrist, pick: NDArray[np.intp]) -> Wrist:
    """Some lanes of a wrist with lanes."""
    values = {n: np.broadcast_to(np.asarray(v, float), _lanes(wrist))[pick] for n, v in wrist.values.items()}
    return Wrist.from_values(values, wrist.forms)


def _lanes(wrist: Wrist) -> tuple[int, ...]:
    return np.broadcast_shapes(*(np.shape(v) for v in wrist.values.values()))


def rests(wrist: Wrist, starts: list[Any], angles: list[float]) -> State:
    """State of each lane of a wrist at rest, having come to its angle [deg] by its start."""
    state: list[Array] = [np.empty(len(starts)) for _ in tree.leaves(wrist.rest())]
    for start, angle in dict.fromkeys(zip(starts, angles, strict=True)):
        here = np.array([(s, a) == (start, angle) for s, a in zip(starts, angles, strict=True)])
        pick = np.flatnonzero(here)
        found = at_rest(
            lanes_of(wrist, pick), start, angle if start == "virgin" else np.full(pick.size, angle)
        )
        for into, leaf in zip(state, tree.leaves(found), strict=True):
            into[here] = leaf
    rested: State = tree.like(wrist.rest(), state)
    return rested
