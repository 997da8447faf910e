"""Lyapunov functions of the loop: what a solver hands over and the check looks at.

    V = X' P X + int_0^1 (S + (1 - s) R) z(t - tau s)^2 ds + 2 lambda int_0^q psi,

X the states and the moments of z (`signals`); without dead time X is x
and the first integral is left out, in a quadratic form the second.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.reasons import NoCertificate

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Form:
    """P (n, n), n - 3 moments; S, R, popov (lambda): not negative; multipliers: of the sector at each
    of `slopes` [deg/kPa], ascending, in between linear; decay [1/s]: that V is to decay with at
    twice the rate; open_law: whether psi is left open, or the rate of the regulator anywhere between
    its two at any time (`multipliers` is then empty)."""

    P: Array
    decay: float
    open_law: bool
    popov: float = 0.0
    slopes: tuple[float, ...] = ()
    multipliers: tuple[float, ...] = ()
    S: float = 0.0
    R: float = 0.0

    @property
    def order(self) -> int:
        """How many moments the form knows."""
        return len(self.P) - 3

    @property
    def below(self) -> Array:
        """A matrix Q with X' Q X <= V, from Bessel's inequality, (n, n)."""
        weights = np.concatenate([np.zeros(3), 2.0 * np.arange(self.order) + 1.0])
        return self.P + self.S * np.diag(weights)

    @property
    def record(self) -> dict[str, Any]:
        """The form for JSON."""
        found: dict[str, Any] = {"P": self.P.tolist(), "decay_of_P": self.decay}
        if self.open_law:
            found |= {
                "lambda": self.popov,
                "multipliers": dict(zip(map(str, self.slopes), self.multipliers, strict=True)),
            }
        if self.order:
            found |= {"S": self.S, "R": self.R}
        return found


@dataclass(frozen=True)
class FormSearch:
    """What came of a search: a form that the check confirmed, and the check's margin, or the reason."""

    form: Form | None
    margin: float | None
    solver: str
    reason: NoCertificate | None = None
