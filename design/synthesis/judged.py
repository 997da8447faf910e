"""What controllers of any family do on a problem, for a search among them."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
PENALTY = 20.0
"""Price of an excess over a limit in the local search: a share of the cost per share of the limit."""
ACTIVE = 0.01
"""A limit is active where the optimum comes this near to it, as a share of the limit."""


class Judged(Protocol):
    """What controllers do on a problem, of whatever kind they are."""

    @property
    def cost(self) -> Array:
        """Worst cost, (n,)."""
        ...

    @property
    def excess(self) -> dict[str, Array]:
        """How far each is beyond each limit, as a share of it, (n,)."""
        ...

    @property
    def worst_excess(self) -> Array:
        """Largest excess over all limits, (n,)."""
        ...


def active_limit(at: Judged) -> str | None:
    """The limit that the first gains run into, or None for an optimum inside all limits."""
    return nearest_limit(at, 0) if at.worst_excess[0] > -ACTIVE else None


def nearest_limit(at: Judged, index: int) -> str | None:
    """The limit that gains come nearest to, or violate most; None where there are no limits."""
    return max(at.excess, key=lambda name: at.excess[name][index], default=None)


def merit(at: Judged) -> Array:
    """Cost, with excess over the limits at a price, (n,); large but finite where the cost is infinite."""
    excess = np.nan_to_num(np.maximum(at.worst_excess, 0.0), posinf=1e3)
    return np.nan_to_num(at.cost, posinf=1e3) * (1.0 + PENALTY * excess)


@dataclass(frozen=True)
class JudgedDesign:
    """What controllers do on the cases of a problem: worst cost (n,), worst value of each limited quantity
    and of what else is judged, and by what share of its limit each is exceeded."""

    cost: Array
    values: dict[str, Array]
    excess: dict[str, Array]

    @property
    def worst_excess(self) -> Array:
        """Largest excess over all limits, (n,)."""
        worst: Array = np.max(list(self.excess.values()), axis=0)
        return worst

    def only(self, n: int) -> "JudgedDesign":
        """The n-th alone, arrays of length 1."""
        one = slice(n, n + 1)
        return JudgedDesign(
            self.cost[one],
            {k: v[one] for k, v in self.values.items()},
            {k: v[one] for k, v in self.excess.items()},
        )

    @property
    def merit(self) -> Array:
        """Cost, with excess over the limits at a price, (n,)."""
        return merit(self)
