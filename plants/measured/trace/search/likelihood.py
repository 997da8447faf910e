"""How likely what a model leaves is as noise of a colour of its own: the evidence for an effect in a
residual that may be nothing but slow noise.

Where noise has a memory, chi-square per row counts rows that say the same thing over and over, and what is
fitted to one half of them predicts the other badly whatever the model.  The likelihood holds each row
against what the noise before it lets expect: of slow waves a minute holds few, and they count as few.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plants.measured.residual.battery import freedom_of
from plants.measured.residual.series.background import background
from plants.measured.residual.series.joined import Joined, join
from plants.measured.residual.series.remainder import Remainder
from plants.measured.trace.stages.model import Model

Array = NDArray[np.float64]
CHANCE = 1e-3
"""Probability that noise alone gives any of the values tried in a search the evidence demanded."""

TRIED = 500
"""Values of effects that a search tries, in the grids of all forms: so many chances to follow the noise."""

PAST = 1.5
"""Time [s] from which a row is expected: white noise hides what lies further back than a few memories."""

QUIETEST = 1e-6
"""Least power of the noise, in units of its floor and of a thousandth of the remainder: a model may leave
nothing at some frequency."""

STEPS, SHORTER, GAIN = 4, 0.3, 0.05
"""Steps towards the greatest likelihood, how much shorter the next is where one led down, and the least
rise that counts."""


@dataclass(frozen=True)
class Expected:
    """Best linear prediction of stationary noise of a spectrum from the rows before.

    weights: of a row and of the rows before it, row t of (p, p) for the row at t < p of a recording, whose
    first entry is that recording's first row; spread: standard deviations (p,) of what is not predicted.
    The last row serves all later rows too.
    """

    weights: Array
    spread: Array

    def surprise(self, series: Array) -> Array:
        """What was not expected of series (n, ...), over its spread."""
        from scipy.signal import lfilter

        p = len(self.spread)
        found = lfilter(self.weights[-1, ::-1] / self.spread[-1], 1.0, series, axis=0)
        first = series[:p]
        m = len(first)
        head = np.tensordot(self.weights[:m, :m] / self.spread[:m, None], first, axes=1)
        both: Array = np.concatenate([head, found[m:]])
        return both

    def unlikely(self, series: Array) -> float:
        """Minus the log-likelihood of a series (n,), up to a constant for each row."""
        p, n = len(self.spread), len(series)
        logs = np.log(self.spread)
        scale = float(logs[: min(p, n)].sum() + max(0, n - p) * logs[-1])
        return scale + 0.5 * float(np.sum(self.surprise(series) ** 2))


def expected(spectrum: Array, length: int, rows: int) -> Expected:
    """Prediction from up to `rows` rows of noise of a spectrum, which is that of a circle of a length.

    Levinson's recursion (J. Math. Phys. 25 (1947) 261).
    """
    covariance = np.fft.irfft(spectrum, length)[: rows + 1]
    weights, variance = np.zeros((rows, rows)), np.empty(rows)
    ahead = np.zeros(0)  # weights of the row before, the one before that, ...
    left = float(covariance[0])
    for t in range(rows):
        weights[t, t] = 1.0
        weights[t, :t] = -ahead[::-1]
        variance[t] = left
        reflection = float(covariance[t + 1] - ahead @ covariance[t:0:-1]) / left
        ahead = np.append(ahead - reflection * ahead[::-1], reflection)
        left *= 1.0 - reflection**2
    return Expected(weights, np.sqrt(variance))


def demanded(more: int, duration: float) -> float:
    """The rise of the log-likelihood that noise alone stays below, but for a probability of CHANCE, where
    an effect adds so many parameters to a model of recordings of so long a duration [s] in all.

    With the spectrum known, twice the rise of the greatest likelihood follows chi-square with as many degrees
    of freedom (Wilks, Ann. Math. Statist. 9 (1938) 60); with one found in these recordings, a multiple of F,
    whose second degrees of freedom say how well slow noise is known.  The best of TRIED values is looked at,
    so that each may exceed the bound only so much more rarely (Bonferroni).

    >>> round(demanded(1, 1e6), 1), round(demanded(3, 280.0), 1), round(demanded(3, 60.0), 1)
    (11.3, 16.9, 29.9)
    """
    from scipy.stats import f

    return 0.5 * more * float(f.isf(CHANCE / TRIED, more, freedom_of(duration)))


def log_likelihood(model: Model) -> float:
    """Logarithm of the likelihood of a fitted model, up to a constant, its noise being of any colour.

    That of Gaussian noise, in recordings independent of each other, with the spectrum that `background`
    finds in what the model leaves.  Least squares weigh slow noise wrongly, so that two
    fits differ by more than their models do: from them it climbs by generalised least squares.
    """
    now = _left(model)
    best, reach = likelihood_of(now), 1.0
    step = _step(model, now)
    for _ in range(STEPS):
        other = model.at(np.clip(model.vector + reach * step, model.bounds[1], model.bounds[2]))
        left = _left(other)
        found = likelihood_of(left)
        if found > best + GAIN:
            model, best, reach = other, found, 1.0
            step = _step(model, left)
        else:
            reach *= SHORTER
    return best


def likelihood_of(left: Joined) -> float:
    """Log-likelihood of series as noise of the spectrum that is found in them, up to a constant."""
    noise = noise_in(left)
    return -sum(noise.unlikely(left.value[span] + left.mean) for span in left.spans)


def noise_in(left: Joined) -> Expected:
    """What the noise in series lets expect."""
    total = float(np.mean(left.value[left.inside] ** 2))
    spectrum = np.maximum(background(left), QUIETEST * max(1.0, 1e-3 * total))
    return expected(spectrum, left.length, max(2, round(PAST / left.dt)))


def _left(model: Model) -> Joined:
    """What a model leaves, in units of the noise's floor."""
    stage = model.stage
    return join(
        [
            Remainder(p.recording.name, "wrist", p.recording.time, model.residual[a:b], 1.0, {})
            for p, a, b in zip(stage.playbacks, stage.edges[:-1], stage.edges[1:], strict=True)
        ]
    )


def _step(model: Model, left: Joined) -> Array:
    """Change of the parameters (n,) to where what is left is least unexpected, in the model linearised."""
    noise = noise_in(left)
    residual, slopes = model.linear
    size = np.linalg.norm(slopes, axis=0)
    size = np.where(size > 0.0, size, np.inf)
    both = np.column_stack([residual, slopes / size])
    thin = -(-len(residual) // sum(s.stop - s.start for s in left.spans))  # as `join` thins a long log
    edges = model.stage.edges
    white = np.concatenate([noise.surprise(both[a:b:thin]) for a, b in pairwise(edges)])
    step: Array = -np.linalg.lstsq(white[:, 1:], white[:, 0], rcond=1e-6)[0] / size
    return step
