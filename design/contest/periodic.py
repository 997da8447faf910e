"""Controllers that act once a period (`plants.simulation.periodic`) on the cases of the contest.

Judge, plants, rests, courses, sensor and noise are those that every other controller meets.  Two motions that
move each other are played together, period by period: with the commands of a period known, the plants alone
are relaxed as in `design.contest.coupled`.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.contest.coupled import CLOSE
from design.contest.run import Result, finish
from design.contest.tasks import Asked
from plants.errors import InputError
from plants.simulation.periodic import Periodic, PeriodicLoop, begin, decide, move, play
from plants.simulation.sensor import Sensor
from plants.wrist import State, Wrist

Array = NDArray[np.float64]

MOST_TURNS = 50
"""Turns in a period after which the coupling is too strong for this way."""


def begun(
    wrist: Wrist, controller: Periodic, state: State, asked: Asked, sensor: Sensor, noise: Array
) -> PeriodicLoop:
    """A motion before its first period.  Raises InputError for a period that does not divide the duration."""
    lanes = noise.shape[1]
    return begin(wrist, controller, state, asked.profile, asked.judge, asked.duration, lanes, sensor, noise)


def play_periodic(asked: Asked, **lanes: Any) -> Result:
    """Run lanes through their courses, as `design.contest.run.run`.

    Raises InputError where the window is no whole number of periods.
    """
    last, _ = play(begun(asked=asked, **lanes))
    return finish(asked.judge, last.loop.judge, asked.duration)


def play_coupled(
    controllers: tuple[Periodic, Periodic], lanes: tuple[dict[str, Any], dict[str, Any]]
) -> tuple[Result, Result]:
    """Run two motions that move each other, lane by lane; `lanes`: what `play_periodic` takes of each.

    Raises InputError where the coupling is too strong for turns to come to an end, for periods of unequal
    length, and as `play_periodic`.
    """
    one, two = (begun(controller=c, **of) for c, of in zip(controllers, lanes, strict=True))
    if one.substeps != two.substeps:
        raise InputError("contest: controllers of two coupled motions need the same period")
    for first in range(0, one.commands.shape[0], one.substeps):
        rests = one.loop.plant.pressure, two.loop.plant.pressure
        one, two = decide(one, first, rests[1]), decide(two, first, rests[0])
        after, (path,) = move(one, first, np.broadcast_to(rests[1], (one.substeps, one.late.size)))
        for _ in range(MOST_TURNS):
            other, (beside,) = move(two, first, path[:-1])
            after, (renewed,) = move(one, first, beside[:-1])
            change, path = float(np.abs(renewed - path).max()), renewed
            if change < CLOSE:
                break
        else:
            raise InputError("contest: two coupled motions did not agree; give a weaker coupling")
        one, two = replace(one, loop=after), replace(two, loop=other)
    a, b = (
        finish(of["asked"].judge, s.loop.judge, of["asked"].duration)
        for s, of in zip((one, two), lanes, strict=True)
    )
    return a, b
