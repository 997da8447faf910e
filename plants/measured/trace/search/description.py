"""A term learnt from a residual that no effect explains: a description, not a cause.

Smooth curves of the variables that the residual was found to depend on, fitted
by cross-validated ridge regression (scikit-learn), variable by variable, and
judged on held-out blocks of time.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plants.measured.residual.series.remainder import Remainder

Array = NDArray[np.float64]
KNOTS = 8
BLOCK = 10.0
"""Length [s] of the blocks that are left out in turn."""

MOST = 3
"""Variables that a description may use; more would describe this data and no other."""

EARNED = 0.02
"""Least further share of the residual, on blocks left out, that a variable must describe."""


@dataclass(frozen=True)
class LearntCurve:
    """What one variable adds: its values (k,) and the term [unit of the channel] at them (k,)."""

    variable: str
    at: Array
    term: Array


@dataclass(frozen=True)
class Description:
    """A description of a residual.

    variables: what it is made of, in order of gain.  described: share of the
    residual's mean square beyond noise that it takes away on blocks left out,
    0 to 1.  curves: the term of each variable.
    """

    variables: tuple[str, ...]
    described: float
    curves: tuple[LearntCurve, ...]

    def __str__(self) -> str:
        made = ", ".join(self.variables) or "no variable tried"
        return (
            f"A description, not a cause: smooth curves of {made} "
            f"take away {100 * self.described:.0f} % of what is left beyond noise, on blocks left out."
        )


def smooth_curves(remainders: Sequence[Remainder], variables: Sequence[str]) -> Description | None:
    """Describe residuals by curves of some of `variables`, chosen one after the other.

    None where none of them earns its place.
    """
    value = np.concatenate([r.value for r in remainders])
    blocks = np.concatenate(
        [1e6 * i + np.floor((r.time - r.time[0]) / BLOCK) for i, r in enumerate(remainders)]
    )
    groups = np.unique(blocks, return_inverse=True)[1]
    beyond = float(np.mean(value**2) - np.mean([r.noise**2 for r in remainders]))
    usable = [v for v in variables if all(v in r.variables for r in remainders)]
    columns = {v: np.concatenate([r.variables[v] for r in remainders]) for v in usable}
    columns = {v: c for v, c in columns.items() if np.ptp(c) > 0.0}
    if beyond <= 0.0 or not columns or groups.max() < 3:
        return None
    thin = slice(None, None, 5)
    chosen: list[str] = []
    described = 0.0
    while len(chosen) < MOST:
        gains = {
            v: _described(
                np.column_stack([columns[n][thin] for n in (*chosen, v)]), value[thin], groups[thin], beyond
            )
            for v in columns
            if v not in chosen
        }
        best = max(gains, key=lambda v: gains[v], default=None)
        if best is None or gains[best] < described + EARNED:
            break
        chosen.append(best)
        described = gains[best]
    if not chosen:
        return None
    made = np.column_stack([columns[n][thin] for n in chosen])
    return Description(tuple(chosen), min(described, 1.0), _curves(chosen, made, value[thin]))


def _model() -> object:
    from sklearn.linear_model import RidgeCV
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import SplineTransformer, StandardScaler

    splines = SplineTransformer(n_knots=KNOTS, degree=3, knots="quantile", include_bias=False)
    return make_pipeline(splines, StandardScaler(), RidgeCV(alphas=np.logspace(-2, 4, 7)))


def _described(made: Array, value: Array, groups: NDArray[np.intp], beyond: float) -> float:
    """Share of what is beyond noise that curves of the columns describe, on groups left out."""
    from sklearn.model_selection import GroupKFold, cross_val_predict

    folds = GroupKFold(min(5, int(groups.max()) + 1))
    predicted = cross_val_predict(_model(), made, value, groups=groups, cv=folds)
    return float((np.mean(value**2) - np.mean((value - predicted) ** 2)) / beyond)


def _curves(names: Sequence[str], made: Array, value: Array) -> tuple[LearntCurve, ...]:
    """The term of each variable over its range, the others at their medians."""
    model = _model()
    model.fit(made, value)  # type: ignore[attr-defined]
    found = []
    for i, name in enumerate(names):
        low, high = map(float, np.quantile(made[:, i], (0.01, 0.99)))
        at = np.linspace(low, high, 60)
        points = np.tile(np.median(made, axis=0), (at.size, 1))
        points[:, i] = at
        term = model.predict(points)  # type: ignore[attr-defined]
        found.append(LearntCurve(name, at, term - term.mean()))
    return tuple(found)
