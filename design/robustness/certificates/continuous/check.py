"""The last word on a Lyapunov function: every inequality rebuilt in plain NumPy, and its eigenvalues.

Nothing of what the solver was given is used: the inequalities come from the loop's equations and the
numbers of the form alone, by evaluating dV/dt + 2 alpha V at unit vectors and their sums.  Each is
scaled to a diagonal of -1, which changes no sign, so that its margin has no unit: the worst eigenvalue
as a share of the largest.
"""

from collections.abc import Callable

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from design.robustness.certificates.continuous.form import Form
from design.robustness.loop_model import LoopModel

Array = NDArray[np.float64]

CONFIRMED = 1e-9
"""Least margin that counts: a million times what rounding does to eigenvalues of this size."""

POINTS = 50
"""Random slopes and rates between the corners at which the inequalities are looked at as well."""


def positive(matrix: Array) -> float:
    """Margin of matrix > 0: its least eigenvalue as a share of the largest, at a diagonal of 1; -1
    where the diagonal is not positive, or not a number.

    >>> import numpy as np
    >>> float(round(positive(np.diag([1.0, 1e-6])), 6)), float(positive(np.diag([1.0, -1e-6])))
    (1.0, -1.0)
    """
    matrix = 0.5 * (matrix + matrix.T)
    diagonal = np.diag(matrix)
    if not np.isfinite(matrix).all() or not (diagonal > 0.0).all():
        return -1.0
    size = np.sqrt(diagonal)
    values = np.linalg.eigvalsh(matrix / np.outer(size, size))
    return float(values[0] / np.abs(values).max())


def negative(matrix: Array) -> float:
    """Margin of matrix < 0, see `positive`."""
    return positive(-matrix)


def margin(form: Form, model: LoopModel, dead_time: float, seed: int = 0) -> float:
    """Worst margin over all inequalities that make a form a Lyapunov function of a loop.

    dead_time [s]: beside the loop's own.  Negative where one is broken, which includes a form made
    for another number of moments, and numbers that have to be positive and are not.
    """
    tau = model.dead_time + dead_time
    if (form.order > 0) != (tau > 0.0) or min(form.S, form.R, form.popov, *form.multipliers, 0.0) < 0.0:
        return -1.0
    if form.order and form.R / tau < 2.0 * form.decay * (form.S + form.R):
        return -1.0  # Bessel's inequality would point the wrong way
    low, high = sorted((model.k_slow, model.k_fast))
    shallow, steep = min(model.slopes.values()), max(model.slopes.values())
    if form.open_law and not (form.slopes and form.slopes[0] <= shallow and steep <= form.slopes[-1]):
        return -1.0
    random = np.random.default_rng(seed)
    between = shallow + (steep - shallow) * random.random(POINTS)
    if form.open_law:
        points = [(s, low) for s in (*model.slopes.values(), *between)]
    else:
        points = [(s, k) for s in model.slopes.values() for k in (low, high)]
        points += list(zip(between, low + (high - low) * random.random(POINTS), strict=True))
    size = len(form.P) + int(form.order > 0) + int(form.open_law)
    shares = [positive(form.below)]
    for slope, rate in points:
        shares.append(negative(_matrix(_fall(form, model, tau, slope, rate), size)))
    return min(shares)


def _matrix(fall: Callable[[Array], Array], size: int) -> Array:
    """The symmetric matrix of a quadratic form that is known by its values, one per column."""
    eye = np.eye(size)
    first, second = np.repeat(eye, size, axis=1), np.tile(eye, size)
    found: Array = 0.25 * (fall(first + second) - fall(first - second)).reshape(size, size)
    return found


def _fall(form: Form, model: LoopModel, tau: float, slope: float, rate: float) -> Callable[[Array], Array]:
    """dV/dt + 2 decay V at most, and the sector's share of it, as a function of the columns
    (X, z arriving, psi)."""
    low, high = sorted((model.k_slow, model.k_fast))
    multiplier = float(np.interp(slope, form.slopes, form.multipliers)) if form.open_law else 0.0

    def fall(v: Array) -> Array:
        X, x0, x1, q = v[: len(form.P)], v[0], v[1], v[2]
        Z = X[3:]
        psi = v[-1] if form.open_law else np.zeros_like(q)
        sent = model.Ki * x0 - model.Kp * x1 / model.Tw
        arriving = v[len(form.P)] if form.order else sent
        phi = rate * q + psi
        dq = arriving - phi
        dX = [-x1 / model.Tw, -x1 / model.Tw + slope * phi, dq, *_moved(Z, sent, arriving, tau)]
        total = 2.0 * np.sum(X * (form.P @ np.array(dX)), axis=0)
        total += 2.0 * form.decay * np.sum(X * (form.P @ X), axis=0)
        total += 2.0 * form.popov * psi * dq + 2.0 * multiplier * psi * ((high - low) * q - psi)
        integral = psi * q if model.k_slow <= model.k_fast else (high - low) * q * q / 2.0
        total += 4.0 * form.decay * form.popov * integral
        if form.order:
            bessel = np.sum((2.0 * np.arange(form.order)[:, None] + 1.0) * Z * Z, axis=0)
            total += ((form.S + form.R) * sent**2 - form.S * arriving**2 - form.R * bessel) / tau
            total += 2.0 * form.decay * (form.S + form.R) * bessel
        found: Array = total
        return found

    return fall


def _moved(Z: Array, sent: Array, arriving: Array, tau: float) -> list[Array]:
    """d/dt of the moments of what is on its way, by partial integration."""
    found = []
    for k in range(len(Z)):
        # Derivative of the k-th polynomial in polynomials, by numpy's own; twice for [0, 1].
        inner = 2.0 * legendre.legder(np.eye(k + 1)[k]) if k else np.zeros(0)
        found.append(((-1.0) ** k * sent - arriving + inner @ Z[: len(inner)]) / tau)
    return found
