"""Both motions at once, each moved by the pressure of the other.

Each motion is a run that is given the other's pressure as a signal.  Played by
turns, each time with the other's latest pressures (waveform relaxation: Lelarasmee, Ruehli &
Sangiovanni-Vincentelli, IEEE Trans. CAD 1 (1982) 131, doi 10.1109/TCAD.1982.1270004), they come to what two
wrists in one loop do: since a sample acts on the other motion only in the sample after, or in the same one
through a static shift, the exact part grows with every turn, and weak coupling makes it contract.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Controller
from design.evaluation.runner import Lanes, PlayedTask, play
from plants.errors import InputError

Array = NDArray[np.float64]

CLOSE = 1e-6
"""Change of any pressure [kPa] in a turn below which the turns end."""

MOST = 100
"""Turns after which the coupling is too strong for this way."""


def run_coupled(
    controllers: tuple[Controller, Controller],
    lanes: tuple[Lanes, Lanes],
    jobs: int | None = None,
) -> tuple[tuple[PlayedTask, PlayedTask], int]:
    """Run two motions, coupled, lane by lane.  Returns what became of both and the turns that it took.

    Raises InputError where the turns do not come to an end.
    """
    pressures: list[Array | None] = [None, None]
    played: list[PlayedTask | None] = [None, None]
    for turn in range(1, MOST + 1):
        change = 0.0
        for me in (0, 1):
            other = pressures[1 - me]
            given = None if other is None else np.ascontiguousarray(other[:-1])
            asked = replace(lanes[me], other_pressure=given)
            mine = play(asked, controllers[me], signals=("plant.pressure",), jobs=jobs)
            rows, before, played[me] = mine.rows[0], pressures[me], mine
            change = max(change, np.inf if before is None else float(np.abs(rows - before).max()))
            pressures[me] = rows
        if change < CLOSE:
            one, two = played
            assert one is not None
            assert two is not None
            return (one, two), turn
    raise InputError(f"contest: two coupled motions did not agree after {MOST} turns; give a weaker coupling")
