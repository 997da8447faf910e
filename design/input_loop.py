"""The loop at the plant's input: poles on every branch and margins at the command, of any controller.

The controller is its law linearised (`design.controllers.state_space`), with its observer and whatever it
measures beside the angle.  Separation does not hold where a branch's slope differs from the observer's,
so what is guaranteed of a state feedback is checked here of the whole loop.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Controller
from design.controllers.pi import PI
from design.controllers.state_space import linearised
from design.margins import BranchResponse, Margins, branch_responses, margins
from design.open_loops import by_python_control
from plants.linearisation import RATES, branch_slopes, branch_ss
from plants.wrist import Wrist

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
POINTS = 1500
"""Frequencies that margins are read from."""


def closed(wrist: Wrist, controller: Controller, branch: str, rate: str) -> Array:
    """The sampled loop of a declared wrist and its controller on one branch at one rate, shape (n, n),
    in pressure [kPa], angle [deg] and what the controller remembers."""
    plant = branch_ss(wrist, branch, rate)
    law = linearised(controller, wrist.rig.sample_time)
    seen = np.array([[0.0, 1.0], [1.0, 0.0]])  # (y, P) of the plant's (P, y)
    into = np.asarray(plant.B, float)
    return np.block([[plant.A + into @ (law.d[None] @ seen), into @ law.c[None]], [law.b @ seen, law.a]])


def worst_pole(wrist: Wrist, controller: Controller) -> tuple[float, str]:
    """Largest magnitude of a pole of the loop, over every branch and rate of a
    declared wrist, and where; below 1 where it is stable."""
    found = [
        (float(np.abs(np.linalg.eigvals(closed(wrist, controller, b, r))).max()), f"{b}, {r} regulator rate")
        for b, r in product(branch_slopes(wrist), RATES)
    ]
    return max(found)


@dataclass(frozen=True)
class InputLoop:
    """Open loops, broken at the command: response of the controller from angle [deg] to command [V], (n,),
    and the open loop on each branch, negative feedback, (branches, n)."""

    angle: Complex
    open: Complex

    @classmethod
    def at_command(cls, controller: Controller, branches: Sequence[BranchResponse]) -> "InputLoop":
        """What comes back of a command by way of angle and pressure, with its sign turned."""
        of = branches[0]
        angle, pressure = linearised(controller, of.dt).responses(of.omega)
        return cls(angle, np.array([-(angle * b.response + pressure * b.pressure) for b in branches]))

    @property
    def noise_gain(self) -> float:
        """Largest gain [V/deg] from noise of the angle to the command, over all branches."""
        return float(np.abs(self.angle / (1.0 + self.open)).max())

    def margins(self, branches: Sequence[BranchResponse]) -> Margins:
        """The worst over the branches: Ms, and the delay that the command may suffer.

        Stability is Nyquist's criterion, for a controller that is stable itself but for one integrator (an
        LQI is, as long as Kq does not exceed its washout).
        """
        # A PI whose response is 1 / (z - 1), so that `design.margins` takes any loop as one beside it.
        dt = branches[0].dt
        integrator, beside = PI(0.0, 1.0 / dt, gain=1.0), np.exp(1j * branches[0].omega * dt) - 1.0
        found = zip(branches, self.open, strict=True)
        return margins(
            [replace(b, response=x * beside, a=None, b=None) for b, x in found],
            integrator,
        )


def command_margins(wrist: Wrist, controller: Any) -> tuple[float, float]:
    """Ms and delay margin [s] at the command, the worst over branches and rates.

    Of a controller that says which PI closes its loop (`pi`), those of python-control; of another, of its law
    linearised; not a number for one that has no law to linearise.  Of MPCs see `design.mpc.margins_at_rest`.
    """
    pi = getattr(controller, "pi", None)
    if pi is not None:
        rows = by_python_control(wrist, pi)
        return max(r["Ms"] for r in rows), min(r["delay_margin_s"] for r in rows)
    if not hasattr(controller, "sampled"):
        return float("nan"), float("nan")
    branches = branch_responses(wrist, POINTS)
    found = InputLoop.at_command(controller, branches).margins(branches)
    return float(found.Ms), float(found.delay_margin_s)
