"""Functions that fall along the loop: what a solver hands over and the check looks at.

Of the states and the moments of what is under way, w = (e, d, q; O), with Popov's integral:

    V = w'P w + dt sum_i (S + R (N + 1 - i) dt) (exp(-decay dt i) u[k - i])^2 + 2 popov int_0^q psi,

O and u as in `loop`.  One such function for every slope proves that the loop decays however the slope
switches; `LineForm` knows how far the wrist is from the line that it left, and where it will meet it again.
Passivity, Lyapunov functions and Popov's term were put together for hystereses by Paré, Hassibi & How,
A KYP lemma and invariance principle for systems with multiple hysteresis non-linearities, Int. J. Control 74
(2001) 1140-1157.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.reasons import NoCertificate

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WindowForm:
    """P (n, n), n - 3 moments; popov, S, R: not negative."""

    P: Array
    popov: float
    S: float = 0.0
    R: float = 0.0

    @property
    def record(self) -> dict[str, Any]:
        """The form for JSON."""
        late = {"S": self.S, "R": self.R} if len(self.P) > 3 else {}
        return {"P": self.P.tolist(), "lambda": self.popov, **late}


@dataclass(frozen=True)
class CommonForm:
    """One function for slopes [deg/kPa] that change at every sample; multipliers of the law's sector, one a
    slope; decay [1/s]."""

    form: WindowForm
    slopes: tuple[float, ...]
    multipliers: tuple[float, ...]
    decay: float

    @property
    def record(self) -> dict[str, Any]:
        """The form for JSON."""
        by_slope = dict(zip(map(str, self.slopes), self.multipliers, strict=True))
        return {**self.form.record, "multipliers": by_slope, "decay_of_P": self.decay}


@dataclass(frozen=True)
class LineForm:
    """A function for one line and the transit beside it; outer, inner: ends of their slopes [deg/kPa].

    On the line, and where the transit leaves it: `line`.  F [kPa] away from it: the larger of
    `line` + 2 F cross'w - gap F^2 and of `transit`; cross (n,), gap not negative.  multipliers: of the law's
    sector on the line, leaving it, and far from it; decay [1/s].
    """

    line: WindowForm
    transit: WindowForm
    cross: Array
    gap: float
    inner: tuple[float, ...]
    outer: tuple[float, ...]
    multipliers: tuple[float, float, float]
    decay: float

    @property
    def record(self) -> dict[str, Any]:
        """The form for JSON."""
        return {
            "line": self.line.record, "transit": self.transit.record, "cross": self.cross.tolist(),
            "gap": self.gap, "slopes": [list(self.inner), list(self.outer)],
            "multipliers": list(self.multipliers), "decay_of_P": self.decay,
        }  # fmt: skip


@dataclass(frozen=True)
class MemorySearch:
    """What came of a search: a form that the check confirmed, and the check's margin, or the reason."""

    form: Any
    margin: float | None
    solver: str
    reason: NoCertificate | None = None
