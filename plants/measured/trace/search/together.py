"""Where a model with one more effect is fitted from.

A joint that sticks breaks away or does not, so that chi-square has many minima, and a loop fitted without the
effect is the wrong one to start from: such an effect is fitted together with the loop from the best few of
its trial values, and what is best is moved about, in lanes side by side, while that helps.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from plants.measured.trace.ranking.proposals import trials
from plants.measured.trace.ranking.screening import Ranked, around
from plants.measured.trace.stages.model import Model

Array = NDArray[np.float64]

EVALUATIONS = 24
"""Evaluations of a rough fit; it ends where chi-square changes by a thousandth.  A rig that is far from its
declared model needs most of them before candidates can be compared."""

LITTLE = 0.1
"""Share of the way from where an effect vanishes to its trial values that is next to none of it."""

STARTS, BRIEF = 4, 4
"""Trials that it is fitted from: those that leave least where all other parameters follow linearly, each with
another value of the first parameter, which is the effect's size; evaluations of each, where it has more
parameters than its size."""

MOVES, SHORTER = 6, 0.6
"""How often the best is moved about at most, and how much less far each time."""

GAIN = 0.995
"""Share that chi-square has to fall below for it to be moved about again."""


def fitted_with(model: Model, ranked: Ranked) -> Model:
    """The model with a ranked effect, fitted roughly.

    With one effect more it cannot fit worse.  Where it does, the other parameters, which fit without the
    effect, were too far from those that fit with it: then it is fitted from next to none of the effect.
    """
    if not ranked.form.RUGGED:
        found = model.plus(ranked.form, ranked.values).fitted(EVALUATIONS, 1e-3)
        if found.chi2 < model.chi2:
            return found
        none = ranked.form()
        little = {n: (1.0 - LITTLE) * getattr(none, n) + LITTLE * v for n, v in ranked.values.items()}
        again = model.plus(ranked.form, little).fitted(EVALUATIONS, 1e-3)
        return min(found, again, key=lambda m: m.chi2)
    grid = trials(ranked.form, model)
    left = _left(model, model.plus(ranked.form, ranked.values), ranked, grid)
    size = next(iter(grid[0]))
    best_of_size: dict[float, Mapping[str, float]] = {}
    for i in np.argsort(left):
        best_of_size.setdefault(grid[i][size], grid[i])
    starts = [ranked.values, *list(best_of_size.values())[:STARTS]]
    # Of a size alone whole fits are quick, and tell a valley that is narrow from one that is deep.
    first = (EVALUATIONS, 1e-3) if len(ranked.form.kinds()) == 1 else (BRIEF, 1e-2)
    best = min((model.plus(ranked.form, v).fitted(*first) for v in starts), key=lambda m: m.chi2)
    scale = 0.5
    for _ in range(MOVES):
        now = {n: best.values[f"{ranked.name}.{n}"] for n in ranked.form.kinds()}
        near = [now, *around(ranked.form, now, scale, model.stage.rig)]
        there = near[int(np.argmin(_left(best, best, ranked, near)))]
        moved = best.with_values({f"{ranked.name}.{n}": v for n, v in there.items()}).fitted(5, 1e-3)
        gains = moved.chi2 < GAIN * best.chi2
        best = moved if moved.chi2 < best.chi2 else best
        if not gains and scale < 0.4:
            break
        scale *= SHORTER
    return best


def _left(at: Model, model: Model, ranked: Ranked, grid: Sequence[Mapping[str, float]]) -> Array:
    """Mean square over the noise that a model with an effect at each point of a grid leaves, (points,), where
    all other parameters follow as the slopes of the model `at` say (variable projection: Golub & Pereyra,
    Inverse Problems 19 (2003) R1)."""
    prefix, stage = f"{ranked.name}.", model.stage
    lanes = {prefix + n: np.array([g[n] for g in grid]) for n in grid[0]}
    left = (stage.simulate({**model.values, **lanes}, model.forms) - stage.target[:, None]) / stage.noise
    slopes = at.linear[1][:, [not n.startswith(prefix) for n in at.names]]
    basis, _ = np.linalg.qr(slopes)
    found: Array = np.mean((left - basis @ (basis.T @ left)) ** 2, axis=0)
    return found
