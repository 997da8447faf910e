"""A robust LQI tuned under the limits of the PI: guaranteed-cost feedback, an observer, a search.

For each choice of weights the feedback comes from the semidefinite program (`alternatives.lqi_synthesis`), is
completed by an observer of some bandwidth and a jump at steps of the reference, and is judged as a PI is in
`design.synthesis.requirements`: simulated on the same scenarios, with the margins at the command on every
branch and rate.  The least worst cost that meets every limit is kept; where none holds them all, the nearest.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from design.alternatives.convex_concave import NOISE_GAIN
from design.alternatives.lqi_synthesis import Feedback, LQIWeights, synthesise
from design.controllers.controller import stacked
from design.controllers.lqi import LQI
from design.input_loop import InputLoop, worst_pole
from design.synthesis.convex import Unsolved
from design.synthesis.evaluate import screened
from design.synthesis.judged import JudgedDesign, active_limit
from design.synthesis.requirements import Problem
from plants.wrist import Wrist

Array = NDArray[np.float64]

FAMILY = {
    "damping": (0.03, 100.0),
    "lack": (1e-4, 0.2),
    "effort": (1e-6, 1e-2),
    "bandwidth": (4.0, 120.0),
    "jump": (0.2, 1.5),
}
"""The family that is searched: weights, bandwidth of the observer [rad/s], and the jump of the command at a
step as a share of that for which the guaranteed cost is least, as the reference weight of a PI."""

GAINS = ("Ke", "Kd", "Kq", "jump", "bandwidth")
"""What the design finds of a controller; the rest of it is the wrist's."""

DIGITS = 4
"""Significant digits of gains, so that what is judged is what is printed."""

MEMBERS, GENERATIONS = 32, 16
"""Members of a generation, and how many generations there are; a third of them from a known design on."""

NEAR = 0.4
"""Standard deviation of the logarithms of the first generation around a known design."""

NOWHERE = 1e9
"""Merit of a place without a feedback."""


@dataclass(frozen=True)
class Choice:
    """A place in the family (5,), as the logarithms of what `FAMILY` names, and the controller that it
    makes."""

    place: Array
    weights: LQIWeights
    feedback: Feedback
    controller: LQI


@dataclass(frozen=True)
class RobustLQI:
    """The design: where in the family, what it does (arrays of length 1), the largest magnitude of a pole
    with the observer over all branches and rates and where (None for a wrist with effects, whose stability
    is Nyquist's criterion), and how many were tried."""

    problem: Problem
    choice: Choice
    at: JudgedDesign
    pole: tuple[float, str] | None
    tried: int

    @property
    def controller(self) -> LQI:
        """The controller."""
        return self.choice.controller

    @property
    def gains(self) -> dict[str, float]:
        """Its gains by name: Ke, Kd [kPa/(deg s)], Kq [1/s], jump [kPa/deg], bandwidth [rad/s]."""
        return {n: float(getattr(self.controller, n)) for n in GAINS}

    @property
    def breaks(self) -> tuple[str, ...]:
        """Names of the limits that are broken all the same."""
        return tuple(n for n, e in self.at.excess.items() if e[0] > 0.0)

    @property
    def feasible(self) -> bool:
        """Whether the gains meet every limit."""
        return not self.breaks

    @property
    def active(self) -> str | None:
        """The limit that the gains run into first, or None for an optimum inside all limits."""
        return active_limit(self.at)


def chosen(wrist: Wrist, place: Array) -> Choice | None:
    """The controller of a place in the family, its gains as they are printed; None where no feedback is
    confirmed there."""
    damping, lack, effort, bandwidth, jump = np.exp(place).tolist()
    weights = LQIWeights(damping, lack, effort)
    try:
        feedback = synthesise(wrist, weights)
    except Unsolved:
        return None
    if not feedback.holds:
        return None
    own = (*feedback.gains, jump * feedback.jump, bandwidth)
    gains = {n: float(f"{g:.{DIGITS}g}") for n, g in zip(GAINS, own, strict=True)}
    return Choice(place, weights, feedback, LQI.of(wrist, **gains))


def judge(
    problem: Problem, controllers: Sequence[LQI], noise_limit: float | None = NOISE_GAIN
) -> JudgedDesign:
    """Cost and limits of controllers on every scenario and branch of a problem, and their noise gain; those
    that break a limit of the linear loop are not simulated where the problem is screened."""
    broken = [InputLoop.at_command(c, problem.branches) for c in controllers]
    linear = [x.margins(problem.branches) for x in broken]
    values = {n: np.array([float(x.values[n]) for x in linear]) for n in linear[0].values}
    values["noise_gain"] = np.array([x.noise_gain for x in broken])
    limits = problem.held_to | ({} if noise_limit is None else {"noise_gain": noise_limit})
    cost, of_run, excess = screened(problem, stacked(controllers), values, limits)
    values |= {name: v.max(axis=1) for name, v in of_run.items()}
    return JudgedDesign(cost.max(axis=1), values, excess)


def design_lqi(
    problem: Problem, seed: int = 0, known: RobustLQI | None = None, generations: int = GENERATIONS
) -> RobustLQI:
    """The member of the family with the least worst cost under the limits, else the nearest to them.

    By differential evolution (scipy) over the whole family, or in a third of the generations from a design of
    an easier problem that is `known`.  Raises design.synthesis.convex.Unsolved where no member has a
    feedback.
    """
    from scipy.optimize import differential_evolution

    bounds = np.log(list(FAMILY.values()))
    begin: Array = _begin(bounds, seed, known)
    best: list[tuple[Choice, JudgedDesign]] = []
    tried = 0

    def merits(places: Array) -> Array:
        nonlocal tried
        found = [chosen(problem.wrist, place) for place in np.atleast_2d(places.T)]
        some = [c for c in found if c is not None]
        tried += len(some)
        heights = np.full(len(found), NOWHERE)
        if some:
            at = judge(problem, [c.controller for c in some])
            heights[[c is not None for c in found]] = at.merit
            least = int(np.argmin(at.merit))
            if not best or at.merit[least] < best[0][1].merit[0]:
                best[:] = [(some[least], at.only(least))]
        return heights

    most = generations if known is None else generations // 3
    differential_evolution(
        merits, bounds, init=begin, maxiter=most, rng=seed, vectorized=True, updating="deferred",
        polish=False, tol=0.0,
    )  # fmt: skip
    if not best:
        raise Unsolved("no state feedback for this plant: none was confirmed")
    choice, at = best[0]
    pole = None if problem.wrist.effects else worst_pole(problem.wrist, choice.controller)
    return RobustLQI(problem, choice, at, pole, tried)


def _begin(bounds: Array, seed: int, known: RobustLQI | None) -> Array:
    """The first generation: spread over the family, or around a known design, which is in it."""
    low, high = bounds.T
    if known is None:
        cube = qmc.Sobol(len(bounds), rng=seed).random(MEMBERS)
        return np.asarray(low + cube * (high - low))
    draw = np.random.default_rng(seed).standard_normal((MEMBERS, len(bounds)))
    draw[0] = 0.0
    return np.clip(known.choice.place + NEAR * draw, low, high)
