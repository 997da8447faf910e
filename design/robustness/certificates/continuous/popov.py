"""Second rung: a quadratic form and Popov's integral of the regulator's law, slopes switching arbitrarily.

    V = x' P x + 2 lambda int_0^q psi,     psi = phi - k_low q  between 0 and kappa q,  lambda >= 0,

for every law phi(q) = k(q) q in the sector that does not change with time and has no memory; for each
slope, with a multiplier tau >= 0 of the sector (S-procedure),

    dV/dt + 2 alpha V + 2 tau psi (kappa q - psi) < 0     for all (x, psi) not 0.

One P and one lambda for all slopes, so the slope may change at any time.  The inequality is affine in
slope and tau, so the two extreme slopes answer for those between, tau in between too.

With a decay alpha > 0 the integral has to be bounded from above: int_0^q psi <= psi q where psi grows
with q, as it does for k(e) = k_slow + (k_fast - k_slow) e^2 / (e^2 + e0^2) with k_fast >= k_slow,
the slope of k(e) e lying between k_slow and k_fast + (k_fast - k_slow) / 8; without that,
<= kappa q^2 / 2, which the sector alone gives.  Since the integral is not negative,
{x' P x <= c} contains {V <= c}.

Source: S. Boyd and others, Linear Matrix Inequalities in System and Control Theory (SIAM, 1994),
doi:10.1137/1.9781611970777; H. K. Khalil, Nonlinear Systems (3rd ed.), section 7.1.2.
"""

import numpy as np
from numpy.typing import NDArray

from design.robustness.certificates.continuous.lmi import Inequality
from design.robustness.certificates.continuous.quadratic import transport
from design.robustness.certificates.continuous.signals import LoopSignals, rates, slopes
from design.robustness.loop_model import LoopModel

Array = NDArray[np.float64]

RUNG = "quadratic and Popov"


def monotone(model: LoopModel) -> bool:
    """Whether psi grows with q, so that int_0^q psi <= psi q."""
    return model.k_fast >= model.k_slow


def inequalities(signals: LoopSignals, decay: float) -> list[Inequality]:
    """dV/dt + 2 decay V < 0 within the sector, at the two extreme slopes; the law is open."""
    model = signals.model
    low, high = rates(model)
    q, psi = signals.q, signals.psi
    sector = (high - low) * twice(q, psi) - 2.0 * np.outer(psi, psi)
    found = []
    for slope in sorted(set(slopes(model))):
        rate = signals.rate(slope, low)
        integral = twice(psi, rate[2])
        integral += 2.0 * decay * (twice(psi, q) if monotone(model) else (high - low) * np.outer(q, q))
        shared = {"popov": integral, **transport(signals, decay)}
        found.append(Inequality(signals.state, rate + decay * signals.state, shared, sector))
    return found


def twice(a: Array, b: Array) -> Array:
    """The symmetric matrix of the quadratic form 2 (a x)(b x)."""
    return np.outer(a, b) + np.outer(b, a)
