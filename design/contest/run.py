"""One run of the contest: many lanes at once.

The judge sees the true angle; the controller sees what the sensor shows of it, with noise, in whole quanta.
A stair is settled from the sample on after which the angle stays within the band until the next one begins.
"""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.contest.tasks import Asked
from design.controllers.controller import Controller
from design.loop import holding
from design.metrics import SETTLING_BAND, Tally, Yardstick
from design.tasks import STEP
from plants.kernel import pytrees as tree
from plants.rest import at_rest
from plants.simulation.closed_loop import ClosedLoop, SampledClosedLoop, advance, clock
from plants.simulation.sensor import HOLD, Sensor
from plants.wrist import SAMPLE_TIME, State, Wrist

Number = Any
Array = NDArray[np.float64]

BAND = SETTLING_BAND * STEP
"""Half-width of the settling band [deg], the same for all tasks."""


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


def finish(judge: Yardstick, tally: Tally, duration: float) -> Result:
    """What a tally says after the last sample of runs of a duration [s], leaves (lanes,)."""
    m = judge.finish(tally, round(duration / SAMPLE_TIME))
    unsettled = np.isinf(m.settling_time_s)
    return Result(
        m.iae_deg_s, np.where(unsettled, duration, m.settling_time_s), unsettled.astype(float),
        m.overshoot_percent, m.total_variation_V, np.asarray(tally.stairs.travel, float),
    )  # fmt: skip


def run(
    wrist: Wrist,
    controller: Controller,
    state: State,
    asked: Asked,
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
    samples = round(asked.duration / SAMPLE_TIME)
    held = holding(wrist, controller, state)
    first = ClosedLoop(state, held, asked.judge.begin(controller.command(held)))
    c = SampledClosedLoop(wrist.sampled(), controller.sampled(), asked.profile, asked.judge, sensor)
    own, hold = ({"noise": noise} if sensor.noise else {}), HOLD
    if other is not None:  # another value in every sample
        own, hold = {n: np.repeat(x, HOLD, axis=0)[:samples] for n, x in own.items()}, 1
        own["other_pressure"] = other
    last, rows = advance(
        first, c, samples, clock(wrist, samples), own, hold, int(record),
        ("plant.pressure",) if record else (), jobs,
    )  # fmt: skip
    return finish(asked.judge, last.judge, asked.duration), rows[0] if record else np.empty(
        (0, noise.shape[1])
    )


def lanes_of(wrist: Wrist, pick: NDArray[np.intp]) -> Wrist:
    """Some lanes of a wrist with lanes."""
    values = {n: np.broadcast_to(np.asarray(v, float), _lanes(wrist))[pick] for n, v in wrist.values.items()}
    return wrist.made_of(values)


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
