"""The loop on one branch with constant parameters that are only known within intervals.

    de/dt = -u,      dm/dt = slope f - u,      dq/dt = c(t - dead_time) - f,
    u = lag m,       f = rate q,               c = gain (Ki e - Kp u),

with e = r - y, m = h - y, q = gain v - P (`design.robustness.loop_model`), lag = 1/Tw and gain the
regulator's over what the controller takes it for.  Written so, each parameter stands at one place
only: with parameter = centre + radius delta it is one real scalar block of the form M-Delta, none
repeated.  Off the branch k(e), memory and sampling are no part of it.

A dead time is no rational function.  Up to some frequency it is a Pade approximant of order (n, n),
which is all-pass, times 1 + epsilon delta with delta complex, |delta| <= 1: on the imaginary axis the
approximant's error at x = omega dead_time is at most x^(2n+1) (n!)^2 / ((2n)! (2n+1)!), by its integral
form and since its denominator is no smaller there than at 0 (Hairer, Wanner, Solving Ordinary
Differential Equations II, section IV.3).  Above that frequency it is any complex number of modulus up to
1, which the loop, small there, can bear.

Unmodelled dynamics, y (1 + W delta) with delta complex, |delta| <= 1, and W a weight of first order, stand at
the command, c (1 + W delta): in a loop of one signal and constant parameters only the product counts.
"""

from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from design.robustness.box import Box
from design.robustness.certificates.constant.mu import Block
from design.robustness.certificates.constant.mu_sweep import System
from plants.parameters.remainder import UncertaintyWeight

Array = NDArray[np.float64]

NAMES = ("slope", "rate", "lag", "gain")
ORDER, REACH = 10, 10.0
"""Of the Pade approximant (even), and the x up to which it is used: its error is then 1.1e-4."""

ROUNDING = 1e-7
"""What the roots of its denominator may be off by; see `pade_error`."""


@dataclass(frozen=True)
class UncertainLoop:
    """Gains Kp [kPa/deg], Ki [kPa/(deg s)] and, in the order of NAMES, centre and radius, (4,), of
    slope [deg/kPa], rate [1/s], lag [1/s] and gain [1]; dead_time [s].  A certain one has radius 0.  weight:
    of unmodelled dynamics, None without."""

    Kp: float
    Ki: float
    centre: tuple[float, ...]
    radius: tuple[float, ...]
    dead_time: float = 0.0
    weight: UncertaintyWeight | None = None

    @classmethod
    def of(cls, box: Box, controller: PI, branch: str, rate: str, dead_time: float = 0.0) -> "UncertainLoop":
        """The loop of a box on a branch (of `plants.linearisation.branch_slopes`) at a rate (``slow``,
        ``fast``).

        dead_time [s]: beside the plant's own.  Bounds of Tw become bounds of 1/Tw, whose centre is
        not 1/Tw of the plant.  A residual that has a weight is unmodelled dynamics, and no change of slopes.

        >>> from plants.parameters.files import built_in
        >>> from design.robustness.box import box_of
        >>> loop = UncertainLoop.of(box_of(built_in("flexion")), PI(1.2, 2.2), "line1", "slow")
        >>> [round(c, 4) for c in loop.centre], [round(r, 4) for r in loop.radius]
        ([0.36, 0.55, 6.5104, 1.0], [0.036, 0.11, 1.3021, 0.0])
        """
        weight = box.weight
        box = box if weight is None else box.leaving(None)
        Tw_low, Tw_high = box.bounds("Tw")
        known = float(controller.gain)
        bounds = np.array(
            [
                box.slopes(branch),
                box.bounds(f"k_{rate}"),
                (1.0 / Tw_high, 1.0 / Tw_low),
                [g / known for g in box.bounds("gain")],
            ]
        )
        centre, radius = bounds.mean(axis=1), 0.5 * (bounds[:, 1] - bounds[:, 0])
        return cls(
            float(controller.Kp),
            float(controller.Ki),
            tuple(map(float, centre)),
            tuple(map(float, radius)),
            dead_time,
            weight,
        )

    @property
    def uncertain(self) -> NDArray[np.bool_]:
        """Which of the parameters are, (4,)."""
        return np.array(self.radius) > 0.0

    def at(self, delta: Array) -> Array:
        """Parameters, (..., 4), at places in the box, 0 its centre and -1, 1 its ends."""
        found: Array = np.array(self.centre) + np.array(self.radius) * delta
        return found

    def matrix(self, parameters: Array) -> Array:
        """dx/dt = matrix x of the loop without dead time, (..., 3, 3), x = (e, m, q), at (..., 4)."""
        slope, rate, lag, gain = np.moveaxis(np.asarray(parameters, float), -1, 0)
        found = np.zeros((*slope.shape, 3, 3))
        found[..., 0, 1] = found[..., 1, 1] = -lag
        found[..., 1, 2], found[..., 2, 2] = slope * rate, -rate
        found[..., 2, 0], found[..., 2, 1] = gain * self.Ki, -gain * self.Kp * lag
        return found


