"""A test's statistic and the law that it follows when only noise is left."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Evidence:
    """What a test found.

    statistic: large where noise alone would not be; law: distribution of the statistic for noise
    alone, with its arguments as scipy.stats has them; trials: how many such statistics this one is
    the largest of; power: mean square that the test accounts for beyond what noise would make,
    in the unit of the series tested, squared.
    """

    statistic: float
    law: Literal["f", "chi2", "gamma", "norm"]
    arguments: tuple[float, ...]
    trials: float
    power: float

    @property
    def p_value(self) -> float:
        """Probability that noise alone reaches the statistic; two-sided for a normal law."""
        from scipy import stats

        return min(1.0, self._trials * float(getattr(stats, self.law).sf(self.statistic, *self.arguments)))

    def bound(self, p: float) -> float:
        """What noise alone exceeds with a probability of at most p."""
        from scipy import stats

        return float(getattr(stats, self.law).isf(min(1.0, p / self._trials), *self.arguments))

    @property
    def _trials(self) -> float:
        return self.trials * (2.0 if self.law == "norm" else 1.0)


NOTHING = Evidence(0.0, "norm", (), 1.0, 0.0)
"""A test that could not be made."""
