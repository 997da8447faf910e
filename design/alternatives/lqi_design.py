"""A robust LQI tuned under the limits of the PI: guaranteed-cost feedback, an observer, a small search.

For each choice of weights the feedback comes from the semidefinite program (`alternatives.lqi_synthesis`), is
completed by an observer of some bandwidth, and is judged as a PI is in `design.synthesis.requirements`:
simulated
on the same scenarios, with the margins at the command on every branch and rate.  The least worst cost
that meets every limit is kept; where none holds them all, the nearest.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from design.alternatives.convex_concave import NOISE_GAIN
from design.alternatives.lqi_synthesis import Feedback, LQIWeights, synthesise
from design.controllers.controller import stacked
from design.controllers.lqi import LQI
from design.input_loop import InputLoop, worst_pole
from design.synthesis.convex import Unsolved
from design.synthesis.evaluate import judged
from design.synthesis.requirements import Problem, excesses
from plants.wrist import Wrist

Array = NDArray[np.float64]

FAMILY = {
    "damping": (0.3, 3.0, 10.0),
    "lack": (1e-3, 4e-3, 1.6e-2),
    "effort": (2e-5, 1e-4, 5e-4),
    "bandwidth": (15.0, 30.0, 60.0),
}
"""Weights, and bandwidths [rad/s] of the observer, that are tried first."""

WASHOUT = 0.3
"""Rate [rad/s] at which the controller unlearns what the regulator's gain is off by.  Assumed."""

ROUNDS, DRAWS = 3, 60
"""Rounds of refinement around the best, and how many weights are drawn in each."""

PENALTY = 20.0
"""Price of an excess over a limit while none holds, a share of the cost per share of the limit."""


@dataclass(frozen=True)
class Choice:
    """A place in the family: weights and bandwidth [rad/s], and the controller that they make."""

    weights: LQIWeights
    bandwidth: float
    feedback: Feedback
    controller: LQI


@dataclass(frozen=True)
class JudgedLQI:
    """What controllers do on the scenarios of a problem: worst cost (n,), worst value of each limited
    quantity and of the noise gain [V/deg], and by what share of its limit each is exceeded."""

    cost: Array
    values: dict[str, Array]
    excess: dict[str, Array]

    @property
    def worst_excess(self) -> Array:
        """Largest excess over all limits, (n,)."""
        worst: Array = np.max(list(self.excess.values()), axis=0)
        return worst

    @property
    def merit(self) -> Array:
        """Cost, with excess over the limits at a price, (n,)."""
        excess = np.nan_to_num(np.maximum(self.worst_excess, 0.0), posinf=1e3)
        return np.nan_to_num(self.cost, posinf=1e3) * (1.0 + PENALTY * excess)


@dataclass(frozen=True)
class RobustLQI:
    """The design: where in the family, what it does (arrays of length 1), the largest magnitude of a pole
    with the observer over all branches and rates and where (None for a wrist with effects, whose stability
    is Nyquist's criterion), and how many were tried."""

    problem: Problem
    choice: Choice
    at: JudgedLQI
    pole: tuple[float, str] | None
    tried: int

    @property
    def controller(self) -> LQI:
        """The controller."""
        return self.choice.controller

    @property
    def breaks(self) -> tuple[str, ...]:
        """Names of the limits that are broken all the same."""
        return tuple(n for n, e in self.at.excess.items() if e[0] > 0.0)


def complete(wrist: Wrist, weights: LQIWeights, bandwidth: float, feedback: Feedback) -> LQI:
    """A feedback as a controller: with an observer that takes every branch for the mean of the lines."""
    p, k = wrist.hysteresis, feedback.gains
    return LQI(
        float(k[0]), float(k[1]), float(k[2]), feedback.jump, 0.5 * float(sum(p.steepness)), float(wrist.Tw),
        bandwidth, WASHOUT, float(wrist.regulator.gain), *wrist.rig.command_range,
    )  # fmt: skip


def judge(problem: Problem, controllers: Sequence[LQI], noise_limit: float | None = NOISE_GAIN) -> JudgedLQI:
    """Cost and limits of controllers on every scenario and branch of a problem, and their noise gain."""
    cost, of_run = judged(problem, stacked(controllers), len(controllers))
    broken = [InputLoop.at_command(problem.wrist, c, problem.branches) for c in controllers]
    linear = [x.margins(problem.branches) for x in broken]
    values = {name: v.max(axis=1) for name, v in of_run.items()}
    values |= {
        "Ms": np.array([float(x.Ms) for x in linear]),
        "Mt": np.array([float(x.Mt) for x in linear]),
        "delay_margin_s": np.array([float(x.delay_margin_s) for x in linear]),
        "noise_gain": np.array([x.noise_gain for x in broken]),
    }
    limits = problem.limits.named | ({} if noise_limit is None else {"noise_gain": noise_limit})
    return JudgedLQI(cost.max(axis=1), values, excesses(values, limits))


def design_lqi(problem: Problem, seed: int = 0) -> RobustLQI:
    """The member of the family with the least worst cost under the limits, else the nearest to them.

    The grid of `FAMILY` first, then draws around the best, ever nearer to it.  Raises
    design.synthesis.convex.Unsolved where no member of the family has a feedback.
    """
    grid = [
        (LQIWeights(*w), FAMILY["bandwidth"])
        for w in product(FAMILY["damping"], FAMILY["lack"], FAMILY["effort"])
    ]
    chosen, at, tried = _best(problem, grid, None)
    draw = np.random.default_rng(seed)
    for number in range(ROUNDS):
        spread = 0.8 * 0.5**number
        around = []
        for _ in range(DRAWS):
            w = chosen.weights
            factors, wider = np.exp(spread * draw.standard_normal((2, 3))).tolist()
            near = (x * f for x, f in zip((w.damping, w.lack, w.effort), factors, strict=True))
            around.append((LQIWeights(*near), tuple(chosen.bandwidth * f for f in wider)))
        chosen, at, more = _best(problem, around, (chosen, at))
        tried += more
    pole = None if problem.wrist.effects else worst_pole(problem.wrist, chosen.controller)
    return RobustLQI(problem, chosen, at, pole, tried)


def _best(
    problem: Problem,
    places: Sequence[tuple[LQIWeights, tuple[float, ...]]],
    known: tuple[Choice, JudgedLQI] | None,
) -> tuple[Choice, JudgedLQI, int]:
    """The best of places in the family, and of one that is known; how many were judged."""
    choices, why = [], ""
    for weights, bandwidths in places:
        try:
            feedback = synthesise(problem.wrist, weights)
        except Unsolved as error:
            why = str(error)
            continue
        if feedback.holds:
            for b in bandwidths:
                choices.append(Choice(weights, b, feedback, complete(problem.wrist, weights, b, feedback)))
    if not choices:
        if known is None:
            raise Unsolved(f"no state feedback for this plant: {why or 'none was confirmed'}")
        return *known, 0
    at = judge(problem, [c.controller for c in choices])
    best = int(np.argmin(at.merit))
    one = slice(best, best + 1)
    only = JudgedLQI(
        at.cost[one], {n: v[one] for n, v in at.values.items()}, {n: v[one] for n, v in at.excess.items()}
    )
    if known is not None and known[1].merit[0] <= only.merit[0]:
        return *known, len(choices)
    return choices[best], only, len(choices)
