"""Ranking effects cheaply: how much of the residual each one's finite response would take away.

The sensitivity to an effect is zero at its null for all that has a threshold,
and time constants, moments and frequencies mean nothing there; so each form is
simulated at a small grid of values instead.  From its response, what a refit of
the present parameters could absorb is projected out, and what is left is
compared with the residual.  The largest of so many comparisons is judged
against what it would be if the residual were noise.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plants.effects import EFFECTS, in_order
from plants.measured.fitting.problem import WILD
from plants.measured.fitting.stage import Form
from plants.measured.trace.ranking.proposals import trials
from plants.measured.trace.stages.model import Model
from plants.rig import Rig, built_in_rig

Array = NDArray[np.float64]
DRAWS = 200
"""Simulated residuals of noise alone, for the calibration of the maximum."""

ROUNDS = 2
"""How often the grid is refined around its best point."""

CONTENDERS = 7
"""Effects whose grids are refined: those whose best point explains most."""

THIN = 3
"""Every so many-th row is enough to rank on."""


@dataclass(frozen=True)
class Ranked:
    """A form and the values at which it explains most.

    drop: by how much the mean square of the residual, in units of the noise,
    would fall; chance: by how much at most it falls for noise alone, in 95 % of
    draws (the whole grid tried on each).  power: largest mean square of its
    response over the grid that no refit would absorb, in units of the noise.
    """

    form: Form
    values: Mapping[str, float]
    drop: float
    chance: float
    power: float

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.form.NAME


@dataclass(frozen=True)
class Screen:
    """A model, linearised, to hold responses against."""

    model: Model
    seed: int = 0

    @cached_property
    def basis(self) -> Array:
        """Orthonormal basis of all that a refit of the present parameters could absorb, (rows, n)."""
        sensitivity = self.model.linear[1][::THIN]
        size = np.linalg.norm(sensitivity, axis=0)
        scaled = sensitivity[:, size > 0.0] / size[size > 0.0]
        u, s, _ = np.linalg.svd(scaled, full_matrices=False)
        basis: Array = u[:, s > 1e-6 * s.max(initial=1.0)]
        return basis

    @cached_property
    def remainder(self) -> Array:
        """Measured minus simulated over the noise, what could be absorbed taken out, (rows,)."""
        return self.cleared(-self.model.linear[0][::THIN, None])[:, 0]

    def cleared(self, responses: Array) -> Array:
        """Responses (rows, lanes) without what a refit could absorb."""
        found: Array = responses - self.basis @ (self.basis.T @ responses)
        return found

    @cached_property
    def plain(self) -> Array:
        """The channel of the declared wrist at the model's values, without any effect, (rows,)."""
        return self._with(())

    def _with(self, beside: tuple[Form, ...]) -> Array:
        """The same with some effects of the model, (rows,)."""
        found: Array = self.model.stage.simulate(self.model.values, beside)[::THIN, 0]
        return found

    def responses(self, form: Form, grid: Sequence[Mapping[str, float]]) -> Array:
        """Change of the channel over the noise by a form at each point of a grid, (rows, points).

        The form is tried alone: how it would act together with the effects that the model has already is of
        second order, and needs no new machine code.  Not so laws of the joint: friction does one thing to a
        mass and another to a lag.
        """
        more = {f"{form.NAME}.{n}": np.array([g[n] for g in grid]) for n in grid[0]}
        beside = tuple(f for f in self.model.forms if f.JOINT) if form.JOINT else ()
        simulated = self.model.stage.simulate({**self.model.values, **more}, in_order((*beside, form)))
        plain = self._with(beside) if beside else self.plain
        found: Array = (simulated[::THIN] - plain[:, None]) / self.model.stage.noise
        wild = ~np.isfinite(found).all(axis=0) | (np.abs(found).max(axis=0) > WILD)
        found[:, wild] = 0.0
        return found

    def drops(self, responses: Array) -> Array:
        """Fall of the mean square that each response, cleared and in the best size, would bring."""
        along = self.remainder @ responses
        power = np.sum(responses**2, axis=0)
        # An effect acts in its own direction: a response that would have to be turned round is none.
        kept = np.where((along > 0.0) & (power > 1e-6), along, 0.0)
        found: Array = kept**2 / np.maximum(power * len(responses), 1e-12)
        return found

    def tried(self, form: Form) -> tuple[Ranked, Array]:
        """The best point of a form's grid, and the responses (rows, n) by which chance was judged."""
        # How much it could show does not depend on what the residual suggests.
        plain = list(form.trials(self.model.stage.rig))
        grid = trials(form, self.model)
        more = [g for g in grid if g not in plain]
        points = plain + more
        responses = self.cleared(self.responses(form, points))
        sized = responses[:, : len(plain)] if form.FROM_REMAINDER else responses
        power = float(np.mean(sized**2, axis=0).max())
        asked = [i for i, g in enumerate(points) if g in grid]
        drops = self.drops(responses[:, asked])
        best = points[asked[int(drops.argmax())]]
        seen = _largest(responses[:, asked], drops)
        return Ranked(form, best, max(float(drops.max()), 0.0), self._chance(seen), power), seen

    def refined(self, found: Ranked, seen: Array) -> Ranked:
        """The best point that lies around one that was found."""
        for round_ in range(ROUNDS):
            grid = around(found.form, found.values, 0.5**round_, self.model.stage.rig)
            responses = self.cleared(self.responses(found.form, grid))
            drops = self.drops(responses)
            seen = np.hstack([seen, _largest(responses, drops)])
            if drops.max() > found.drop:
                found = replace(found, values=grid[int(drops.argmax())], drop=float(drops.max()))
        return replace(found, chance=self._chance(seen))

    def rank(self, form: Form) -> Ranked:
        """The best point of a form's grid, refined."""
        return self.refined(*self.tried(form))

    def _chance(self, responses: Array) -> float:
        """95 % quantile of the largest drop that noise alone would give."""
        size = np.linalg.norm(responses, axis=0)
        units = responses[:, size > 1e-6] / size[size > 1e-6]
        if not units.size:
            return 0.0
        # Projections of white noise on unit vectors: their correlations are all that matters.
        gram = units.T @ units
        w, v = np.linalg.eigh(gram)
        root = v * np.sqrt(np.maximum(w, 0.0))
        draws = np.random.default_rng(self.seed).standard_normal((DRAWS, len(w)))
        largest = np.max(np.maximum(draws @ root.T, 0.0) ** 2, axis=1)
        return float(np.quantile(largest, 0.95) / len(responses))


