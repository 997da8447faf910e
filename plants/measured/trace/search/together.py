"""Where a model with one more effect is fitted from.

A joint that sticks breaks away or does not, so that chi-square has many minima, and a loop fitted without the
effect is the wrong one to start from: such an effect is fitted together with the loop from each of its
trial values, and what is best is moved about, in lanes side by side, while that helps.
"""

from collections.abc import Mapping

import numpy as np

from plants.measured.trace.search.proposals import trials
from plants.measured.trace.search.screening import Ranked, around
from plants.measured.trace.stages.model import Model

MOVES, SHORTER = 12, 0.7
"""How often the best is moved about at most, and how much less far each time."""

GAIN = 0.995
"""Share that chi-square has to fall below for it to be moved about again."""


def fitted_with(model: Model, ranked: Ranked) -> Model:
    """The model with a ranked effect, fitted roughly."""
    if not ranked.form.RUGGED:
        return model.plus(ranked.form, ranked.values).fitted(8, 1e-3)
    starts: list[Mapping[str, float]] = [ranked.values, *trials(ranked.form, model)]
    best = min((model.plus(ranked.form, v).fitted(5, 1e-2) for v in starts), key=lambda m: m.chi2)
    scale, idle = 0.5, 0
    for _ in range(MOVES):
        moved = _moved(best, ranked, scale).fitted(5, 1e-3)
        idle = 0 if moved.chi2 < GAIN * best.chi2 else idle + 1
        best = moved if moved.chi2 < best.chi2 else best
        scale *= SHORTER
        if idle > 1:
            break
    return best


def _moved(model: Model, ranked: Ranked, scale: float) -> Model:
    """The model with the best of some values of its effect around the present ones, as far as a refit of all
    other parameters, which is linear, lets see (variable projection: Golub & Pereyra, Inverse Problems 19
    (2003) R1)."""
    prefix, stage = f"{ranked.name}.", model.stage
    now = {n: model.values[prefix + n] for n in ranked.form.kinds()}
    grid = [now, *around(ranked.form, now, scale, stage.rig)]
    lanes = {prefix + n: np.array([g[n] for g in grid]) for n in now}
    left = (stage.simulate({**model.values, **lanes}, model.forms) - stage.target[:, None]) / stage.noise
    slopes = model.linear[1][:, [not n.startswith(prefix) for n in model.names]]
    basis, _ = np.linalg.qr(slopes)
    squares = np.mean((left - basis @ (basis.T @ left)) ** 2, axis=0)
    return model.with_values({prefix + n: v for n, v in grid[int(np.argmin(squares))].items()})
