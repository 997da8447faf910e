"""The gains of least cost on a set of cases: fine maps around known gains, along weights and filters.

Gains are what is printed: numbers of three digits, so that what is judged is what is read.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from design.controllers.pi_two_dof import TwoDofPI
from design.synthesis.requirements import (
    COSTS,
    Evaluation,
    Problem,
    adverse_values,
    evaluate,
    evaluate_with,
    excesses,
)
from design.synthesis.tuning import LocalSearch, Region, Tuning, _begins, _best, join, merit

Array = NDArray[np.float64]

DIGITS = 3
"""Significant digits of gains: those that are printed, so that what is judged is what is read."""

TELLING, TOGETHER = 8, 8
"""Cases that tell the most of gains, and gains that are played on all cases together."""

COARSE = (8, 20)
"""Points, in each gain, of the map that a search begins with: as many as the region's own within these."""

WEIGHTS = tuple(float(np.round(0.5 + 0.1 * k, 10)) for k in range(21))
"""Reference weights that are tried, 0.5 to 2.5: to a tenth, since the cost is flat along it."""

FILTERS = (0.01, 0.02, 0.005)
"""Time constants [s] of the filter that are tried, as long as the first of them lowers the cost."""

FILTER_PAYS = 0.02
"""Share of the cost that a filter has to take away: it costs phase and a number more on the target, and no
certificate knows it."""

Law = Callable[[Problem, Array, Array], PI]
"""Controllers of gains (n,)."""


def plain(problem: Problem, Kp: Array, Ki: Array) -> PI:
    """The paper's PI."""
    return PI.of(problem.wrist, Kp, Ki)


def weighted(b: float, Tf: float) -> Law:
    """PIs with a reference weight b [1] and a filter Tf [s]."""

    def law(problem: Problem, Kp: Array, Ki: Array) -> PI:
        n = np.ones(np.shape(Kp))
        return TwoDofPI.of(problem.wrist, Kp, Ki, b * n, Tf * n)

    return law


def solved(problem: Problem, region: Region, known: Evaluation | None, two_dof: bool) -> Evaluation:
    """The gains of least cost on a set, as they are printed, from those of the set before on; from a map
    where these lead to none."""
    if known is not None:
        found = _near(problem, region, known, 1.15, two_dof)
        if found.feasible[0]:
            return printed(problem, region, found)
    coarse = replace(region, points=max(min(region.points, COARSE[1]), COARSE[0]))
    rows, columns = (g.ravel() for g in np.meshgrid(*coarse.grid, indexing="ij"))
    mapped = _best(evaluate(problem, rows, columns))
    return printed(problem, region, _near(problem, region, mapped, max(coarse.resolution), two_dof))


def printed(problem: Problem, region: Region, found: Evaluation) -> Evaluation:
    """The numbers of `DIGITS` digits next to gains that meet every limit and cost least: each gain rounded
    up, down, or one step further down.  The gains as they are where none holds, or they do not."""
    if not found.feasible[0]:
        return found
    near = [
        _steps_down(float(g), bounds) for g, bounds in ((found.Kp[0], region.Kp), (found.Ki[0], region.Ki))
    ]
    Kp, Ki = (g.ravel() for g in np.meshgrid(*near, indexing="ij"))
    if not Kp.size:
        return found
    best = _best(evaluate_law(problem, law_of(found), Kp, Ki))
    return best if best.feasible[0] else found


def _steps_down(gain: float, bounds: tuple[float, float]) -> Array:
    """A gain rounded up to `DIGITS` digits and the two steps below it, within bounds.

    >>> _steps_down(18.4321, (0.3, 200.0)), _steps_down(6.47, (0.3, 40.0))
    (array([18.5, 18.4, 18.3]), array([6.47, 6.46, 6.45]))
    """
    step = 10.0 ** (np.floor(np.log10(gain)) + 1 - DIGITS)
    upper = np.ceil(gain / step - 1e-9)
    near = np.array([float(f"{(upper - k) * step:.{DIGITS}g}") for k in range(3)])
    return near[(near >= bounds[0]) & (near <= bounds[1])]


def _near(problem: Problem, region: Region, known: Evaluation, ratio: float, two_dof: bool) -> Evaluation:
    """The gains of least cost near to known ones; with two degrees of freedom any weight and filter."""
    if not two_dof:
        return zoomed(problem, region, plain, known, ratio)
    b, Tf = (1.0, 0.0) if known.b is None else (float(known.b[0]), float(known.Tf[0]))  # type: ignore[index]
    tried: dict[tuple[float, float], Evaluation] = {}

    def at(b: float, Tf: float, near: Evaluation) -> Evaluation:
        if (b, Tf) not in tried:
            tried[b, Tf] = zoomed(problem, region, weighted(b, Tf), near, max(ratio, 1.2))
        return tried[b, Tf]

    best = at(b, Tf, known)
    strides = (4, 2, 1) if known.b is None else (1,)
    for stride in strides:  # downhill along the weights, then a filter
        while True:
            place = WEIGHTS.index(b)
            near = [WEIGHTS[i] for i in (place - stride, place + stride) if 0 <= i < len(WEIGHTS)]
            better = min((at(w, Tf, best) for w in near), key=_rank)
            if _rank(better) >= _rank(best):
                break
            best, b = better, float(better.b[0])  # type: ignore[index]
    unfiltered = at(b, 0.0, best)
    best = unfiltered if Tf == 0.0 or not _filter_pays(best, unfiltered) else best
    for filtered in FILTERS if known.b is None else ():
        other = at(b, filtered, unfiltered)
        if _rank(other) >= _rank(unfiltered):
            break
        if _filter_pays(other, unfiltered) and _rank(other) < _rank(best):
            best = other
    return best


