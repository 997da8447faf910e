"""First rung: one quadratic form that falls along every linear loop of a list, so under any switching.

P > 0 with A' P + P A + 2 alpha P < 0 for every A: then x' P x falls by exp(-2 alpha t) at least,
however A is chosen among them, or among their weighted means, at each time.  dx/dt = a x +
b(slope) rate q is affine in the slope at a fixed rate and in the rate at a fixed slope, so the four
corners of {slopes} x {rates} answer for all pairs between them; a slope between the steepest and the
shallowest is such a pair.

Source: S. Boyd, L. El Ghaoui, E. Feron, V. Balakrishnan, Linear Matrix Inequalities in System and
Control Theory (SIAM, 1994), doi:10.1137/1.9781611970777.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.certificate import Certificate
from design.robustness.certificates.continuous.check import CONFIRMED, negative, positive
from design.robustness.certificates.continuous.lmi import Inequality, unknowns, widest
from design.robustness.certificates.continuous.signals import LoopSignals, rates, slopes
from design.robustness.certificates.reasons import NoneOfThisKind, NoSolver
from design.robustness.loop_model import LoopModel
from design.synthesis import convex

Array = NDArray[np.float64]

RUNG = "common quadratic"


def common_quadratic(matrices: Sequence[Array], decay: float = 0.0) -> Certificate:
    """A common quadratic Lyapunov function of dx/dt = A x, A switching arbitrarily among matrices (n, n).

    `shape` is P, None where none was found; `decay` the rate [1/s] that was asked for.

    >>> import numpy as np
    >>> common_quadratic([np.diag([-1.0, -2.0]), np.diag([-3.0, -1.0])], decay=0.9).holds
    True
    """
    from scipy.linalg import matrix_balance

    _, (scale, _) = matrix_balance(sum(np.abs(a) for a in matrices), permute=False, separate=True)
    eye = np.eye(len(scale))
    try:
        found = widest(unknowns([Inequality(eye, a + decay * eye) for a in matrices], scale))
    except convex.Unsolved as said:
        return Certificate(RUNG, None, 0.0, False, None, None, "", NoSolver(str(said)))
    P = found.P
    shares = [positive(P), *(negative(a.T @ P + P @ a + 2.0 * decay * P) for a in matrices)]
    worst = min(shares)
    if worst <= CONFIRMED:
        reason = NoneOfThisKind(found.solver, worst)
        return Certificate(RUNG, None, 0.0, False, None, None, found.solver, reason)
    return Certificate(RUNG, None, 0.0, True, decay, worst, found.solver, shape=P)


def inequalities(signals: LoopSignals, decay: float) -> list[Inequality]:
    """dV/dt + 2 decay V < 0 at the corners of {slopes} x {rates}; the law is not open."""
    model: LoopModel = signals.model
    shared = transport(signals, decay)
    return [
        Inequality(signals.state, signals.rate(s, k) + decay * signals.state, shared)
        for s in sorted(set(slopes(model)))
        for k in sorted(set(rates(model)))
    ]


def transport(signals: LoopSignals, decay: float) -> dict[str, Array]:
    """What S and R add to dV/dt + 2 decay V, by Bessel's inequality at most; none without dead time.

    d/dt int (S + (1 - s) R) z^2 = ((S + R) z_sent^2 - S z_arriving^2 - R int z^2) / tau; the decay
    adds 2 decay (S + R) int z^2 at most, which R / tau has to pay for (see `paid`).
    """
    if not signals.order:
        return {}
    out, back = np.outer(signals.sent, signals.sent), np.outer(signals.arriving, signals.arriving)
    tau, moments = signals.dead_time, signals.moments
    return {
        "S": (out - back) / tau + 2.0 * decay * moments,
        "R": out / tau - (1.0 / tau - 2.0 * decay) * moments,
    }


def paid(signals: LoopSignals, decay: float) -> list[dict[str, float]]:
    """Sums of S and R that must not be negative for `transport` to be a bound."""
    if not signals.order:
        return []
    return [{"R": 1.0 / signals.dead_time - 2.0 * decay, "S": -2.0 * decay}]
