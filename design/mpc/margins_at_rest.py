"""Margins of an MPC's loop at rest, on every branch of the hysteresis at both rates of the regulator.

Where no bound is active an MPC on a linear model is a linear law.  So the branch of the plant, a straight
line at one rate, is the model too, and a small pulse d is added to one command of the closed loop.  What
passes to the plant is then the pulse response of the sensitivity at the plant's input, sampled at the period,

    S(z) = 1 + sum_k v_k z^-k / d,        L = 1/S - 1,

(Astrom & Murray, Feedback Systems, 2008, section 11.1), whatever the controller remembers.  The delay margin
follows from the phase of the sampled loop: of a dead time that is no number of periods it is right to a share
of a period.
"""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Measured
from design.margins import delay_margins, least_of_rows
from design.mpc.problem import MPCProblem
from plants.effects.effect import dead_time_of
from plants.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from plants.linearisation import RATES, branch_matrices, branch_slopes
from plants.parameters.remainder import UncertaintyWeight
from plants.simulation.periodic import Periodic
from plants.wrist import Wrist

Array = NDArray[np.float64]

PULSE = 1e-3
"""Of a command [V]: far from bounds, and far above what a solver leaves."""

QUIET, PERIODS, LONGEST = 1e-5, 50, 1500
"""A response is over when so many periods stay below this share of the pulse; the most that is waited for."""

DIES = 0.05
"""Of the largest command that a pulse gives: where more is left after the longest wait, a loop does not come
to rest."""

POINTS = 2000
"""Frequencies that margins are read from."""


@runtime_checkable
class Replaceable(Periodic, Protocol):
    """An MPC that can be had of another problem, such as `design.mpc.formulations.linear.LinearMPC`."""

    def on(self, problem: MPCProblem) -> "Replaceable":
        """The same controller of another problem."""
        ...


@dataclass(frozen=True)
class MarginsAtRest:
    """Ms, Mt and delay margin [s], the worst over branches and rates; infinite, infinite and 0 where a loop
    does not come to rest.  WT: peak of |W T| with unmodelled dynamics of a weight W, None without."""

    Ms: float
    Mt: float
    delay_margin_s: float
    WT: float | None = None


def margins_at_rest(
    controller: Replaceable,
    plants: Sequence[Wrist],
    dead_times: Sequence[float] = (0.0,),
    weight: UncertaintyWeight | None = None,
) -> MarginsAtRest:
    """Margins of an MPC, the worst over plants and dead times [s] on top of what they have; of their other
    effects nothing is known here.  weight: of unmodelled dynamics.

    Its model stays its own, on the same branch at the same rate.  Raises InputError where its solver is not
    installed.
    """
    problem, found = controller.problem, {}
    for of in plants:
        bare, dt = replace(of, effects=()), of.rig.sample_time
        for branch, rate, more in product(branch_slopes(bare), RATES, dead_times):
            a, b = branch_matrices(bare, branch, rate)
            model = straight(problem.wrist, branch_slopes(problem.wrist)[branch], rate)
            late = round((more + dead_time_of(of.effects)) / dt)
            key = (np.round(np.hstack([a, b]), 12).tobytes(), branch, late)
            if key not in found:
                own = controller.on(replace(problem, wrist=model))
                response = np.array(list(pulse_response(own, a, b, late)))
                found[key] = _margins(response, problem.period, weight)
    loops = found.values()
    return MarginsAtRest(
        max(m.Ms for m in loops), max(m.Mt for m in loops), min(m.delay_margin_s for m in loops),
        None if weight is None else max(m.WT or 0.0 for m in loops),
    )  # fmt: skip


def straight(wrist: Wrist, slope: float, rate: str) -> Wrist:
    """A wrist without hysteresis: a straight line of a slope [deg/kPa], and one of the regulator's rates."""
    k = wrist.regulator.k_fast if rate == "fast" else wrist.regulator.k_slow
    line = PrandtlIshlinskii(slope, (0.0,), 1.0, rest_pressure=wrist.hysteresis.rest_pressure)
    return replace(wrist, hysteresis=line, regulator=replace(wrist.regulator, k_fast=k, k_slow=k))


def pulse_response(controller: Any, a: Array, b: Array, late: int = 0) -> Iterator[float]:
    """Commands of a controller of a straight wrist, as shares of a pulse that the first of them had added,
    by deviation from those that hold it; a, b: matrices of the plant from command [V] to pressure and angle,
    for one sample; late: samples by which commands arrive late."""
    problem = controller.problem
    law, gain = problem.wrist.hysteresis, float(problem.wrist.regulator.gain)
    # Far from the pressure at which a wrist at rest counts as never moved.
    near, span = law.rest_pressure / gain, problem.high - problem.low
    held = max((problem.low + x * span for x in (0.4, 0.6)), key=lambda v: abs(v - near))
    rest = np.array([gain * held, law.v0 * (gain * held - law.rest_pressure)])
    state = controller.init(Measured(0.0, rest[1], rest[0]))
    x, quiet, under_way = np.zeros(2), 0, deque([0.0] * late)
    for k in range(LONGEST):
        pressure, angle = rest + x
        state, command, _ = controller.step(state, Measured(rest[1] - angle, angle, pressure))
        pushed = command - held
        yield pushed / PULSE
        quiet = quiet + 1 if abs(pushed) < QUIET * PULSE else 0
        if quiet >= PERIODS:
            return
        for _ in range(problem.substeps):
            under_way.append(pushed + (PULSE if k == 0 else 0.0))
            x = a @ x + b[:, 0] * under_way.popleft()


def _margins(response: Array, period: float, weight: UncertaintyWeight | None = None) -> MarginsAtRest:
    size = np.abs(response)
    if size[-PERIODS:].max() > DIES * size.max():
        return MarginsAtRest(np.inf, np.inf, 0.0, None if weight is None else np.inf)
    omega = np.geomspace(1e-2, 0.999 * np.pi / period, POINTS)
    delays = np.exp(-1j * np.outer(omega * period, np.arange(response.size)))
    sensitivity = 1.0 + delays @ response
    loop = (1.0 / sensitivity - 1.0)[None]
    away = 1.0 / np.abs(1.0 - sensitivity[None])
    return MarginsAtRest(
        float(1.0 / least_of_rows(1.0 / np.abs(sensitivity[None]))[0]),
        float(1.0 / least_of_rows(away)[0]),
        float(delay_margins(omega, loop)[0]),
        None if weight is None else float(np.max(np.abs(weight.response(omega)) / away)),
    )
