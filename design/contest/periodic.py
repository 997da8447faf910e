"""Both motions at once, each moved by the pressure of the other, under controllers that act once a period.

They are played together, period by period: with the commands of a period known, the plants alone are relaxed
as in `design.contest.coupled`.
"""

from dataclasses import replace

import numpy as np

from design.contest.coupled import CLOSE
from design.evaluation.runner import Lanes, PlayedTask, begun, ended
from plants.errors import InputError
from plants.simulation.periodic import Periodic, decide, move

MOST_TURNS = 50
"""Turns in a period after which the coupling is too strong for this way."""


def play_coupled(
    controllers: tuple[Periodic, Periodic], lanes: tuple[Lanes, Lanes]
) -> tuple[PlayedTask, PlayedTask]:
    """Play two motions that move each other, lane by lane.

    Raises InputError where the coupling is too strong for turns to come to an end, for periods of unequal
    length, and as `design.evaluation.runner.play`.
    """
    one, two = (begun(of, c) for c, of in zip(controllers, lanes, strict=True))
    if one.substeps != two.substeps:
        raise InputError("contest: controllers of two coupled motions need the same period")
    rest = lanes[0].wrist.rig.rest_pressure
    for first in range(0, one.commands.shape[0], one.substeps):
        rests = one.loop.plant.pressure - rest, two.loop.plant.pressure - rest
        one, two = decide(one, first, rests[1]), decide(two, first, rests[0])
        after, (path,) = move(one, first, np.broadcast_to(rests[1], one.commands[one.period(first)].shape))
        for _ in range(MOST_TURNS):
            other, (beside,) = move(two, first, path[:-1] - rest)
            after, (renewed,) = move(one, first, beside[:-1] - rest)
            change, path = float(np.abs(renewed - path).max()), renewed
            if change < CLOSE:
                break
        else:
            raise InputError("contest: two coupled motions did not agree; give a weaker coupling")
        one, two = replace(one, loop=after), replace(two, loop=other)
    nothing = np.empty((0, 0, one.late.size))
    return ended(lanes[0], one, nothing), ended(lanes[1], two, nothing)
