"""The exact sampled wrist over a horizon, with its derivatives, as machine code.

A period is 20 substeps of 1 ms of `plants.wrist.step`.  Its derivatives by the state at the start of
the period and by the command are carried along with the substeps (forward sensitivities: CasADi
differentiates one substep, the chain rule is unrolled with it), then condensed: the angles at the ends
of the periods as a linear function of the commands and of the state at the start.  All of it is one
kernel that `plants.kernel` loads, some 600 substeps in a few tens of microseconds.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.mpc.problem import Believed, Problem
from plants import tree, wrist
from plants.kernel.inlining import compiled, inlined, scalars, unpacked
from plants.wrist import QUIET, State, Wrist

Array = NDArray[np.float64]

STATES = ("pressure", "h", "virgin", "angle")
CARRIED = ("PP", "Pv", "hP", "hh", "hv", "yP", "yh", "yy", "yv")
"""Derivatives that are not always 0: of pressure, static angle and angle (first letter) by pressure,
static angle, angle at the start of the period, and command (second letter)."""


class Sensitivities(NamedTuple):
    """Derivatives of a state by the state at the start of the period and by the command; see `CARRIED`."""

    PP: Any
    Pv: Any
    hP: Any
    hh: Any
    hv: Any
    yP: Any
    yh: Any
    yy: Any
    yv: Any


def carried(state: State, s: Sensitivities, command: Any, c: Any) -> tuple[State, Sensitivities]:
    """One substep of the wrist at a command [V], and of its sensitivities, on CasADi symbols.

    At a kink (a line just met) the derivative is that of the one side that CasADi takes.
    """
    import casadi

    after = wrist.step(state, command[0], c)
    values = casadi.vertcat(after.pressure, after.memory.h, after.angle)
    by = casadi.jacobian(values, casadi.vertcat(state.pressure, state.memory.h, state.angle, command[0]))
    P, h, y, v = range(4)
    return after, Sensitivities(
        by[0, P] * s.PP,
        by[0, P] * s.Pv + by[0, v],
        by[1, P] * s.PP + by[1, h] * s.hP,
        by[1, h] * s.hh,
        by[1, P] * s.Pv + by[1, h] * s.hv + by[1, v],
        by[2, P] * s.PP + by[2, h] * s.hP + by[2, y] * s.yP,
        by[2, h] * s.hh + by[2, y] * s.yh,
        by[2, y] * s.yy,
        by[2, P] * s.Pv + by[2, h] * s.hv + by[2, y] * s.yv + by[2, v],
    )


_HORIZON = """\
def run(start, commands, c, substeps, weights, swing, moves, states, outputs, by_command, by_start, hessian):
    N = commands.shape[0]
    {coefficients}
    {state} = start[0], start[1], start[2], start[3]
    m = np.zeros((3, N))
    g = np.zeros((3, 4))
    g[0, 0] = g[1, 1] = g[2, 2] = 1.0
    for k in range(N):
        u_command = commands[k]
        {seeds} = 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0
        for i in range(substeps):
            {body}
        for j in range(k):
            P, h, y = m[0, j], m[1, j], m[2, j]
            m[0, j] = s_PP * P
            m[1, j] = s_hP * P + s_hh * h
            m[2, j] = s_yP * P + s_yh * h + s_yy * y
        m[0, k], m[1, k], m[2, k] = s_Pv, s_hv, s_yv
        for j in range(4):
            P, h, y = g[0, j], g[1, j], g[2, j]
            g[0, j] = s_PP * P
            g[1, j] = s_hP * P + s_hh * h
            g[2, j] = s_yP * P + s_yh * h + s_yy * y
        g[0, 3] += s_Pv
        g[1, 3] += s_hv
        g[2, 3] += s_yv
        states[k, 0], states[k, 1], states[k, 2], states[k, 3] = {state}
        outputs[k] = x_angle
        for j in range(4):
            by_start[k, j] = g[2, j]
        for j in range(k + 1):
            by_command[k, j] = m[2, j]
        for j in range(k + 1, N):
            by_command[k, j] = 0.0
    for i in range(N):
        for j in range(i + 1):
            hessian[i, j] = moves[i, j]
    for k in range(N):
        before = k - 1 if k > 0 else 0
        for i in range(k + 1):
            t = swing * (by_command[k, i] - by_command[before, i]) if k > 0 else 0.0
            w = weights[k] * by_command[k, i] + t
            for j in range(i + 1):
                hessian[i, j] += w * by_command[k, j] - t * by_command[before, j]
    for i in range(N):
        for j in range(i):
            hessian[j, i] = hessian[i, j]
