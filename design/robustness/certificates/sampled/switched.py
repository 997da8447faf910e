"""Switched linear systems under arbitrary switching.

A system is a list of generators M_i and a sample time: x+ = x + dt M_i x, or dx/dt = M_i x where dt
is 0, and whoever switches may choose i anew at every moment.  Written so, a loop sampled fast is as
well conditioned as its continuous limit, which x+ = A_i x with A_i near the identity is not.  What is
proved of the M_i holds for every matrix of their convex hull, chosen anew at every moment too.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Switched:
    """x+ = x + dt M_i x, or dx/dt = M_i x where dt is 0; generators M_i of shape (n, n).

    degree: of the forms that these matrices act on (`lifted`), 1 for the system itself; ties: symmetric
    matrices L with z' L z = 0 for every state z that can occur, which an inequality may use.
    """

    generators: tuple[Array, ...]
    dt: float = 0.0
    degree: int = 1
    ties: tuple[Array, ...] = ()

    @property
    def fates(self) -> Array:
        """Loss of each mode on its own, shape (modes,): no V can lose faster than the least of them."""
        values = [np.linalg.eigvals(m) for m in self.generators]
        # |1 + dt s|^2 = 1 + dt (2 Re s + dt |s|^2)
        return np.array([-np.max(2.0 * v.real + self.dt * np.abs(v) ** 2) for v in values])

    def rate(self, loss: float) -> float:
        """Rate [1 / unit of time] at which x decays where V loses `loss`; negative where it grows."""
        twice = loss if self.dt == 0.0 else -np.log1p(-min(loss * self.dt, 1.0 - 1e-300)) / self.dt
        return float(twice) / (2.0 * self.degree)


def discrete(matrices: list[Array], dt: float = 1.0) -> Switched:
    """The system x+ = A_i x, one step a sample time dt [s].

    >>> discrete([0.5 * np.eye(2)]).fates
    array([0.75])
    """
    return Switched(tuple((np.asarray(a, float) - np.eye(len(a))) / dt for a in matrices), dt)


def continuous(matrices: list[Array]) -> Switched:
    """The system dx/dt = A_i x."""
    return Switched(tuple(np.asarray(a, float) for a in matrices))


def scaled(system: Switched) -> tuple[Switched, Array]:
    """The system in states in which its mean mode loses length evenly, and T, x = T times such a state.

    T comes from the Lyapunov equation of the mean generator, moved to the left until it is stable.
    """
    from scipy.linalg import matrix_balance, solve_continuous_lyapunov

    mean = np.mean(system.generators, axis=0)
    balanced, diagonal = matrix_balance(mean, permute=False)
    moved = np.max(np.linalg.eigvals(mean).real) + 0.1 * np.linalg.norm(balanced, 2) + 1e-12
    stable = balanced - moved * np.eye(len(mean))
    p = solve_continuous_lyapunov(stable.T, -max(abs(moved), 1e-12) * np.eye(len(mean)))
    back = diagonal @ np.linalg.inv(np.linalg.cholesky((p + p.T) / 2.0)).T
    return replace(system, generators=tuple(np.linalg.solve(back, m @ back) for m in system.generators)), back
