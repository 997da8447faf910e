"""PI + feedforward tuned under the limits of the PI: speed of the filter and two gains, by a coarse search.

The PI of a feedforward has only to take out what the model lacks, so that other gains than the tuned PI's may
serve.  Its margins are those of a PI alone, since the feedforward stands outside the loop: gains that
break them are left out before anything is simulated.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import stacked
from design.controllers.feedforward import FeedforwardPI
from design.margins import margins
from design.synthesis.evaluate import Evaluation, controller, evaluate_with, join
from design.synthesis.judged import merit
from design.synthesis.requirements import Problem, excesses

Array = NDArray[np.float64]

SPEEDS = (5.0, 7.0, 10.0, 15.0, 25.0)
"""Rates of the filter [1/s] that are tried first."""

GAINS = (np.geomspace(1.0, 25.0, 6), np.geomspace(2.0, 80.0, 6))
"""Kp [kPa/deg] and Ki [kPa/(deg s)] that are tried first."""

ROUNDS, DRAWS = 5, 32
"""Rounds of refinement around the best, and how many are drawn in each."""


@dataclass(frozen=True)
class FeedforwardDesign:
    """What was found: the controller, what it does on the problem's scenarios (arrays of length 1), and how
    many were simulated."""

    problem: Problem
    controller: FeedforwardPI
    at: Evaluation
    tried: int

    @property
    def breaks(self) -> tuple[str, ...]:
        """Names of the limits that are broken all the same."""
        return tuple(n for n, e in self.at.excess.items() if e[0] > 0.0)


def judge(problem: Problem, places: Array) -> Evaluation:
    """Cost and limits of PI + feedforward with the speed, Kp and Ki of the rows of `places`, (n, 3), whose
    model is the problem's wrist, on every scenario and branch.

    Raises InputError for a wrist that has no inverse.
    """
    many = stacked([_controller(problem, place) for place in places])
    return evaluate_with(problem, many, places[:, 1], places[:, 2])


def _controller(problem: Problem, place: Array) -> FeedforwardPI:
    speed, Kp, Ki = map(float, place)
    found: FeedforwardPI = FeedforwardPI.of(problem.wrist, speed=speed, Kp=Kp, Ki=Ki)
    return found


def design_feedforward(problem: Problem, seed: int = 0) -> FeedforwardDesign:
    """The PI + feedforward of least worst cost under the problem's limits, else the nearest to them.

    The grid of `SPEEDS` and `GAINS` first, without gains whose PI breaks Ms or the delay margin, then draws
    around the best, ever nearer to it.  Raises InputError for a wrist that has no inverse.
    """
    grid = np.array([(v, Kp, Ki) for v in SPEEDS for Kp in GAINS[0] for Ki in GAINS[1]])
    places = _robust(problem, grid)
    places = places if len(places) else grid
    at = judge(problem, places)
    draw = np.random.default_rng(seed)
    for number in range(ROUNDS):
        best = places[int(np.argmin(merit(at)))]
        near = best * np.exp(0.6 * 0.6**number * draw.standard_normal((DRAWS, 3)))
        more = _robust(problem, near)
        if len(more):
            places, at = np.vstack([places, more]), join([at, judge(problem, more)])
    rank = np.where(at.feasible, at.cost, np.inf) if at.feasible.any() else at.worst_excess
    best_at = int(np.argmin(rank))
    return FeedforwardDesign(problem, _controller(problem, places[best_at]), at.only(best_at), len(places))


def _robust(problem: Problem, places: Array) -> Array:
    """Those places whose PI holds the limits of the linear loop that are in force."""
    linear = margins(list(problem.branches), controller(problem, places[:, 1], places[:, 2])).values
    limits = {n: v for n, v in problem.limits.named.items() if n in linear}
    beyond = excesses(linear, limits).values()
    kept: Array = places[np.all([e <= 0.0 for e in beyond], axis=0)] if limits else places
    return kept
