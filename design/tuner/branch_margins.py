"""The margins of one pair of gains on each branch at each rate of the regulator, fast enough for a drag.

As `design.open_loops.by_python_control`, of which a drag would wait a tenth of a second.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from design.margins import BranchResponse, gain_crossings, margins

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BranchMargins:
    """Margins of the linear loop on a branch at a rate.

    Ms [1]; delay_margin_s [s]; phase_margin_deg [deg]; gain_margin [1], the factor that the loop gain may
    grow by.  The last three are infinite where the loop never crosses; of an unstable loop Ms is infinite
    and the delay margin zero, and the other two say nothing.
    """

    branch: str
    rate: str
    Ms: float
    delay_margin_s: float
    phase_margin_deg: float
    gain_margin: float

    @property
    def stable(self) -> bool:
        """Whether the loop is stable."""
        return bool(np.isfinite(self.Ms))


def branch_margins(branches: Sequence[BranchResponse], controller: PI) -> tuple[BranchMargins, ...]:
    """Margins of a PI with one pair of gains on each of the branches.

    >>> from design.margins import branch_responses
    >>> from plants import Wrist
    >>> rows = branch_margins(branch_responses(Wrist.flexion()), PI(1.2, 2.2))
    >>> rows[-1].branch, rows[-1].rate, round(rows[-1].Ms, 2)
    ('line2', 'fast', 1.07)
    """
    found = []
    for b in branches:
        z = np.exp(1j * b.omega * b.dt)
        c = (controller.Kp + controller.Ki * (b.dt / (z - 1.0))) / controller.gain
        loop = c * b.response
        _, _, beyond = gain_crossings(b.omega, loop[None])
        both = margins([b], controller)
        found.append(
            BranchMargins(
                b.branch,
                b.rate,
                float(both.Ms),
                float(both.delay_margin_s),
                float(np.degrees(beyond.min(initial=np.inf))),
                gain_margin(loop),
            )
        )
    return tuple(found)


def gain_margin(loop: NDArray[np.complex128]) -> float:
    """Least factor above one by which the gain of an open loop, (n,), may grow until it passes through -1;
    infinite where it never crosses the negative axis inside the unit circle.

    >>> s = 1j * np.geomspace(0.1, 10.0, 500)
    >>> round(gain_margin(2.0 / (s + 1.0) ** 3), 3)       # 8 at the edge of stability
    4.0
    """
    beyond = np.angle(-loop)  # from the negative real axis, so that a crossing changes its sign
    near = np.abs(beyond) < 0.5 * np.pi
    at = np.flatnonzero((beyond[:-1] * beyond[1:] <= 0.0) & near[:-1] & near[1:] & (beyond[:-1] != 0.0))
    share = beyond[at] / (beyond[at] - beyond[at + 1])
    size = np.log(np.maximum(np.abs(loop), 1e-300))  # zero on a transit without slope
    factors = np.exp(-(size[at] + share * (size[at + 1] - size[at])))
    return float(factors[factors > 1.0].min(initial=np.inf))