def _largest(responses: Array, drops: Array) -> Array:
    """The responses that bring most: they decide what chance could bring."""
    found: Array = responses[:, np.argsort(drops)[-16:]]
    return found


def around(
    form: Form, best: Mapping[str, float], scale: float, rig: Rig | None = None
) -> list[dict[str, float]]:
    """Points around the best: each parameter up and down by a factor, then some at random."""
    rig, kinds, spreads = rig or built_in_rig(), form.kinds(), form.spreads()
    rng = np.random.default_rng(7)
    points = []
    for _ in range(32):
        point = {}
        for name, value in best.items():
            kind, spread = kinds[name], spreads[name]
            push = rng.normal() * scale
            if spread is not None:
                moved = value + rig.scaled(spread, kind.unit) * push
            elif kind.low > 0.0 or value > 0.0 or value < 0.0:
                moved = value * float(np.exp(0.5 * push))
            else:
                moved = value
            point[name] = float(
                np.clip(moved, rig.scaled(kind.low, kind.unit), rig.scaled(kind.high, kind.unit))
            )
        points.append(point)
    return points


def screen(model: Model, names: Iterable[str], seed: int = 0, refine: bool = True) -> list[Ranked]:
    """All forms of the effects named, those that explain most first; with `refine` those of the best few
    effects at values that were looked for around the best of their grids."""
    held = Screen(model, seed)
    taken = any(f.JOINT for f in model.forms)  # the place of the joint
    forms = (f for n in names for f in EFFECTS[n] if not (f.MASSLESS and taken))
    tried = sorted(map(held.tried, forms), key=lambda t: -t[0].drop)
    best = list(dict.fromkeys(r.name for r, _ in tried))[: CONTENDERS if refine else 0]
    found = [held.refined(r, seen) if r.name in best else r for r, seen in tried]
    return sorted(found, key=lambda r: -r.drop)
