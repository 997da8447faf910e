"""The loop's signals as rows over one vector, so that V and dV/dt are quadratic forms in that vector.

The vector holds the states x of `design.robustness.loop_model`, with a dead time tau the moments

    Z_k = int_0^1 z(t - tau s) L_k(s) ds,    L_k Legendre's polynomials on [0, 1], k < order,

of z = Ki x0 - (Kp/Tw) x1, the only signal that is late (dq/dt = z(t - tau) - phi), and z(t - tau)
itself; last, where the law of the regulator is left open, psi = phi(q) - k_low q, the part of
phi(q) = k(q) q that is not linear, which lies between 0 and kappa q.

Source: the moments of A. Seuret, F. Gouaisbaut, Hierarchy of LMI conditions for the stability analysis of
time-delay systems, Systems & Control Letters 81 (2015) 1-7, for a transport as in L. Baudouin, A. Seuret,
M. Safi, Stability analysis of a system coupled to a transport equation using integral inequalities, 2nd
IFAC workshop on control of systems governed by partial differential equations, 2016, HAL hal-01310306.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from design.robustness.loop_model import LoopModel

Array = NDArray[np.float64]

ORDER = 3
"""Moments of what is on its way; with three the delay margin of a linear loop is met to a thousandth."""


def total_dead_time(model: LoopModel, dead_time: float) -> float:
    """Dead time [s] of the loop: the plant's own, and `dead_time` beside it."""
    return model.dead_time + dead_time


def rates(model: LoopModel) -> tuple[float, float]:
    """Least and largest rate [1/s] of the regulator."""
    return min(model.k_slow, model.k_fast), max(model.k_slow, model.k_fast)


def slopes(model: LoopModel) -> tuple[float, float]:
    """Least and largest slope [deg/kPa] of the branches."""
    return min(model.slopes.values()), max(model.slopes.values())


@dataclass(frozen=True)
class LoopSignals:
    """Rows over the vector of one loop; `open_law`: psi is part of it."""

    model: LoopModel
    dead_time: float
    order: int
    open_law: bool

    @classmethod
    def of(cls, model: LoopModel, dead_time: float, open_law: bool, order: int = ORDER) -> "LoopSignals":
        """The signals of a loop with `dead_time` [s] beside its own; without any there are no moments."""
        tau = total_dead_time(model, dead_time)
        return cls(model, tau, order if tau > 0.0 else 0, open_law)

    @property
    def states(self) -> int:
        """Number of states: three, and the moments."""
        return 3 + self.order

    @property
    def size(self) -> int:
        """Length of the vector."""
        return self.states + int(self.order > 0) + int(self.open_law)

    @property
    def eye(self) -> Array:
        """Each entry as a row."""
        found: Array = np.eye(self.size)
        return found

    @property
    def state(self) -> Array:
        """The states, (states, size)."""
        found: Array = self.eye[: self.states]
        return found

    @property
    def q(self) -> Array:
        """gain v - P [kPa]."""
        found: Array = self.eye[2]
        return found

    @property
    def psi(self) -> Array:
        """What k(q) q is above k_low q [kPa/s]; 0 where the law is not open."""
        return self.eye[-1] if self.open_law else np.zeros(self.size)

    @property
    def sent(self) -> Array:
        """z as it sets out [kPa/s]."""
        m = self.model
        found: Array = m.Ki * self.eye[0] - m.Kp / m.Tw * self.eye[1]
        return found

    @property
    def arriving(self) -> Array:
        """z as it arrives [kPa/s]: the same without dead time."""
        return self.eye[self.states] if self.order else self.sent

    def rate(self, slope: float, k: float) -> Array:
        """d/dt of the states where phi = k q + psi, (states, size)."""
        T = self.model.Tw
        phi = k * self.q + self.psi
        x1 = self.eye[1]
        rows = [-x1 / T, -x1 / T + slope * phi, self.arriving - phi]
        for n in range(self.order):
            row = (-1.0) ** n * self.sent - self.arriving
            for j in range(n - 1, -1, -2):  # L_n' = sum of 2 (2 j + 1) L_j, n - j odd
                row = row + 2.0 * (2 * j + 1) * self.eye[3 + j]
            rows.append(row / self.dead_time)
        return np.array(rows)

    @property
    def moments(self) -> Array:
        """Bessel's lower bound of int z^2 as a quadratic form: the sum of (2 k + 1) Z_k^2."""
        weights = np.zeros(self.size)
        weights[3 : self.states] = 2.0 * np.arange(self.order) + 1.0
        return np.diag(weights)

    @property
    def scale(self) -> Array:
        """Sizes of the entries of the vector where those of x balance the loop's matrices; (size,)."""
        from scipy.linalg import matrix_balance

        m = self.model
        total = sum(np.abs(m.matrix(s, k)) for s in slopes(m) for k in rates(m))
        _, (of_x, _) = matrix_balance(total, permute=False, separate=True)
        low, high = rates(m)
        z = max(float(np.abs(self.sent[:3]) @ of_x), 1e-9)
        late = [z] * (self.size - 3 - int(self.open_law))
        law = [max(high - low, 1e-9) * float(of_x[2])] * int(self.open_law)
        return np.concatenate([of_x, late, law])
