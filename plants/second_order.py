"""Transient of second order: inertia^2 y'' + lag y' + y = u, exact over a sample."""

from typing import Any

import numpy as np

Number = Any

NULL = 1e-6
"""Inertia [s] that stands for none: its second pole is gone within a nanosecond."""


def second_order_hold(inertia: Number, lag: Number, dt: float) -> tuple[Number, ...]:
    """Coefficients of the exact solution over a sample of dt [s] for an input that moves linearly.

    The response of y to its initial values and to a ramp, from the two poles
    (complex arithmetic, so that ringing needs no case of its own; equal poles
    are moved apart by a millionth).
    """
    m, d = np.maximum(np.asarray(inertia, float), NULL) ** 2, np.asarray(lag, float)
    root = np.sqrt((d * d - 4.0 * m).astype(complex))
    root = np.where(np.abs(root) < 1e-6 * d, 1e-6 * d, root)
    p, q = -2.0 / (d + root), (-d - root) / (2.0 * m)  # slow and fast; no digits lost at small m
    ep, eq = np.exp(p * dt), np.exp(q * dt)
    # Free response to (y, v): y = A e^pt + B e^qt.
    yy, yv = (p * eq - q * ep) / (p - q), (ep - eq) / (p - q)
    vy, vv = p * q * (eq - ep) / (p - q), (p * ep - q * eq) / (p - q)
    # Forced by h = before + slope t: y = h - Tw slope + free response to (-before + Tw slope, -slope).
    share = 1.0 / dt
    y_slope = dt - d + yy * d - yv  # per unit of slope
    v_slope = 1.0 + vy * d - vv
    ya, va = y_slope * share, v_slope * share
    yb, vb = 1.0 - yy - ya, -vy - va
    return tuple(np.real(x) for x in (yy, yv, yb, ya, vy, vv, vb, va))