def systems(loop: UncertainLoop) -> list[System]:
    """M of the form M-Delta: its parts, which together cover every frequency; one where there is no
    dead time.  Blocks: the uncertain parameters in the order of NAMES, then that of unmodelled dynamics and
    that of the dead time."""
    if loop.dead_time == 0.0:
        return [_system(loop, "none", 0.0, np.inf)]
    end = REACH / loop.dead_time
    return [_system(loop, "pade", 0.0, end), _system(loop, "any", end, np.inf)]


def _system(loop: UncertainLoop, delay: str, low: float, high: float) -> System:
    """One part of M: each signal is a row over the states, then the outputs w of Delta."""
    sections = pade_sections(loop.dead_time) if delay == "pade" else []
    own = 3 if loop.weight is None else 4
    states = own + 2 * len(sections)
    rows = np.eye(states + 6)
    e, m, q = rows[:3]
    w_slope, w_rate, w_lag, w_gain, w_left, w_delay = rows[states:]
    slope, rate, lag, gain = loop.centre
    r = loop.radius
    u = lag * m + w_lag
    f = rate * q + w_rate
    wanted = loop.Ki * e - loop.Kp * u
    c = gain * wanted + w_gain
    z = [r[0] * f, r[1] * q, r[2] * m, r[3] * wanted]
    blocks = [Block("real")] * 4
    weighed = []
    if loop.weight is not None:
        w, x, corner = loop.weight, rows[3], 2.0 * np.pi * loop.weight.corner_Hz
        weighed.append(corner * (c - x))
        z.append(w.high * c + (w.low - w.high) * x)
        blocks.append(Block("complex", fixed=True))
        c = c + w_left
    late, held = _all_pass(c, rows[own:states], sections)
    if delay == "pade":
        z.append(pade_error(REACH) * late)
        late = late + w_delay
    elif delay == "any":
        z.append(c)
        late = w_delay
    if delay != "none":
        blocks.append(Block("complex", fixed=True))
    change = np.array([-u, slope * f + w_slope - u, late - f, *weighed, *held])
    used = np.concatenate([loop.uncertain, np.ones(len(z) - 4, bool)])
    out = np.array(z)[used]
    inputs = np.concatenate([loop.uncertain, [loop.weight is not None, delay != "none"]])
    columns = states + np.flatnonzero(inputs)
    return System(
        change[:, :states],
        change[:, columns],
        out[:, :states],
        out[:, columns],
        tuple(b for b, there in zip(blocks, used, strict=True) if there),
        low,
        high,
    )


def _all_pass(signal: Array, states: Array, sections: list[tuple[float, float]]) -> tuple[Array, list[Array]]:
    """A signal behind sections (s^2 - a s + w^2) / (s^2 + a s + w^2), and the derivatives of their states."""
    changes: list[Array] = []
    for i, (a, w) in enumerate(sections):
        x1, x2 = states[2 * i], states[2 * i + 1]
        changes += [w * x2, -w * x1 - a * x2 + signal]
        signal = signal - 2.0 * a * x2
    return signal, changes


def pade_sections(dead_time: float, order: int = ORDER) -> list[tuple[float, float]]:
    """(a, w) [1/s] of the all-pass sections of second order whose product approximates exp(-s dead_time)."""
    n = order
    coefficients = [
        factorial(2 * n - j) * factorial(n) / (factorial(2 * n) * factorial(j) * factorial(n - j))
        for j in range(n, -1, -1)
    ]
    roots = np.roots(coefficients) / dead_time
    return [(float(-2.0 * x.real), float(abs(x))) for x in roots if x.imag > 0.0]


def pade_error(x: float, order: int = ORDER) -> float:
    """Bound of |approximant - exp(-jx)|, at x and below, with what rounding may add."""
    n = order
    share = factorial(n) ** 2 / (factorial(2 * n) * factorial(2 * n + 1))
    return float(x ** (2 * n + 1) * share + ROUNDING)


def pade_response(dead_time: float, omega: Array, order: int = ORDER) -> NDArray[np.complex128]:
    """The approximant at frequencies [rad/s]."""
    s = 1j * np.asarray(omega, float)
    found = np.ones(s.shape, complex)
    for a, w in pade_sections(dead_time, order):
        found *= (s * s - a * s + w * w) / (s * s + a * s + w * w)
    return found
