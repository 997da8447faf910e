"""Estimating what the recordings determine, and leaving alone what they do not."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.begin import Begin, same_places
from plants.measured.fitting.estimate import Estimate, estimate
from plants.measured.fitting.problem import FitProblem
from plants.parameters.quantities import ParameterSet

Array = NDArray[np.float64]
TOO_WIDE = 0.5
"""A standard error beyond this share of the width of its bounds says nothing about a parameter."""

CLEARLY, SLIGHTLY = 0.9, 0.99
"""Shares of what is left below which another start is clearly better, and better at all."""


def estimate_determined(
    problem: FitProblem, start: ParameterSet, starts: int, seed: int
) -> tuple[FitProblem, Estimate, list[str]]:
    """The estimate of those parameters that the recordings determine, and the names of the others.

    One undetermined parameter after the other is put back to its starting value
    and the rest estimated again, since of two that cannot be told apart only one
    has to stay behind.
    """
    blind: list[str] = []
    found = estimate(problem, problem.bounds(start), starts, seed)
    problem, found = _with_memory(problem, found, start, seed)
    while worst := _least_determined(problem, found, start):
        blind.append(worst)
        kept = tuple(n for n in problem.names if n != worst)
        values = {**problem.values, **{n: float(found.x[i]) for i, n in enumerate(problem.names)}}
        values[worst] = start.values[worst]
        problem = begun_at(replace(problem, names=kept, values=values), problem.begins_at(found.x))
        if problem.bounds(start).size == 0:
            return problem, replace(found, x=np.empty(0), std_errors=[], correlation=np.empty((0, 0))), blind
        found = estimate(problem, problem.bounds(start), 1, seed)
    return problem, found, blind


def begun_at(problem: FitProblem, begins: tuple[Begin, ...] | None) -> FitProblem:
    """The same problem, its recordings starting elsewhere."""
    return replace(problem, stage=replace(problem.stage, begins=begins))


def _least_determined(problem: FitProblem, found: Estimate, start: ParameterSet) -> str | None:
    """The parameter of which the data says least, or None where it says something of each."""
    shares = {}
    for name, error in zip(problem.names, found.std_errors, strict=False):
        p = start.parameters[name]
        shares[name] = np.inf if error is None else error / (p.high - p.low)
    worst = max(shares, key=lambda n: shares[n], default=None)
    return worst if worst is not None and shares[worst] > TOO_WIDE else None


def remembered(problem: FitProblem, x: Array) -> tuple[Begin, ...]:
    """Where recordings start at a vector (n,), on the virgin curve or off it, as fits better; of a problem
    whose recordings do not start at rest.  What starts on the virgin curve stays there unless it fits clearly
    better off it (`CLEARLY`): where the loop is flat its memory hangs on hundredths of an angle.

    Those that start at the same place rested alike: they are asked together.
    """
    begins = problem.begins_at(x) or ()
    sizes = {
        virgin: _sizes(begun_at(problem, tuple(replace(b, virgin=virgin) for b in begins)), x)
        for virgin in (False, True)
    }
    better = list(begins)
    for group in same_places(begins, problem.stage.rig):
        now = 2 * sum(begins[i].virgin for i in group) >= len(group)
        size, flipped = (sum(sizes[v][i] for i in group) for v in (now, not now))
        for i in group:
            stays = flipped >= (CLEARLY if now else SLIGHTLY) * size
            better[i] = replace(begins[i], virgin=now if stays else not now)
    return tuple(better)


def _sizes(problem: FitProblem, x: Array) -> list[float]:
    """Sum of the residuals of each recording at a vector (n,)."""
    edges = problem.stage.edges
    whole = replace(problem, rows=None).residuals(x[None, :])[:, 0]
    return [float(np.abs(whole[a:b]).sum()) for a, b in pairwise(edges)]


def _with_memory(
    problem: FitProblem, found: Estimate, start: ParameterSet, seed: int
) -> tuple[FitProblem, Estimate]:
    """The same, each recording of unknown start on the virgin curve or off it, as fits better."""
    begins = problem.begins_at(found.x)
    if begins is None or problem.stage.channel != "angle_deg":
        return problem, found
    better = remembered(problem, found.x)
    if better == begins:
        return problem, found
    values = {**problem.values, **{n: float(found.x[i]) for i, n in enumerate(problem.names)}}
    problem = begun_at(replace(problem, values=values), better)
    return problem, estimate(problem, problem.bounds(start), 1, seed)
