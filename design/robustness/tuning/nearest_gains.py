"""The nearest gains where none hold a grown set: those with the fewest runs that never settle.

A search passes over gains that break a limit of the linear loop without a run, since no run could make them
hold.  Where nothing holds, such a search may end with gains so low that not even the plant as fitted settles,
for the sake of an Ms on one corner of a wide box, beside gains with which every run does.
"""

from dataclasses import replace

import numpy as np

from design.robustness.tuning.gain_search import DIGITS, evaluate_law, law_of, shortened
from design.synthesis.evaluate import Evaluation, best_of, join
from design.synthesis.tuning import Tuning

POINTS, FINER = 12, 7
"""Points of the map of the region in each gain, and of the finer one around its best cell."""

BEYOND = (1.0, 1e3)
"""Shares of their limits by which Ms, Mt and WT may miss them, with all of the delay margin, and gains still
be the nearest: up to twice the limit, a quarter away from -1 for a half; where some run never settles with
any such gains, every loop that is stable on all branches."""


def nearest(found: Tuning) -> Tuning:
    """The tuning with the gains of a map of its region of which fewer runs of its set never settle, if there
    are any, those that miss a limit of the linear loop by up to `BEYOND` among them, as little as will do.
    They are numbers of three digits, as they are printed."""
    problem, law = replace(found.problem, screened=False), law_of(found.at)
    best = evaluate_law(problem, law, found.at.Kp, found.at.Ki)
    if not best.unsettled[0] and all(float(f"{g:.{DIGITS}g}") == g for g in (found.Kp, found.Ki)):
        return found
    region = replace(found.region, points=min(found.region.points, POINTS))
    for beyond in BEYOND:
        if not best.unsettled[0]:
            break
        rows, columns = region.grid
        for _ in range(2):
            Kp, Ki = (g.ravel() for g in np.meshgrid(rows, columns, indexing="ij"))
            best = best_of(join([best, _within(evaluate_law(problem, law, Kp, Ki), beyond)]))
            rows, columns = (
                np.clip(gain[0] * ratio ** np.linspace(-1.0, 1.0, FINER), *ends)
                for gain, ratio, ends in zip(
                    (best.Kp, best.Ki), region.resolution, (region.Kp, region.Ki), strict=True
                )
            )
    short = shortened(problem, region, best)
    at = short if short.unsettled[0] <= best.unsettled[0] else best
    return replace(found, at=at, map=at)


def _within(at: Evaluation, beyond: float) -> Evaluation:
    """The evaluation with those that miss the delay margin, or Ms, Mt or WT by more than a share `beyond` of
    the limit, counted as not simulated."""
    shares = {"Ms": beyond, "Mt": beyond, "delay_margin_s": 0.0, "WT": beyond}
    missed = [at.excess[n] > share for n, share in shares.items() if n in at.excess]
    return replace(at, cost=np.where(np.any(missed, axis=0), np.inf, at.cost)) if missed else at