"""


@cache
def _horizon_kernel() -> Callable[..., None]:
    example = Wrist.flexion()
    c, state = example.sampled(), example.rest()
    x, s = [f"x_{n}" for n in STATES], [f"s_{n}" for n in CARRIED]
    coefficients = scalars("c", c)
    body = inlined(
        carried, [state, Sensitivities(*CARRIED), ("command",), c], [x, s, ["u_command"], coefficients], x + s
    )
    return compiled(
        "the wrist over a horizon, with derivatives", _HORIZON,
        coefficients=unpacked(coefficients, "c"), state=x, seeds=s, body=body,
    )  # fmt: skip


def coefficients(model: Wrist) -> Array:
    """Coefficients of a declared wrist for one substep, flat."""
    return np.array(tree.leaves(model.sampled()), float)


class Linearised(NamedTuple):
    """A horizon about a plan: state that it starts from, commands [V] (N,), lack [kPa]; states (N, 4) at
    the ends of the periods, angles [deg] without the shift (N,); derivatives of the angles by the
    commands (N, N) and by pressure, static angle, angle and command at the start (N, 4); half the Hessian
    of the cost (N, N).
    """

    start: Array
    commands: Array
    lack: float
    states: Array
    angles: Array
    by_command: Array
    by_start: Array
    hessian: Array


def start_of(believed: Believed) -> Array:
    """The start of a horizon, flat: pressure [kPa], static angle [deg], virgin, angle [deg]."""
    return np.array(tree.leaves(believed.plant), float)


def linearise(
    problem: Problem, c: Array, weights: Array, moves: Array, start: Array, lack: float, plan: Array
) -> Linearised:
    """The horizon about a plan [V], and what the cost's Hessian is there (Gauss-Newton).

    c: `coefficients`; weights, moves: `problem.stage_weights` and `problem.move_hessian`, made once.
    """
    N = len(plan)
    made = Linearised(
        start, plan, lack, np.empty((N, 4)), np.empty(N), np.empty((N, N)), np.empty((N, 4)), np.empty((N, N))
    )
    pushed = plan + lack / problem.wrist.regulator.gain
    swing = problem.weights.swing
    _horizon_kernel()(start, pushed, c, problem.substeps, weights, swing, moves, *made[3:])
    return made


_ROLL = """\
def run(start, commands, c, substeps, states):
    {coefficients}
    {state} = start[0], start[1], start[2], start[3]
    for k in range(commands.shape[0]):
        u_command = commands[k]
        for i in range(substeps):
            {body}
        states[k, 0], states[k, 1], states[k, 2], states[k, 3] = {state}
"""


def plain(state: State, command: Any, c: Any) -> State:
    """One substep of the wrist; command: a tuple of one [V]."""
    return wrist.step(state, command[0], c, QUIET)


@cache
def _roll_kernel() -> Callable[..., None]:
    example = Wrist.flexion()
    c, state = example.sampled(), example.rest()
    x = [f"x_{n}" for n in STATES]
    coefficients = scalars("c", c)
    body = inlined(plain, [state, ("command",), c], [x, ["u_command"], coefficients], x)
    return compiled(
        "the wrist over a horizon", _ROLL, coefficients=unpacked(coefficients, "c"), state=x, body=body
    )


def roll(problem: Problem, c: Array, start: Array, lack: float, plan: Array) -> Array:
    """States (N, 4) at the ends of the periods of a plan [V], as `start_of` flattens them."""
    states = np.empty((len(plan), 4))
    pushed = plan + lack / problem.wrist.regulator.gain
    _roll_kernel()(start, pushed, c, problem.substeps, states)
    return states
