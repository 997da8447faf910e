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

from dataclasses import dataclass
from fractions import Fraction
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


def regulator_law(model: LoopModel) -> RegulatorLaw:
    """Of the law that the simulator steps, `plants.actuator.regulator`: a cubic in w = q^2 / (q^2 + e0^2).

    >>> from plants import Wrist
    >>> from design.controllers.pi import PI
    >>> law = regulator_law(LoopModel.of(Wrist.flexion(), PI(1.2, 2.2)))
    >>> [round(1000 * float(x), 3) for x in (law.low, law.high, law.steepest)], law.grows
    ([0.55, 8.96, 10.008], True)
    """
    c = regulator.sampled(regulator.Regulator(1.0, model.k_fast, model.k_slow, 1.0), model.dt)
    slow, rise, z, centre = (Fraction(float(x)) for x in (c.alpha_slow, c.alpha_rise, c.z_rise, c.z_centre))
    share = np.array([slow, rise - z * centre, z * centre - z * z, z * z], dtype=object)
    # d(share q)/dq = share + 2 w (1 - w) d share/dw
    bend = np.array([k * x for k, x in enumerate(share)][1:], dtype=object)
    slope = np.array([*share, Fraction(0)], dtype=object)
    slope[1:4] += 2 * bend
    slope[2:5] -= 2 * bend
    return RegulatorLaw(*range_on_unit(list(share)), *range_on_unit(list(slope)))


@dataclass(frozen=True)
class Rows:
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
    """A PI and a wrist behind N samples of dead time in all; polynomials of the window."""

    model: LoopModel
    law: RegulatorLaw
    samples: int
    window: WindowPolynomials

    @classmethod
    def of(cls, model: LoopModel, samples: int) -> "FixedLawLoop":
        """The loop behind so many samples, the plant's own among them."""
        return cls(model, regulator_law(model), samples, window_polynomials(samples, min(MOMENTS, samples)))

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

    def rows(self, slope: float, growth: Fraction, floats: bool = False) -> Rows:
        """One sample on a branch of a slope [deg/kPa], with what grows by `growth` in it taken out."""
        m, n = self.model, self.states
        c = lag.sampled(m.Tw, m.dt)
        numbers = [c.keep, c.after, m.dt, slope, m.Kp, m.Ki]
        keep, last, dt, s, Kp, Ki = (float(x) if floats else Fraction(float(x)) for x in numbers)
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
        return Rows(one[: n + 1], np.array(after), sent, arrived, q, psi, dq / dt)


def growth_of(decay: float, dt: float) -> Fraction:
    """By how much in a sample of dt [s] a rate [1/s] multiplies, at least."""
    return Fraction(int(exp(decay * dt) * DIGITS) + 1, DIGITS)
