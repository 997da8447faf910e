"""The part of a residual that follows the simulated channel linearly, as a weight of unmodelled dynamics.

The spectrum of the residual E of held-out free runs against that of the simulated channel Y gives, in bands,
the gain |S_ye| / S_yy of the best linear relation between them and how sure it is.  The weight is of first
order and lies above the upper limit of that gain in every band that tells of it.  What follows no channel is
no dynamics of the plant: it is a disturbance (`plants.effects.wrist.remainder`).

Sources: Bendat, Piersol, Random Data, 4th ed. 2010, section 9.2 (errors of a frequency response);
Skogestad, Postlethwaite, Multivariable Feedback Control, 2nd ed. 2005, section 7.4 (the weight).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plants.parameters.remainder import UncertaintyWeight

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Piece = tuple[Array, Array, float]
"""A residual and the simulated channel (n,), in the channel's unit, and the sample time [s]."""

LINES = 6
"""Frequency lines that a band has at least, of all recordings together."""

OF_A_WINDOW = 35.0 / 18.0
"""Lines of a Hann window that are worth one without a window: 1 + 2 (2/3)^2 + 2 (1/6)^2, its neighbours being
correlated by 2/3 and 1/6."""

CHANCE = 0.01
"""Chance, over all bands, that a residual without any linear relation seems to have one."""

ABOVE = 10.0
"""Power of the simulated channel over that of the noise, above which a band tells of the gain."""

SIGMAS = 2.0
"""Standard deviations from the gain to its upper limit."""

CORNERS = 20
"""Corner frequencies that are tried."""


@dataclass(frozen=True)
class Band:
    """Gain of the best linear relation between `low` and `high` [Hz], found `at` the mean frequency of the
    simulated channel's power there.

    gain, spread: estimate and its standard deviation [1]; averages: independent lines; excited: whether the
    simulated channel stands above the noise.
    """

    low: float
    high: float
    at: float
    gain: float
    spread: float
    averages: float
    excited: bool

    @property
    def limit(self) -> float:
        """Upper limit of the gain [1]."""
        return self.gain + SIGMAS * self.spread

    @property
    def chance(self) -> float:
        """Probability that noise alone seems as large a gain: of F with 2 and 2 n degrees of freedom, n the
        averages."""
        share = (self.gain / max(self.spread, 1e-300)) ** 2 / (2.0 * self.averages)
        return float((1.0 + share) ** -self.averages)


def uncertainty_weight(pieces: Sequence[Piece], noise: float) -> UncertaintyWeight | None:
    """The weight of what residuals have of the simulated channel; None where nothing coherent is found, or
    where already the lowest band does not limit the gain below 1.

    noise: standard deviation of the channel's sensor, white, in its unit.
    """
    told: list[Band] = []
    for band in bands(pieces, noise) if pieces else ():
        if not band.excited or band.limit >= 1.0:
            break
        told.append(band)
    if not any(b.chance < CHANCE / len(told) for b in told):
        return None
    return _bounding(told)


def bands(pieces: Sequence[Piece], noise: float) -> list[Band]:
    """The relation in octaves, from the lowest frequency of the longest recording to the highest of any.

    >>> rng = np.random.default_rng(0)
    >>> y = np.cumsum(rng.standard_normal(4000))
    >>> round(bands([(0.2 * y, y, 0.01)], 1e-6)[0].gain, 3)
    0.2
    """
    lines, found = _lines(pieces), list[Band]()
    f, begin = lines[0], 0
    low = float(f[0]) if f.size else 0.0
    while begin < f.size:
        end = max(int(np.searchsorted(f, 2.0 * low)), begin + LINES)
        end = f.size if f.size - end < LINES else end
        own = slice(begin, end)
        found.append(_band(low, lines[0][own], lines[1][own], lines[2][own], lines[3][own], noise))
        begin, low = end, found[-1].high
    return found


def _lines(pieces: Sequence[Piece]) -> tuple[Array, Complex, Complex, Array]:
    """Frequency lines [Hz] of all pieces, ascending, without that of the mean, transforms of the simulated
    channel and of the residual there, in the unit over root Hz, and the sample time [s] of each line."""
    from scipy.signal.windows import hann

    found = []
    for left, simulated, dt in pieces:
        window = hann(len(left), sym=False)
        scale = np.sqrt(2.0 * dt / np.sum(window**2))
        y, e = (scale * np.fft.rfft(window * (x - np.mean(x)))[1:] for x in (simulated, left))
        found.append((np.fft.rfftfreq(len(left), dt)[1:], y, e, np.full(y.size, dt)))
    f, y, e, dts = (np.concatenate(of) for of in zip(*found, strict=True))
    order = np.argsort(f.real, kind="stable")
    return f.real[order], y[order], e[order], dts.real[order]


def _band(low: float, f: Array, y: Complex, e: Complex, dt: Array, noise: float) -> Band:
    power = np.abs(y) ** 2
    yy = max(float(power.sum()), 1e-300)
    relation = np.vdot(y, e) / yy
    # Powers of lines differ, most of all where the signal falls with the frequency: few of them decide, and
    # each of these draws the relation to itself (MacKinnon, White 1985, doi 10.1016/0304-4076(85)90158-7).
    apart = np.abs(e - relation * y) ** 2 / np.maximum(1.0 - power / yy, 1e-6)
    spread = np.sqrt(0.5 * OF_A_WINDOW * float(power @ apart)) / yy
    averages = yy * float(apart.sum()) / max(float(power @ apart), 1e-300) / OF_A_WINDOW
    averages = min(max(averages, 1.0), max(f.size / OF_A_WINDOW, 1.0))
    floor = 2.0 * noise**2 * float(dt.sum())
    at = float(power @ f) / yy
    return Band(low, float(f[-1]), at, float(abs(relation)), float(spread), averages, yy > ABOVE * floor)


def _bounding(told: Sequence[Band]) -> UncertaintyWeight:
    """The weight of first order that lies above all limits where they were found, by as little as possible as
    a share of each, and nowhere above 1, which is no model at all.

    For a given corner, |W|^2 is linear in the squares of its two gains: a linear programme.
    """
    from scipy.optimize import linprog

    middles = np.array([b.at for b in told])
    limits = np.array([max(b.limit, 1e-9) for b in told])
    best: tuple[float, UncertaintyWeight] | None = None
    for corner in np.geomspace(told[0].low, told[-1].high, CORNERS):
        x = (middles / corner) ** 2
        rows = np.column_stack([x / (1.0 + x), 1.0 / (1.0 + x)]) / limits[:, None] ** 2
        solved = linprog(rows.sum(axis=0), A_ub=-rows, b_ub=-np.ones(limits.size), bounds=(0.0, 1.0))
        if solved.status == 0 and (best is None or solved.fun < best[0]):
            high, low = np.sqrt(solved.x)
            best = solved.fun, UncertaintyWeight(float(low), float(high), float(corner), told[-1].high)
    assert best is not None  # gains of 1 lie above all limits at any corner
    return best[1]
