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

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Measured
from design.mpc import observer, qp
from design.mpc.fallback import Attempt, Fallback, Info, MPCState, begin, slow_pi, step
from design.mpc.prediction import coefficients, example, plain, start_of, unloaded, variables
from design.mpc.problem import Believed, MPCProblem
from plants import dynamics
from plants.hysteresis import HysteresisLaw
from plants.kernel.inlining import compiled, inlined, scalars, unpacked
from plants.wrist import State

Array = NDArray[np.float64]

STILL = 0.01
"""Change of the static angle [deg] in a period below which a wrist on the virgin curve is left alone:
any more would send it through its dead zone."""

_LOOP = """\
def run(start, angles, lowest, highest, rate, before, push, c, substeps, commands):
    {coefficients}
    {start}
    for k in range(angles.shape[0]):
        u_angle = angles[k]
        {inverse}
        low, high = max(lowest, before - rate), min(highest, before + rate)
        # Illinois variant of false position: the pressure after a period rises with the command.
        pressure = x_pressure
        below, above, value = 0.0, 0.0, high
        for j in range(30):
            if j == 0:
                value = low
            elif j == 1:
                value = high
            else:
                value = (low * above - high * below) / (above - below)
            u_command = value + push
            x_pressure = pressure
            for i in range(substeps):
                {press}
            missed = x_pressure - wanted
            x_pressure = pressure
            if j == 0:
                below, side = missed, 0
                if missed >= 0.0:
                    break
            elif j == 1:
                above = missed
                if missed <= 0.0:
                    break
            elif abs(missed) < 1e-9:
                break
            elif missed < 0.0:
                low, below = value, missed
                if side == -1:
                    above *= 0.5
                side = -1
            else:
                high, above = value, missed
                if side == 1:
                    below *= 0.5
                side = 1
        commands[k] = before = value
        u_command = value + push
        for i in range(substeps):
            {body}
"""


def pressure_for(state: State, angle: Any, c: Any) -> Any:
    """Pressure [kPa] at which the loop has an angle [deg]; on a virgin curve it is left alone for a small
    move."""
    loop, memory = c.hysteresis, state.memory
    if loop.DEAD_ZONE:
        still = np.where(memory.virgin > 0.5, 1.0, 0.0) * np.where(np.abs(angle - memory.h) < STILL, 1.0, 0.0)
        angle = np.where(still > 0.5, memory.h, angle)
    return loop.pressure_for(memory, state.pressure, angle)


def bounds(
    state: State, lack: Any, commands: tuple[Any, Any, Any], rises: Any, c: Any
) -> tuple[Any, Any, Any]:
    """Static angles [deg] that bound u, and that of the command before; commands [V]: lowest, highest and
    the one before; rises: whether the reference is above the static angle.

    Against the way to the reference the angle moves less, along the slope just after a reversal.
    """
    loop, gain, memory, P = c.hysteresis, c.regulator.gain, state.memory, state.pressure
    slope = loop.first_slope(memory)

    def turned(v: Any) -> Any:
        return memory.h + slope * (gain * v + lack - P)

    low, high, _ = commands
    least, most, was = (loop.step(memory, P, gain * v + lack).h for v in commands)
    return (
        np.where(rises, np.maximum(least, turned(low)), least),
        np.where(rises, most, np.minimum(most, turned(high))),
        was,
    )


def feasible(least: Any, most: Any, was: Any, rate: Any) -> tuple[Any, Any, Any]:
    """Bounds on u [deg], and u of the period before, from which one move by `rate` at most leads within them:
    so that there is a plan whatever was measured.

    >>> [float(x) for x in feasible(-5.0, 5.0, 30.0, 10.0)]
    [-5.0, 5.0, 15.0]
    """
    most = np.maximum(least, most)
    return least, most, np.minimum(np.maximum(was, least - rate), most + rate)


def _inverse(state: State, angle: Any, c: Any) -> Any:
    return pressure_for(state, angle[0], c)


def _press(state: State, command: Any, c: Any) -> Any:
    return dynamics.press(state, command[0], c)[0]


@cache
def _kernel(shape: HysteresisLaw) -> Callable[..., None]:
    model = example(shape)
    c, state = model.sampled(), model.rest()
    x = variables(state)
    names = scalars("c", c)
    command: Any = (state, ("command",), c)
    parts = {
        "inverse": inlined(_inverse, [*command], [x, ["u_angle"], names], ["wanted"]),
        "press": inlined(_press, [*command], [x, ["u_command"], names], ["x_pressure"]),
        "body": inlined(plain, [*command], [x, ["u_command"], names], x),
    }
    return compiled(
        "commands that follow static angles", _LOOP, coefficients=unpacked(names, "c"),
        start=unloaded(state), **parts,
    )  # fmt: skip


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
    _kernel(p.shape)(
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
