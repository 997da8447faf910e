"""The gains of least cost on a set of cases: fine maps around known gains, along weights and filters.

Gains are what is printed: numbers of three digits, so that what is judged is what is read.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Controller
from design.synthesis.evaluate import Evaluation, adverse_values, best_of, evaluate, evaluate_with, join
from design.synthesis.judged import merit
from design.synthesis.requirements import COSTS, Problem, excesses
from design.synthesis.structure import CASCADE_PI, FORWARD_PI, PLAIN_PI, TWO_DOF_PI, Structure
from design.synthesis.tuning import LocalSearch, Region, Tuning, _begins

Array = NDArray[np.float64]

DIGITS = 3
"""Significant digits of gains: those that are printed, so that what is judged is what is read."""

TELLING, TOGETHER = 8, 8
"""Cases that tell the most of gains, and gains that are played on all cases together."""

COARSE = (8, 20)
"""Points, in each gain, of the map that a search begins with: as many as the region's own within these."""

FILTER_PAYS = 0.02
"""Share of the cost that a filter has to take away: it costs phase and a number more on the target, and no
certificate knows it."""

Law = Callable[[Problem, Array, Array], Controller]
"""Controllers of gains (n,)."""


def law_with(structure: Structure, settings: Mapping[str, float]) -> Law:
    """Controllers of a structure with some settings."""

    def law(problem: Problem, Kp: Array, Ki: Array) -> Controller:
        n = np.ones(np.shape(Kp))
        made: Controller = structure.of(problem.wrist, Kp, Ki, **{k: v * n for k, v in settings.items()})
        return made

    return law


def solved(problem: Problem, region: Region, known: Evaluation | None, structure: Structure) -> Evaluation:
    """The gains of least cost on a set, as they are printed, from those of the set before on; from a map
    where these lead to none."""
    if known is not None:
        found = _near(problem, region, known, 1.15, structure)
        if structure.loop_kept:
            return found
        if found.feasible[0]:
            return printed(problem, region, found)
    coarse = replace(region, points=max(min(region.points, COARSE[1]), COARSE[0]))
    rows, columns = (g.ravel() for g in np.meshgrid(*coarse.grid, indexing="ij"))
    mapped = best_of(evaluate(problem, rows, columns))
    return printed(problem, region, _near(problem, region, mapped, max(coarse.resolution), structure))


def printed(problem: Problem, region: Region, found: Evaluation) -> Evaluation:
    """The numbers of `DIGITS` digits next to gains that meet every limit and cost least.  The gains as they
    are where none holds, or they do not."""
    best = shortened(problem, region, found) if found.feasible[0] else found
    return best if best.feasible[0] else found


def shortened(problem: Problem, region: Region, found: Evaluation) -> Evaluation:
    """The best gains of `DIGITS` digits next to others: each rounded up, down, or one step further down;
    these themselves where the region holds none."""
    near = [
        _steps_down(float(g), bounds) for g, bounds in ((found.Kp[0], region.Kp), (found.Ki[0], region.Ki))
    ]
    Kp, Ki = (g.ravel() for g in np.meshgrid(*near, indexing="ij"))
    return best_of(evaluate_law(problem, law_of(found), Kp, Ki)) if Kp.size else found


def _steps_down(gain: float, bounds: tuple[float, float]) -> Array:
    """A gain rounded up to `DIGITS` digits and the two steps below it, within bounds.

    >>> _steps_down(18.4321, (0.3, 200.0)), _steps_down(6.47, (0.3, 40.0))
    (array([18.5, 18.4, 18.3]), array([6.47, 6.46, 6.45]))
    """
    step = 10.0 ** (np.floor(np.log10(gain)) + 1 - DIGITS)
    upper = np.ceil(gain / step - 1e-9)
    near = np.array([float(f"{(upper - k) * step:.{DIGITS}g}") for k in range(3)])
    return near[(near >= bounds[0]) & (near <= bounds[1])]


def _near(
    problem: Problem, region: Region, known: Evaluation, ratio: float, structure: Structure
) -> Evaluation:
    """The gains of least cost near to known ones, with any settings that the structure tries."""
    if not structure.ladders:
        return zoomed(problem, region, law_with(structure, structure.settings), known, ratio)
    again = known.settings.keys() == structure.settings.keys()
    begin = {n: float(v[0]) for n, v in known.settings.items()} if again else dict(structure.settings)
    tried: dict[tuple[float, ...], Evaluation] = {}

    def at(settings: Mapping[str, float], near: Evaluation) -> Evaluation:
        key = tuple(settings.values())
        if key not in tried:
            law = law_with(structure, settings)
            tried[key] = (
                evaluate_law(problem, law, near.Kp, near.Ki)
                if structure.loop_kept
                else zoomed(problem, region, law, near, max(ratio, 1.2))
            )
        return tried[key]

    best = at(begin, known)
    strides = (1,) if again else structure.strides
    # Downhill along each ladder, then a filter.
    for (name, values), stride in product(structure.ladders.items(), strides):
        while True:
            place = values.index(begin[name])
            near = [
                {**begin, name: values[i]} for i in (place - stride, place + stride) if 0 <= i < len(values)
            ]
            better = min((at(s, best) for s in near), key=_rank)
            if _rank(better) >= _rank(best):
                break
            best, begin = better, {**begin, name: float(better.settings[name][0])}
    if structure.filters:
        unfiltered = at({**begin, "Tf": 0.0}, best)
        best = unfiltered if begin["Tf"] == 0.0 or not _filter_pays(best, unfiltered) else best
        for filtered in () if again else structure.filters:
            other = at({**begin, "Tf": filtered}, unfiltered)
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
        return best_of(join([best, evaluate_law(problem, law, Kp, Ki)]))
    few = _telling(problem, law, best)
    seen = evaluate_law(few, law, Kp, Ki)
    order = np.argsort(np.where(seen.feasible, seen.cost, np.inf), kind="stable")
    left = order[(seen.feasible & (seen.cost < best.cost[0]))[order]]
    for piece in np.split(left, range(TOGETHER, left.size, TOGETHER)):
        if piece.size and seen.cost[piece[0]] < best.cost[0]:
            best = best_of(join([best, evaluate_law(problem, law, Kp[piece], Ki[piece])]))
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
    """The law whose gains an evaluation is of.  Raises ValueError for settings that no structure has."""
    for structure in (PLAIN_PI, TWO_DOF_PI, FORWARD_PI, CASCADE_PI):
        if structure.settings.keys() == at.settings.keys():
            return law_with(structure, {n: float(v[0]) for n, v in at.settings.items()})
    raise ValueError(f"no structure has the settings {', '.join(at.settings)}")


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
