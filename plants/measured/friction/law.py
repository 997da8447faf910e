"""A law of friction: from displacement, speed and load to force, with memory, linear in its weights.

    force = area x load + stiffness x + viscosity v + Coulomb friction sign(v)         always
          + stops of the displacement + friction that saturates with the speed         presliding
          + a curve of the position for each direction of friction                     curves
          + what fades with the way gone                                               running in

behind a lag of first order.  A stop is the displacement less its play: a spring that slips at a force, so
that their sum is Maxwell slip (Al-Bender, Lampaert & Swevers, IEEE Trans. Automat. Contr. 50, 2005).  Where
no load was logged there is a constant in its place.  Coulomb friction is the law without parts.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plants.measured.friction.run import ForceRun
from plants.measured.guess.rough_models import lagged, plays

Array = NDArray[np.float64]
REACHES = (0.0025, 0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.3)
"""Thresholds of the stops, as shares of the range of the displacement."""

SPEEDS = (0.05, 0.1, 0.2, 0.4, 0.8)
"""Speeds at which friction saturates, as shares of the largest."""

SLOW = 0.02
"""Share of the largest speed below which Coulomb friction goes through zero."""

FADING = 5.0
"""Way, in ranges of the displacement, after which what runs in has faded to 1/e."""

FIRST_ROWS = 3
"""Measured rows from which the memory at the start of a run is recalled."""

SHARES = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""Memories that are tried: how far the displacement is ahead of each play, as a share of its threshold."""


@dataclass(frozen=True)
class FrictionParts:
    """What a law has beside Coulomb friction: presliding and rate, curves of the position with so many
    knots, running in; lag: time constant [s] behind all of it."""

    presliding: bool = False
    knots: int = 0
    running_in: bool = False
    lag: float = 0.0


@dataclass(frozen=True)
class Range:
    """Where a law was fitted: lowest displacement and its range, and the largest speed [1/s]."""

    low: float
    span: float
    fast: float

    @classmethod
    def of(cls, runs: Sequence[ForceRun]) -> "Range":
        """Of some runs; of the speed all but its highest hundredth."""
        x = np.concatenate([r.displacement for r in runs])
        fast = np.quantile(np.abs(np.concatenate([r.speed for r in runs])), 0.99)
        return cls(float(x.min()), max(float(np.ptp(x)), 1e-12), max(float(fast), 1e-12))


def columns(run: ForceRun, parts: FrictionParts, within: Range, start: float = 0.0) -> Array:
    """What is weighted, before the lag: columns (n, m), those of curves last, two a knot.

    start: share of each threshold by which the displacement is ahead of the plays when the run begins.
    """
    x, v = (run.displacement - within.low) / within.span, run.speed / within.fast
    sign = np.clip(v / SLOW, -1.0, 1.0)
    found = [np.ones(len(x)) if run.load is None else run.load, x - 0.5, v, sign]
    if parts.presliding:
        thresholds = within.span * np.array(REACHES)
        stops = (run.displacement[:, None] - plays(run.displacement, thresholds, start)) / thresholds
        found += [*stops.T, *(np.clip(v / s, -1.0, 1.0) for s in SPEEDS)]
    if parts.running_in:
        fading = np.exp(-run.travel / (FADING * within.span))
        found += [fading, fading * sign]
    if parts.knots:
        at = np.clip(x, 0.0, 1.0) * (parts.knots - 1)
        hats = np.maximum(0.0, 1.0 - np.abs(at[:, None] - np.arange(parts.knots)))
        found += [*hats.T, *(hats * sign[:, None]).T]
    return np.column_stack(found)


def behind_lag(run: ForceRun, parts: FrictionParts, within: Range, start: float = 0.0) -> Array:
    """The same columns (n, m) behind the lag."""
    return lagged(columns(run, parts, within, start), run.dt, parts.lag, 0.0)


@dataclass(frozen=True)
class FrictionLaw:
    """A law as it was fitted: its parts, the range that it was fitted in, a weight of each column (m,)."""

    parts: FrictionParts
    within: Range
    weights: Array

    def force(self, run: ForceRun) -> Array:
        """Force [N] of a run in a free run, (n,).  Of the measured force only the first rows are looked at,
        from which the memory that the run begins with is recalled."""
        if not self.parts.presliding:
            return self._from(run, 0.0)
        first = float(np.mean(run.force[:FIRST_ROWS]))
        tried = [self._from(run, s) for s in SHARES]
        return min(tried, key=lambda f: abs(float(np.mean(f[:FIRST_ROWS])) - first))

    def _from(self, run: ForceRun, start: float) -> Array:
        return behind_lag(run, self.parts, self.within, start) @ self.weights
