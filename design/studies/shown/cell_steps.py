"""The step of the nominal plant under every cell of a map of gains, in few samples: a page shows the one that
is asked for."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Controller
from design.evaluation.runner import play, step_from
from design.robustness.tuning.gain_search import law_of
from design.synthesis.tuning import Tuning
from plants.simulation.disturbance import at_rest, burdened
from plants.wrist import Wrist

Array = NDArray[np.float64]

SECONDS, EVERY = 3.0, 40
"""How long a step is kept [s], and how many samples lie between two rows that are kept, at first."""

DENSE, SPARSE = 25, 3
"""How many rows are kept from the start, a second, and of the later ones every so many."""


@dataclass(frozen=True)
class CellSteps:
    """Steps from rest under gains (n,), flattened with Kp in rows as the evaluation of their map.

    time [s] (rows,); angle [deg] (n, rows) by the dead time [s] beside the plant's own, 0 first.
    """

    time: Array
    angle: dict[float, Array]
    reference: float


def cell_steps(wrist: Wrist, many: Controller) -> CellSteps:
    """Play the step of the task from rest under controllers, lanes of one, without and with the longest
    dead time that the rig states.

    >>> from design.controllers.pi import PI
    >>> found = cell_steps(Wrist.flexion(), PI(np.array([1.2, 2.3]), np.array([2.2, 6.4])))
    >>> sorted(found.angle), found.angle[0.0].shape == (2, found.time.size)
    ([0.0, 0.05], True)
    """
    rig = wrist.rig
    rows = round(SECONDS / (EVERY * rig.sample_time))
    kept = np.concatenate([np.arange(min(DENSE, rows)), np.arange(DENSE, rows, SPARSE)])
    angle = {}
    for late in dict.fromkeys((0.0, rig.uncertainty.dead_time[1])):
        delay = late or None
        lanes = step_from(
            burdened(wrist, delay, None), at_rest(wrist, "virgin", 0.0, delay), rig.task.step, SECONDS
        )
        played = play(lanes, many, signals=("plant.angle",), every=EVERY)
        angle[late] = played.rows[0][kept].T
    return CellSteps(EVERY * rig.sample_time * kept, angle, rig.task.step)


def map_steps(tuning: Tuning) -> CellSteps:
    """The steps of the map of a tuning, under controllers of its structure with its settings."""
    problem, at = tuning.problem, tuning.map
    return cell_steps(problem.wrist, law_of(tuning.at)(problem, at.Kp, at.Ki))
