"""The sampled loop whose regulator has one law, as rows over a vector; floats or fractions alike.

With phi the change of pressure in a sample, late commands and the slope m of the branch,

    e+ = e - (1 - keep) d - after m phi,             e = r - y [deg]
    d+ = keep d + (1 - after) m phi,                 d = h - y [deg]
    q+ = q - phi + dt u[k - N],                      q = gain v - P [kPa]
    dt u = Kp (e+ - e) + Ki dt e,                    change of the command [kPa], N samples under way
    phi = low q + dt psi,                            0 <= psi q <= (high - low) / dt q^2,

psi [kPa/s] being what the law adds to its lowest rate: `RegulatorLaw` has its sector and its steepness.
The vector is (e, d, q; O; F; psi; u[k - N]): O the moments of what is under way in the
`rational.WindowPolynomials`, each u[k - i] times exp(-decay dt i); F [kPa] how far the pressure is from the
line that it left, F+ = F - phi.  Without dead time there is neither O nor the last.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import exp
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.memory.rational import (
    WindowPolynomials,
    exact,
    range_on_unit,
    window_polynomials,
)
from design.robustness.loop_model import LoopModel
from plants import lag
from plants.actuator import regulator

Array = NDArray[np.float64]

MOMENTS = 3
"""Moments of what is under way that a function knows of."""

DIGITS = 2**44
"""Denominator of the growth of a sample, so that its powers stay short."""


Bounds = tuple[float, float]


@dataclass(frozen=True)
class Plants:
    """Plants between bounds: slopes [deg/kPa] by branch and lag Tw [s], which may drift; rates slow and fast
    [1/s] of the regulator's law, and its gain as a ratio to the model's, which may not."""

    slopes: Mapping[str, Bounds]
    slow: Bounds
    fast: Bounds
    lag: Bounds
    gain: Bounds = (1.0, 1.0)

    @classmethod
    def of(cls, model: LoopModel) -> "Plants":
        """The one plant of a model."""
        return cls(
            {branch: (s, s) for branch, s in model.slopes.items()}, (model.k_slow, model.k_slow),
            (model.k_fast, model.k_fast), (model.Tw, model.Tw),
        )  # fmt: skip

    @property
    def inner(self) -> tuple[float, ...]:
        """Ends of the slope of the flattest branch, the transit."""
        return min(_ends(s) for s in self.slopes.values())

    @property
    def extremes(self) -> tuple[float, ...]:
        """Least and largest slope of all."""
        return _ends((min(s[0] for s in self.slopes.values()), max(s[1] for s in self.slopes.values())))


def _ends(bounds: Bounds) -> tuple[float, ...]:
    return tuple(sorted(set(bounds)))


@dataclass(frozen=True)
class RegulatorLaw:
    """What is known of the share of q that a sample takes away, for every q: it lies between low and high,
    and share times q grows with q at a rate between `flattest` and `steepest`; without unit."""

    low: Fraction
    high: Fraction
    flattest: Fraction
    steepest: Fraction

    @property
    def grows(self) -> bool:
        """Whether psi grows with q."""
        return self.flattest >= self.low


def regulator_law(plants: Plants, dt: float) -> RegulatorLaw:
    """Of the laws that the simulator steps, `plants.actuator.regulator`, at a sample time [s]: a cubic in
    w = q^2 / (q^2 + e0^2), each of whose coefficients lies between bounds.

    >>> from plants import Wrist
    >>> from design.controllers.pi import PI
    >>> law = regulator_law(Plants.of(LoopModel.of(Wrist.flexion(), PI(1.2, 2.2))), 0.001)
    >>> [round(1000 * float(x), 3) for x in (law.low, law.high, law.steepest)], law.grows
    ([0.55, 8.96, 10.087], True)
    """
    corners = [
        regulator.sampled(regulator.Regulator(1.0, fast, slow, 1.0), dt)
        for slow in plants.slow
        for fast in plants.fast
    ]
    slow, rise, z, centre = (
        _hull([Fraction(float(getattr(c, name))) for c in corners])
        for name in ("alpha_slow", "alpha_rise", "z_rise", "z_centre")
    )
    bent, square = _hull([a * b for a in z for b in centre]), _hull([a * b for a in z for b in z])
    share = [slow, _less(rise, bent), _less(bent, square), square]
    # Of share times q: sum_k c_k ((1 + 2 k) w^k - 2 k w^(k + 1)), no term of which is negative but c_k.
    found: list[Fraction] = []
    for values in ([c[0] for c in share], [c[1] for c in share]):
        slope = [Fraction(0)] * (len(values) + 1)
        for k, c in enumerate(values):
            slope[k] += (1 + 2 * k) * c
            slope[k + 1] -= 2 * k * c
        found += [*range_on_unit(values), *range_on_unit(slope)]
    return RegulatorLaw(found[0], found[5], found[2], found[7])


def _hull(values: list[Fraction]) -> tuple[Fraction, Fraction]:
    return min(values), max(values)


def _less(a: tuple[Fraction, Fraction], b: tuple[Fraction, Fraction]) -> tuple[Fraction, Fraction]:
    return a[0] - b[1], a[1] - b[0]


@dataclass(frozen=True)
class OneSample:
    """What the move of a sample hangs on: slope [deg/kPa], keep and after of `plants.lag`, ratio of gains."""

    slope: float
    keep: float
    after: float
    gain: float


@dataclass(frozen=True)
class LoopRows:
    """Rows over the vector: state now (n + 1, size), the last being F; the same a sample later and times the
    growth; u now, u[k - N] times growth^-N, q, psi, and (q+ - q)/dt."""

    now: Any
    after: Any
    sent: Any
    arrived: Any
    q: Any
    psi: Any
    moved: Any


@dataclass(frozen=True)
class FixedLawLoop:
    """A PI and wrists behind N samples of dead time in all; polynomials of the window."""

    model: LoopModel
    plants: Plants
    law: RegulatorLaw
    samples: int
    window: WindowPolynomials

    @classmethod
    def of(cls, model: LoopModel, samples: int, plants: Plants | None = None) -> "FixedLawLoop":
        """The loop behind so many samples, the plant's own among them; plants: the model's if not given."""
        plants = plants or Plants.of(model)
        window = window_polynomials(samples, min(MOMENTS, samples))
        return cls(model, plants, regulator_law(plants, model.dt), samples, window)

    @property
    def moments(self) -> int:
        """How many moments are known."""
        return len(self.window.first)

    @property
    def states(self) -> int:
        """Three, and the moments."""
        return 3 + self.moments

    @property
    def size(self) -> int:
        """Length of the vector."""
        return self.states + 2 + int(self.samples > 0)

    @property
    def span(self) -> float:
        """Dead time [s]."""
        return self.samples * self.model.dt

    @property
    def sector(self) -> float:
        """Largest psi/q [1/s]."""
        return float(self.law.high - self.law.low) / self.model.dt

    def steps(self, slopes: Iterable[float]) -> list[OneSample]:
        """The corners of what the move of a sample hangs on, at some slopes.

        The next state is affine in each of them by itself, and a function that is convex in it therefore
        largest at a corner.
        """
        lags = [lag.sampled(T, self.model.dt) for T in _ends(self.plants.lag)]
        keeps, afters = sorted({float(c.keep) for c in lags}), sorted({float(c.after) for c in lags})
        return [OneSample(*c) for c in product(slopes, keeps, afters, _ends(self.plants.gain))]

    def rows(self, step: OneSample, growth: Fraction, floats: bool = False) -> LoopRows:
        """One sample, with what grows by `growth` in it taken out."""
        m, n = self.model, self.states
        numbers = [step.keep, step.after, m.dt, step.slope, m.Kp, m.Ki, step.gain]
        keep, last, dt, s, Kp, Ki, gain = (float(x) if floats else Fraction(float(x)) for x in numbers)
        Kp, Ki = gain * Kp, gain * Ki
        g, low = (float(x) if floats else x for x in (growth, self.law.low))
        one: Any = np.eye(self.size) if floats else exact(np.eye(self.size))
        e, d, q, F, psi = one[0], one[1], one[2], one[n], one[n + 1]
        phi = low * q + dt * psi
        de, dd = -(1 - keep) * d - last * s * phi, -(1 - keep) * d + (1 - last) * s * phi
        sent = (Kp / dt) * de + Ki * e
        arrived = one[-1] if self.samples else sent
        dq = dt * g**self.samples * arrived - phi
        after = [g * (e + de), g * (d + dd), g * (q + dq)]
        if self.samples:
            w, N = self.window, self.samples
            first, beyond, shift = (
                np.asarray(x, float if floats else object) for x in (w.first, w.beyond, w.shift)
            )
            for j in range(self.moments):
                row = sum(shift[j, i] * one[3 + i] for i in range(self.moments))
                after.append(row + (first[j] * sent - beyond[j] * arrived) / N)
        after.append(g * (F - phi))
        return LoopRows(one[: n + 1], np.array(after), sent, arrived, q, psi, dq / dt)


def growth_of(decay: float, dt: float) -> Fraction:
    """By how much in a sample of dt [s] a rate [1/s] multiplies, at least."""
    return Fraction(int(exp(decay * dt) * DIGITS) + 1, DIGITS)
