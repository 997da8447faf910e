"""The linear loop of a state feedback with its observer: poles on every branch, margins at the command.

Separation does not hold where the branch's slope differs from the observer's, so what is guaranteed of
the state feedback is checked here of the whole loop, with the law that is simulated: its matrices are
what `design.controllers.lqi.step` makes of unit vectors while nothing is clipped.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Measured
from design.controllers.lqi import LQI, LQIState, step
from design.controllers.pi import PI
from design.margins import BranchResponse, Margins, margins
from plants import tree
from plants.linear import RATES, branch_slopes, branch_ss, slope_factors
from plants.wrist import COMMAND_RANGE, SAMPLE_TIME, Wrist

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
MEMORY = 5
"""States of the controller that move while the reference rests: all of `LQIState` but the last."""

INTEGRATOR = PI(0.0, 1.0 / SAMPLE_TIME, gain=1.0)
"""A PI whose response is 1 / (z - 1), so that `design.margins` takes any loop as one beside it."""


def matrices(controller: LQI) -> tuple[Array, Array, Array, Array]:
    """The controller while it does not clip, reference 0: m+ = a m + b (y, P), command = c m + d (y, P).

    m are the first five of `LQIState`, y the angle [deg], P the pressure [kPa], command in V;
    shapes (5, 5), (5, 2), (5,), (2,).  All are deviations from an equilibrium.
    """
    free = controller.sampled()._replace(low=-np.inf, high=np.inf)
    one = np.eye(MEMORY + 2)
    memory = LQIState._make([*one[:MEMORY], np.zeros(MEMORY + 2)])
    angle, pressure = one[MEMORY:]
    after, command = step(memory, Measured(-angle, angle, pressure), free)
    rows = np.array(tree.leaves(after)[:MEMORY], float)
    given = np.asarray(command, float)
    return rows[:, :MEMORY], rows[:, MEMORY:], given[:MEMORY], given[MEMORY:]


def closed(wrist: Wrist, controller: LQI, branch: str, rate: str) -> Array:
    """The sampled loop of a declared wrist and its controller on one branch at one rate, shape (7, 7),
    in pressure [kPa], angle [deg] and the controller's memory."""
    plant = branch_ss(wrist, branch, rate)
    a, b, c, d = matrices(controller)
    seen = np.array([[0.0, 1.0], [1.0, 0.0]])  # (y, P) of the plant's (P, y)
    into = np.asarray(plant.B, float)
    return np.block([[plant.A + into @ (d[None] @ seen), into @ c[None]], [b @ seen, a]])


def worst_pole(wrist: Wrist, controller: LQI) -> tuple[float, str]:
    """Largest magnitude of a pole of the loop with its observer, over every branch and rate of a
    declared wrist, and where; below 1 where it is stable."""
    found = [
        (float(np.abs(np.linalg.eigvals(closed(wrist, controller, b, r))).max()), f"{b}, {r} regulator rate")
        for b, r in product(branch_slopes(wrist), RATES)
    ]
    return max(found)


def responses(controller: LQI, omega: Array) -> Complex:
    """Response of the controller, from angle [deg] and pressure [kPa] to the command [V], (2, n)."""
    a, b, c, d = matrices(controller)
    z = np.exp(1j * omega * SAMPLE_TIME)
    inner = np.linalg.solve(z[:, None, None] * np.eye(MEMORY) - a, np.broadcast_to(b, (z.size, *b.shape)))
    return np.asarray((c @ inner + d).T, complex)


def pressure_responses(wrist: Wrist, omega: Array) -> list[Complex]:
    """Responses of the pressure [kPa/V] that belong to `design.margins.branch_responses`, in its order."""
    z = np.exp(1j * omega * SAMPLE_TIME)
    p = wrist.regulator
    reach = (p.gain * COMMAND_RANGE[0], p.gain * COMMAND_RANGE[1])
    parts = [e.linear(wrist, z, SAMPLE_TIME, reach) for e in wrist.effects]
    speeds = list(dict.fromkeys(float(np.prod(x)) for x in product(*(x.rates for x in parts))))
    before = p.gain * np.prod([np.broadcast_to(x.command, z.shape) for x in parts], axis=0)
    found = []
    for branch in branch_slopes(wrist):
        sides = wrist.hysteresis.sides(branch)
        factors = {float(np.prod(x)) for x in product(*(slope_factors(x.slopes, sides) for x in parts))}
        for _, rate, speed in product({min(factors), max(factors)}, RATES, speeds):
            share = -np.expm1(-speed * (p.k_fast if rate == "fast" else p.k_slow) * SAMPLE_TIME)
            found.append(np.asarray(before * (share / (z - 1.0 + share)), complex))
    return found


@dataclass(frozen=True)
class Broken:
    """Loops broken at the command: response of the controller from angle [deg] to command [V], (n,), and
    the open loop on each branch, negative feedback, (branches, n)."""

    angle: Complex
    open: Complex

    @classmethod
    def at_command(cls, wrist: Wrist, controller: LQI, branches: Sequence[BranchResponse]) -> "Broken":
        """What comes back of a command by way of angle and pressure, with its sign turned."""
        omega = branches[0].omega
        angle, pressure = responses(controller, omega)
        of = zip(branches, pressure_responses(wrist, omega), strict=True)
        return cls(angle, np.array([-(angle * b.response + pressure * air) for b, air in of]))

    @property
    def noise_gain(self) -> float:
        """Largest gain [V/deg] from noise of the angle to the command, over all branches."""
        return float(np.abs(self.angle / (1.0 + self.open)).max())

    def margins(self, branches: Sequence[BranchResponse]) -> Margins:
        """The worst over the branches: Ms, and the delay that the command may suffer.

        Stability is Nyquist's criterion; the controller itself is stable but for its integrator, as long
        as Kq does not exceed the washout.
        """
        beside = np.exp(1j * branches[0].omega * SAMPLE_TIME) - 1.0
        found = zip(branches, self.open, strict=True)
        return margins([BranchResponse(b.branch, b.rate, b.omega, x * beside) for b, x in found], INTEGRATOR)
