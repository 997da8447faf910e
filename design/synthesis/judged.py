"""What controllers of any family do on a problem, for a search among them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from design.synthesis.tuning import merit

Array = NDArray[np.float64]


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
