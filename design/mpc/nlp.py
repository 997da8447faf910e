"""The MPC's problem as a nonlinear program for IPOPT: single shooting on the exact sampled step.

The unknowns are the commands alone.  The states follow from them by `plants.dynamics.step`, 20 substeps to a
period, the minimum and maximum of the hysteresis as they are: nothing is smoothed.  With the states as
unknowns too (multiple shooting) the memory, which tells whether the wrist has left the virgin curve,
would have to hold as an equation of a quantity that is 0 or 1.

The cost is continuous and smooth in pieces.  Within a period a line may be met in any of the substeps, and
from one to the next the gradient jumps by a little: IPOPT (Wachter & Biegler, Mathematical Programming
106 (2006) 25) takes the derivative of the piece that it is on, which is a descent direction nearly
everywhere, and need not be at a minimum where two pieces meet.  What it returns is to be judged by the
exact step.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.mpc.prediction import plain, start_of
from design.mpc.problem import Believed, MPCProblem
from plants.kernel import pytrees as tree
from plants.kernel.graphs import graph

Array = NDArray[np.float64]

_OPTIONS: dict[str, Any] = {
    "print_time": False,
    "error_on_fail": False,
    "ipopt": {"print_level": 0, "sb": "yes", "max_iter": 100, "tol": 1e-8},
}


class NLPSolution(NamedTuple):
    """Commands [V], shape (N,), within range and rate; what IPOPT says of them, and its iterations."""

    commands: Array
    status: str
    iterations: int


Converge = Callable[[Believed, Array, float, float], NLPSolution]
"""``(believed, plan, before, reference) -> NLPSolution``: from a plan [V] on, `before` [V] being the command
of the period before."""


def converger(problem: MPCProblem) -> Converge:
    """IPOPT for a problem, made once."""
    import casadi as ca

    N, n, gain = problem.horizon, problem.substeps, problem.wrist.regulator.gain
    wrist = problem.wrist
    leaves, c = len(tree.leaves(wrist.rest())), wrist.sampled()
    x, u = ca.SX.sym("x", leaves), ca.SX.sym("u")
    step = graph(plain, wrist.rest(), ("command",), c)
    substep = ca.Function("substep", [x, u], [step(x, u, ca.DM(tree.leaves(c)))])
    first, held = ca.MX.sym("first", leaves), ca.MX.sym("held")
    period = ca.Function("period", [first, held], [substep.mapaccum(n)(first, ca.repmat(held, 1, n))[:, -1]])

    v, start, around = ca.MX.sym("v", N), ca.MX.sym("start", leaves), ca.MX.sym("around", 3)
    before, aim, push = around[0], around[1], around[2]
    angles = period.mapaccum(N)(start, (v + push).T)[-1, :].T
    moves = v - ca.vertcat(before, v[:-1])
    cost = ca.sum1(ca.DM(problem.stage_weights) * (angles - aim) ** 2)
    cost += problem.weights.swing * ca.sumsqr(angles[1:] - angles[:-1])
    cost += problem.weights.move * ca.sumsqr(moves)
    solver = ca.nlpsol(
        "mpc", "ipopt", {"x": v, "f": cost, "g": moves, "p": ca.vertcat(start, around)}, _OPTIONS
    )

    def converge(believed: Believed, plan: Array, before: float, reference: float) -> NLPSolution:
        given = [*start_of(believed), before, reference - believed.shift, believed.lack / gain]
        found = solver(
            x0=plan, p=given, lbx=problem.low, ubx=problem.high, lbg=-problem.rate, ubg=problem.rate
        )
        stats = solver.stats()
        commands = within(problem, np.array(found["x"]).ravel(), before)
        return NLPSolution(commands, stats["return_status"], int(stats["iter_count"]))

    return converge


def within(problem: MPCProblem, plans: Array, before: float) -> Array:
    """Plans [V], shape (..., N), held to the rate and the range, command after command."""
    held = np.empty_like(plans)
    last = np.full_like(plans[..., 0], before)
    for k in range(held.shape[-1]):
        moved = np.clip(plans[..., k], last - problem.rate, last + problem.rate)
        held[..., k] = last = np.clip(moved, problem.low, problem.high)
    return held
