"""The step of the linear loop on one branch, from its frequency response."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import sici

from design.controllers.pi import PI
from design.open_loops import OpenLoopTransfer

Array = NDArray[np.float64]


def branch_step(loop: OpenLoopTransfer, controller: PI, omega: Array, time: Array) -> Array:
    """Response of the angle to a unit step of the reference, at times [s], of a stable loop.

    By the inverse Fourier transform of a causal response, y(t) = 2/pi int Re T(j w) sin(w t) / w dw, T the
    transfer from reference to angle, over frequencies [rad/s] from where T is that of rest to where it is
    nothing; it takes a dead time and every effect as it is.  The weight of the reference and the filter of a
    PI with two degrees of freedom stand outside of the loop.

    >>> from design.open_loops import open_loops
    >>> from plants import Wrist
    >>> gains = PI(2.0, 6.0)
    >>> loop = open_loops(Wrist.flexion(), gains)[3]
    >>> loop.branch, loop.rate
    ('line1', 'fast')
    >>> y = branch_step(loop, gains, np.geomspace(1e-2, 2000.0, 4000), np.array([0.1, 10.0]))
    >>> y.round(2).tolist()
    [0.13, 1.0]
    """
    L, s = loop.at(omega), 1j * omega
    weight, filtered = float(getattr(controller, "b", 1.0)), float(getattr(controller, "Tf", 0.0))
    from_reference = (weight * controller.Kp * s + controller.Ki) / (controller.Kp * s + controller.Ki)
    T = L * (1.0 + filtered * s) * from_reference / (1.0 + L)
    # Between two frequencies Re T is their mean, and sin(w t) / w is integrated exactly.
    middle = 0.5 * (T.real[1:] + T.real[:-1])
    below = sici(np.outer(time, omega))[0]
    return np.asarray(2.0 / np.pi * (T.real[0] * below[:, 0] + np.diff(below, axis=1) @ middle), float)
