"""One run of the contest: many lanes at once.

The judge sees the true angle; the controller sees what the sensor shows of it, with noise, in whole quanta.
A stair is settled from the sample on after which the angle stays within the band until the next one begins.
"""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Controller
from design.evaluation.metrics import Metrics
from design.evaluation.runner import Lanes, play
from plants.equilibrium import at_rest
from plants.kernel import pytrees as tree
from plants.simulation.closed_loop import ClosedLoop
from plants.simulation.periodic import Periodic
from plants.wrist import State, Wrist

Number = Any
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Result:
    """Judgement of runs, arrays of one shape.

    iae_deg_s; settling_time_s: the slowest stair's, the whole window where one is not settled before the
    next or the end, which `unsettled` (0 or 1) says; overshoot_percent of 15 deg; total_variation_V:
    total variation of the command; pressure_travel_kPa: of the pressure, which is the air that was moved.
    """

    iae_deg_s: Array
    settling_time_s: Array
    unsettled: Array
    overshoot_percent: Array
    total_variation_V: Array
    pressure_travel_kPa: Array


METRICS = tuple(f.name for f in fields(Result))


def result(lanes: Lanes, metrics: Metrics, last: ClosedLoop) -> Result:
    """What became of lanes that were judged stair by stair, leaves (lanes,)."""
    unsettled = np.isinf(metrics.settling_time_s)
    return Result(
        metrics.iae_deg_s, np.where(unsettled, lanes.duration, metrics.settling_time_s),
        unsettled.astype(float), metrics.overshoot_percent, metrics.total_variation_V,
        np.asarray(last.judge.stairs.travel, float),
    )  # fmt: skip


def run(
    lanes: Lanes, controller: Controller | Periodic, jobs: int | None = None, record: bool = False
) -> tuple[Result, Array]:
    """Play lanes; the results, leaves (lanes,), and the pressures [kPa] (samples + 1, lanes) where they are
    recorded."""
    played = play(lanes, controller, signals=("plant.pressure",) if record else (), jobs=jobs)
    pressures = played.rows[0] if record else np.empty((0, lanes.count))
    return result(lanes, played.metrics, played.last), pressures


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
