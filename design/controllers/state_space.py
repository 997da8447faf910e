"""A controller as a linear system: its law differentiated where it holds still, in state space.

Nothing is declared: the derivatives are those of the very law that is simulated (`plants.kernel.graphs`).
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Controller, Measured
from plants.kernel import pytrees
from plants.kernel.graphs import derivatives, evaluated
from plants.wrist import SAMPLE_TIME

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class StateSpace:
    """m+ = a m + b (y, P), command = c m + d (y, P), of a controller under a reference that rests.

    m: what it remembers and measurements move, n numbers; y the angle [deg], P the pressure [kPa], command
    in V, all as deviations from an equilibrium; shapes (n, n), (n, 2), (n,), (2,); dt: sample time [s].
    """

    a: Array
    b: Array
    c: Array
    d: Array
    dt: float = SAMPLE_TIME

    def responses(self, omega: Array) -> Complex:
        """Frequency response at omega [rad/s], from angle and pressure to the command, (2, n)."""
        z = np.exp(1j * omega * self.dt)
        inner = z[:, None, None] * np.eye(len(self.a)) - self.a
        driven = np.linalg.solve(inner, np.broadcast_to(self.b, (z.size, *self.b.shape)))
        return np.asarray((self.c @ driven + self.d).T, complex)


def _law(state: Any, seen: tuple[Any, Any], c: Any) -> tuple[Any, Any]:
    angle, pressure = seen
    return c.act(state, Measured(-angle, angle, pressure))  # type: ignore[no-any-return]


@cache
def _derivatives(state: Any, c: Any, types: str) -> Any:
    """Of a law, by the names of its trees: what is slow, and the same for all settings."""
    return derivatives(_law, state, ("angle", "pressure"), c)


def linearised(controller: Controller, dt: float = SAMPLE_TIME) -> StateSpace:
    """The state space of a controller of floats about the middle of its range, where nothing is clipped;
    sample time dt [s].

    >>> from design.controllers.pi import PI
    >>> law = linearised(PI(Kp=2.0, Ki=5.0, gain=50.0))
    >>> law.a.tolist(), law.b.round(6).tolist(), law.c.tolist(), law.d.tolist()
    ([[1.0]], [[-0.005, 0.0]], [0.02], [-0.04, 0.0])
    """
    pressure = float(0.5 * (controller.low + controller.high) * controller.gain)
    state, c = controller.holding(pressure, Measured(0.0, 0.0, pressure)), controller.sampled(dt)
    names = [pytrees.like(t, pytrees.names(t)) for t in (state, c)]
    # Trees that differ in their types alone are equal; their representations are not.
    by_state, by_seen, _ = evaluated(_derivatives(*names, repr(names)), state, (0.0, pressure), c)
    a, b, c_row, d_row = by_state[:-1], by_seen[:-1], by_state[-1], by_seen[-1]
    moved = _moved(a, b)
    return StateSpace(a[np.ix_(moved, moved)], b[moved], c_row[moved], d_row, dt)


def _moved(a: Array, b: Array) -> NDArray[np.intp]:
    """Places of the states that inputs move, at once or by way of others."""
    found = (b != 0.0).any(axis=1)
    for _ in range(len(a)):
        found = found | (a[:, found] != 0.0).any(axis=1)
    return np.flatnonzero(found)