def _filter_pays(filtered: Evaluation, without: Evaluation) -> bool:
    """Whether a filter holds what nothing else does, or takes away enough of the cost."""
    if not (filtered.feasible[0] and without.feasible[0]):
        return bool(filtered.feasible[0])
    return float(filtered.cost[0]) < (1.0 - FILTER_PAYS) * float(without.cost[0])


def _rank(at: Evaluation) -> tuple[bool, float]:
    return not bool(at.feasible[0]), float(merit(at)[0])


def zoomed(
    problem: Problem, region: Region, law: Law, near: Evaluation, ratio: float, points: int = 7
) -> Evaluation:
    """The best gains near to known ones: fine maps, ever finer, each around the best of the one before, moved
    on where that lies on its edge."""
    best = evaluate_law(problem, law, near.Kp, near.Ki)
    while ratio > 1.003:
        for _ in range(6):
            shares = ratio ** np.linspace(-1.0, 1.0, points)
            Kp, Ki = np.meshgrid(best.Kp[0] * shares, best.Ki[0] * shares, indexing="ij")
            Kp, Ki = np.clip(Kp.ravel(), *region.Kp), np.clip(Ki.ravel(), *region.Ki)
            before, best = best, _better(problem, law, Kp, Ki, best)
            edges = [max(x / y, y / x) for x, y in ((best.Kp[0], before.Kp[0]), (best.Ki[0], before.Ki[0]))]
            if max(edges) < ratio * 0.999:
                break
        ratio = ratio ** (2.0 / (points - 1))
    return best


def _better(problem: Problem, law: Law, Kp: Array, Ki: Array, best: Evaluation) -> Evaluation:
    """The best of gains (n,) and of the best known.

    Where that meets every limit, most others are seen to be dearer, or to break one, on the few cases that
    are the dearest and the nearest to a limit under it; only the rest are played on all, cheapest first.
    """
    if not best.feasible[0]:
        return _best(join([best, evaluate_law(problem, law, Kp, Ki)]))
    few = _telling(problem, law, best)
    seen = evaluate_law(few, law, Kp, Ki)
    order = np.argsort(np.where(seen.feasible, seen.cost, np.inf), kind="stable")
    left = order[(seen.feasible & (seen.cost < best.cost[0]))[order]]
    for piece in np.split(left, range(TOGETHER, left.size, TOGETHER)):
        if piece.size and seen.cost[piece[0]] < best.cost[0]:
            best = _best(join([best, evaluate_law(problem, law, Kp[piece], Ki[piece])]))
    return best


def _telling(problem: Problem, law: Law, best: Evaluation) -> Problem:
    """The problem on its dearest cases and those that come nearest to a limit under the best gains."""
    if len(problem.adverse) <= 2 * TELLING:
        return problem
    values = adverse_values(problem, law(problem, best.Kp, best.Ki), 1)
    held = {n: v for n, v in problem.held_to.items() if n in values}
    excess = np.max([excesses({n: values[n][0]}, {n: v})[n] for n, v in held.items()], axis=0)
    cost = np.where([s.of_task for s in problem.adverse], values[COSTS[problem.cost]][0], 0.0)
    chosen = sorted({*np.argsort(-excess)[:TELLING].tolist(), *np.argsort(-cost)[: TELLING // 2].tolist()})
    return replace(problem, adverse=tuple(problem.adverse[i] for i in chosen))


def law_of(at: Evaluation) -> Law:
    """The law whose gains an evaluation is of."""
    return plain if at.b is None or at.Tf is None else weighted(float(at.b[0]), float(at.Tf[0]))


def evaluate_law(problem: Problem, law: Law, Kp: Array, Ki: Array) -> Evaluation:
    """Cost and limits of gains (n,) under a law."""
    return evaluate_with(problem, law(problem, Kp, Ki), Kp, Ki)


def with_evidence(found: Tuning, starts: int) -> Tuning:
    """The tuning with a map of the whole region and so many local searches from cells drawn in it, which show
    whether other valleys are as low; the gains, which pool, search and samples have judged, stay."""
    law = law_of(found.at)
    rows, columns = found.region.grid
    Kp, Ki = (g.ravel() for g in np.meshgrid(rows, columns, indexing="ij"))
    whole = evaluate_law(found.problem, law, Kp, Ki)
    searches = []
    for begin in _begins(whole, rows, columns, starts, 0):
        near = evaluate_law(found.problem, law, *(np.array([g]) for g in begin))
        end = zoomed(found.problem, found.region, law, near, max(found.region.resolution), 5)
        gains = (float(end.Kp[0]), float(end.Ki[0]))
        searches.append(LocalSearch(begin, gains, float(end.cost[0]), bool(end.feasible[0]), 0))
    return replace(found, map=whole, searches=tuple(searches))
