"""Linear MPC behind the inverse of hysteresis and regulator, (a): the plan is made in static angle.

Behind the inverse the plant is taken to be linear,

    dh/dt = k (u - h),    da/dt = (h - a)/Tw,    u held for a period,

h the static angle, a the angle without the shift, u the static angle that the loop would go to if the
pressure went all the way to where the command points.  With u the QP has a constant Hessian.  What is
approximate:

- k is the regulator's fast rate, exact only far from the commanded pressure; the first move is then
  found by the regulator's own law (`follow`), so that the error is in the plan's later stages;
- the range of the command bounds u by the angles that the loop reaches from its present memory at the
  pressures of the range, and the rate limit bounds changes of u through the slope of the steeper line,
  so that the plan may still ask for more than the rate on a transit: the command is clipped to both.

The plan h_1, h_2, ... becomes commands by the inverse of the hysteresis law and the regulator's exact law.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Measured
from design.mpc import observer, qp
from design.mpc.fallback import Attempt, Fallback, Info, MPCState, begin, slow_pi, step
from design.mpc.formulations.static_angle import bounds, commands_kernel, feasible
from design.mpc.prediction import coefficients, start_of
from design.mpc.problem import Believed, MPCProblem

Array = NDArray[np.float64]


class Planner(NamedTuple):
    """What (a) needs, made once: free and forced response of the angle at the ends of the periods, (N, 2)
    and (N, N), and of the static angle; Hessian; solver."""

    problem: MPCProblem
    coefficients: Array
    free: Array
    forced: Array
    static_free: Array
    static_forced: Array
    weights: Array
    hessian: Array
    move: float
    rate: float
    solve: qp.Solve


def planner(problem: MPCProblem, c: Array) -> Planner:
    """The linear plan's matrices; c: `prediction.coefficients`."""
    from scipy.linalg import expm

    p, N, T = problem.wrist, problem.horizon, problem.period
    k = p.regulator.k_fast
    whole = expm(np.array([[-k, 0.0, k], [1.0 / p.Tw, -1.0 / p.Tw, 0.0], [0.0, 0.0, 0.0]]) * T)
    A, B = whole[:2, :2], whole[:2, 2]
    free, forced = np.empty((N, 2, 2)), np.zeros((N, 2, N))
    power, answer = np.eye(2), [B]
    for i in range(N):
        power = A @ power
        free[i] = power
        for j in range(i + 1):
            forced[i, :, j] = answer[i - j]
        answer.append(A @ answer[-1])
    # A change of the command by 1 V moves u by so many degrees, on a line.
    per_volt = float(max(p.hysteresis.steepness) * p.regulator.gain)
    move = problem.weights.move / per_volt**2
    weights, D = problem.angle_hessian, problem.differences
    J = forced[:, 1]
    hessian = np.ascontiguousarray(J.T @ weights @ J + move * (D.T @ D))
    return Planner(
        problem, c, np.ascontiguousarray(free[:, 1]), np.ascontiguousarray(J),
        np.ascontiguousarray(free[:, 0]), np.ascontiguousarray(forced[:, 0]), weights, hessian, move,
        problem.rate * per_volt, qp.solver(D),
    )  # fmt: skip


def plan(
    of: Planner,
    believed: Believed,
    command: float,
    reference: float,
    active: qp.Active,
    before: float | None = None,
) -> tuple[Array, qp.QPSolution]:
    """Static angles [deg] at the ends of the periods, shape (N,), and the QP's solution; `command` [V] is
    that of the period before, and `before` [deg] what u was then (that of the command where not given)."""
    N = of.problem.horizon
    memory, p = believed.plant.memory, of.problem
    rises = reference - believed.shift > memory.h
    least, most, was = map(
        float, bounds(believed.plant, believed.lack, (p.low, p.high, command), rises, p.wrist)
    )
    least, most, was = map(float, feasible(least, most, was if before is None else before, of.rate))
    x = np.array([memory.h, believed.plant.angle])
    missing = of.free @ x + (believed.shift - reference)
    f = (of.weights @ missing) @ of.forced
    f[0] -= of.move * was
    low = np.concatenate([np.full(N, least), np.full(N, -of.rate)])
    high = np.concatenate([np.full(N, most), np.full(N, of.rate)])
    low[N] += was
    high[N] += was
    solution = of.solve(of.hessian, f, low, high, active)
    return of.static_free @ x + of.static_forced @ solution.x, solution


def follow(of: Planner, believed: Believed, command: float, angles: Array) -> Array:
    """Commands [V] that take the static angle to `angles` [deg] at the ends of the periods, as far as the
    range and the rate let them; shape of angles."""
    commands, p = np.empty(len(angles)), of.problem
    push = believed.lack / p.wrist.regulator.gain
    commands_kernel(p.shape)(
        start_of(believed),
        angles,
        p.low,
        p.high,
        p.rate,
        command,
        push,
        of.coefficients,
        p.substeps,
        commands,
    )
    return commands


@dataclass(frozen=True)
class LinearMPC:
    """The controller (a): pure `init` and `step`.

    >>> from plants import Wrist
    >>> controller = linear_mpc(MPCProblem(Wrist.flexion()))
    >>> state = controller.init(Measured(0.0, 0.0, 100.0))
    >>> state, command, info = controller.step(state, Measured(15.0, 0.0, 100.0))
    >>> round(command, 3), info.rung
    (4.0, 'solved')
    """

    planner: Planner
    gains: observer.Gains
    fallback: Fallback

    @property
    def problem(self) -> MPCProblem:
        """What is solved."""
        return self.planner.problem

    @property
    def coefficients(self) -> Array:
        """Of the model, flat."""
        return self.planner.coefficients

    def on(self, problem: MPCProblem) -> "LinearMPC":
        """The same controller of another problem."""
        return linear_mpc(problem, self.fallback)

    def init(self, seen: Measured) -> MPCState:
        """The state in which it holds a wrist that is seen to rest."""
        return begin(self, seen)

    def step(self, state: MPCState, seen: Measured) -> tuple[MPCState, float, Info]:
        """State after, command [V] of, and record of, one period."""
        return step(self, state, seen)

    def attempt(self, state: MPCState, believed: Believed, reference: float) -> Attempt:
        """Solve; the plan is kept as static angles [deg] from the next period on, with u from this one on."""
        started = self.fallback.clock()
        before = None if state.plan is None else float(state.plan[1, 0])
        angles, found = plan(self.planner, believed, state.command, reference, state.active, before)
        took = self.fallback.clock() - started
        command = float(follow(self.planner, believed, state.command, angles[:1])[0])
        active = qp.shifted(found.active, self.problem.horizon)
        ahead = np.stack([np.concatenate([angles[1:], angles[-1:]]), found.x])
        return Attempt(command, ahead, active, found.found, found.reason, found.iterations, took)

    def resume(self, plan: Array, believed: Believed, command: float) -> tuple[float, Array]:
        """The command [V] to the first static angle of a plan, and the rest of the plan."""
        first = float(follow(self.planner, believed, command, plan[0, :1])[0])
        return first, np.concatenate([plan[:, 1:], plan[:, -1:]], axis=1)

    def prepare(self, state: MPCState) -> None:
        """Nothing: the Hessian is constant."""


def linear_mpc(problem: MPCProblem, fallback: Fallback | None = None) -> LinearMPC:
    """The linear MPC of a problem; raises InputError where daqp is not installed."""
    c = coefficients(problem.wrist)
    ladder = fallback or Fallback(pi=slow_pi(problem.wrist))
    return LinearMPC(planner(problem, c), observer.gains(problem), ladder)
