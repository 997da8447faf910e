"""Stability of one loop with given parameters, and the smallest growth of a box that loses it.

With all parameters positive |L(j omega)| falls with the frequency, so that the loop has one gain
crossing, and a dead time can only destabilise it there: the loop is stable where its phase margin there
is more than what the dead time takes, and only there.  With unmodelled dynamics of weight W it is stable
where, besides, |W L| < |1 + L| at every frequency, and only there (Skogestad, Postlethwaite, Multivariable
Feedback Control, 2005, section 7.5).
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.constant.uncertain_loop import NAMES, UncertainLoop

Array = NDArray[np.float64]

GRID = np.geomspace(1e-3, 1e3, 240)
"""Frequencies [rad/s] at which unmodelled dynamics are looked at."""

BEYOND = 1e-4
"""Share by which the vector that is reported lies beyond the border, so that its root is clearly unstable."""


@dataclass(frozen=True)
class Destabilising:
    """Parameters by name at which the loop is unstable; growth: of the box that just holds them;
    root [1/s]: of the characteristic equation there, in the right half plane; residual: of that root, as a
    share of the largest term of the equation.  dynamics: where unmodelled dynamics are needed besides, the
    gain of delta, at most 1, that puts a root at `root` on the imaginary axis."""

    parameters: dict[str, float]
    growth: float
    root: complex
    residual: float
    dynamics: float | None = None

    @property
    def confirmed(self) -> bool:
        """Whether the root is one, and unstable."""
        if self.dynamics is not None:
            return self.dynamics <= 1.0
        return self.root.real > 0.0 and self.residual < 1e-9


def crossing(loop: UncertainLoop, parameters: Array) -> Array:
    """The gain crossing [rad/s] of loops at (..., 4), all positive; shape (...)."""
    slope, rate, lag, gain = np.moveaxis(parameters, -1, 0)
    c = (slope * rate * lag * gain) ** 2
    # |L| = 1 in x = omega^2: x^3 + a x^2 + b x - d = 0, one change of sign, so one positive root.
    a, b, d = rate**2 + lag**2, (rate * lag) ** 2 - c * loop.Kp**2, c * loop.Ki**2
    companion = np.zeros((*slope.shape, 3, 3))
    companion[..., 1, 0] = companion[..., 2, 1] = 1.0
    companion[..., 0, 0], companion[..., 0, 1], companion[..., 0, 2] = -a, -b, d
    x = np.max(np.linalg.eigvals(companion).real, axis=-1)
    for _ in range(3):  # Newton, from above, where the cubic is convex
        x = x - (((x + a) * x + b) * x - d) / ((3.0 * x + 2.0 * a) * x + b)
    found: Array = np.sqrt(np.maximum(x, 0.0))
    return found


def slack(loop: UncertainLoop, parameters: Array) -> Array:
    """Phase margin less what the dead time takes of it [rad], at (..., 4); stable where it is above 0.

    -pi where a parameter is 0 or negative: with one at 0 the loop has a root at 0.
    """
    p = np.asarray(parameters, float)
    positive = np.all(p > 0.0, axis=-1) & (loop.Ki > 0.0)
    p = np.where(positive[..., None], p, 1.0)
    omega = crossing(loop, p)
    phase = 0.5 * np.pi + np.arctan2(loop.Kp * omega, loop.Ki)
    phase = phase - np.arctan(omega / p[..., 1]) - np.arctan(omega / p[..., 2])
    found: Array = np.where(positive, phase - loop.dead_time * omega, -np.pi)
    return found


def dynamics(loop: UncertainLoop, parameters: Array) -> tuple[Array, Array]:
    """The least gain of delta at which unmodelled dynamics destabilise loops at (..., 4), all stable without
    them, and the frequency [rad/s] of it; both (...).  inf without a weight."""
    p = np.asarray(parameters, float)[..., None, :]
    if loop.weight is None:
        return np.full(p.shape[:-2], np.inf), np.zeros(p.shape[:-2])
    s = 1j * GRID
    slope, rate, lag, gain = np.moveaxis(p, -1, 0)
    forward = slope * rate * lag * gain * (loop.Kp * s + loop.Ki) * np.exp(-s * loop.dead_time)
    back = s * (s + rate) * (s + lag)
    with np.errstate(divide="ignore"):
        least = np.abs(back + forward) / np.abs(loop.weight.response(GRID) * forward)
    at = np.argmin(least, axis=-1)
    return np.take_along_axis(least, at[..., None], -1)[..., 0], GRID[at]


def _lost(loop: UncertainLoop, parameters: Array) -> NDArray[np.bool_]:
    """Whether loops at (..., 4) are not stable, whatever the unmodelled dynamics; shape (...)."""
    lost = slack(loop, parameters) <= 0.0
    return lost if loop.weight is None else lost | (dynamics(loop, parameters)[0] <= 1.0)


def growths(loop: UncertainLoop, directions: Array, points: int = 129) -> Array:
    """Growth at which the ray from the centre along each direction, (m, 4), first leaves stability, (m,).

    Directions have a largest entry of 1; rays are looked at in steps, then halved.
    """
    zero = _growth_to_zero(loop)
    scan = np.linspace(0.0, zero, points)
    bad = _lost(loop, loop.at(scan[:, None, None] * directions))
    first = np.argmax(bad, axis=0)
    high = np.where(bad.any(axis=0), scan[first], zero)
    low = np.where(bad.any(axis=0), scan[np.maximum(first - 1, 0)], zero)
    for _ in range(40):
        middle = 0.5 * (low + high)
        lost = _lost(loop, loop.at(middle[:, None] * directions))
        low, high = np.where(lost, low, middle), np.where(lost, middle, high)
    found: Array = high
    return found


def _growth_to_zero(loop: UncertainLoop) -> float:
    """Growth at which the first of the parameters reaches 0."""
    at = loop.uncertain
    return float(np.min(np.array(loop.centre)[at] / np.array(loop.radius)[at]))


def smallest(loop: UncertainLoop, rounds: int = 4) -> Destabilising:
    """The smallest growth of the box found that holds an unstable loop: corners, then each entry of the
    best direction varied on its own, and a parameter that reaches 0."""
    uncertain = loop.uncertain
    ends = [(-1.0, 1.0) if there else (0.0,) for there in uncertain]
    corners = np.array(list(product(*ends)))
    found = growths(loop, corners)
    best, growth = corners[np.argmin(found)], float(np.min(found))
    width = 2.0
    for _ in range(rounds):
        width *= 0.4
        tried = np.repeat(best[None], 9 * int(uncertain.sum()), axis=0)
        for row, i in enumerate(np.flatnonzero(uncertain)):
            rows = slice(9 * row, 9 * row + 9)
            tried[rows, i] = np.clip(best[i] + np.linspace(-width, width, 9), -1.0, 1.0)
        tried /= np.max(np.abs(tried), axis=1, keepdims=True)
        found = growths(loop, tried)
        if np.min(found) < growth:
            best, growth = tried[np.argmin(found)], float(np.min(found))
    zero = _growth_to_zero(loop)
    if zero <= growth:
        ratio = np.where(uncertain, np.array(loop.centre) / np.where(uncertain, loop.radius, 1.0), np.inf)
        best, growth = np.where(np.arange(4) == np.argmin(ratio), -1.0, 0.0), zero
    growth *= 1.0 + BEYOND
    p = loop.at(growth * best)
    if loop.weight is not None and slack(loop, p) > 0.0:
        needed, omega = dynamics(loop, p)
        return Destabilising(
            dict(zip(NAMES, map(float, p), strict=True)), growth, 1j * float(omega), 0.0, float(needed)
        )
    root, residual = _root(loop, p)
    return Destabilising(dict(zip(NAMES, map(float, p), strict=True)), growth, root, residual)


def _root(loop: UncertainLoop, p: Array) -> tuple[complex, float]:
    """A root of the characteristic equation at (4,), just beyond the border, and how well it satisfies it."""
    import scipy.optimize

    slope, rate, lag, gain = p
    forward = slope * rate * lag * gain

    def terms(s: complex) -> tuple[complex, complex]:
        late = forward * (loop.Kp * s + loop.Ki) * np.exp(-s * loop.dead_time)
        return s * (s + rate) * (s + lag), complex(late)

    if forward * loop.Ki < 0.0:  # a parameter below 0: negative at s = 0, positive far out
        far = abs(rate) + abs(lag)
        while sum(terms(far)).real <= 0.0:
            far *= 2.0
        root = complex(scipy.optimize.brentq(lambda s: sum(terms(s)).real, 0.0, far, xtol=1e-300))
    else:
        root = 1j * float(crossing(loop, p))
        for _ in range(50):  # Newton's method
            free, late = terms(root)
            rise = (root + rate) * (root + lag) + root * (2.0 * root + rate + lag)
            rise += forward * loop.Kp * np.exp(-root * loop.dead_time) - loop.dead_time * late
            root = complex(root - (free + late) / rise)
    free, late = terms(root)
    return root, float(abs(free + late) / max(abs(free), abs(late), 1e-300))
