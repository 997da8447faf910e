"""The exact sampled wrist over a horizon, with its derivatives, as machine code.

A period is 20 substeps of 1 ms of `plants.dynamics.step`.  Its derivatives by the state at the start of
the period and by the command are carried along with the substeps (forward sensitivities: CasADi
differentiates one substep, the chain rule is unrolled with it, for whatever the hysteresis law's memory makes
of it), then condensed: the angles at the ends
of the periods as a linear function of the commands and of the state at the start.  All of it is one
kernel that `plants.kernel` loads, some 600 substeps in a few tens of microseconds.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.mpc.problem import Believed, MPCProblem
from plants import dynamics
from plants.dynamics import QUIET
from plants.hysteresis import HysteresisLaw
from plants.kernel import pytrees as tree
from plants.kernel.graphs import graph, slopes
from plants.kernel.inlining import compiled, inlined, scalars, unpacked
from plants.wrist import State, Wrist

Array = NDArray[np.float64]


def example(shape: HysteresisLaw) -> Wrist:
    """A declared wrist whose law has a shape (`design.mpc.problem.MPCProblem.shape`)."""
    return replace(Wrist.flexion(), hysteresis=shape)


def variables(state: State) -> list[str]:
    """A variable for each leaf of a wrist's state, such as ``x_pressure``, ``x_h``, ``x_angle``."""
    return [f"x_{n.removeprefix('memory.').replace('.', '_')}" for n in tree.names(state)]


def unloaded(state: State, array: str = "start") -> list[str]:
    """Statements that read these variables from an array."""
    return unpacked(variables(state), array)


class Carried(NamedTuple):
    """Which derivatives of a state are carried along.

    rows: the leaves of the state that are differentiated (the virgin curve is left by a switch, which is
    not); by: what each row depends on in one substep, rows and, beyond them, the command (``len(rows)``);
    entries: (row, column) of all that are not always 0, columns being the same at the start of the period.
    """

    rows: list[int]
    by: list[list[int]]
    entries: list[tuple[int, int]]

    @classmethod
    def of(cls, model: Wrist) -> "Carried":
        """Of a declared wrist: the sparsity of one substep, and its powers until they grow no more."""
        state = model.rest()
        names, step = tree.names(state), graph(plain, state, ("command",), model.sampled())
        rows = [i for i, n in enumerate(names) if not (model.hysteresis.DEAD_ZONE and n == "memory.virgin")]
        n = len(rows)
        one = np.zeros((n + 1, n + 1), bool)
        one[:n, :n], one[:n, n] = _filled(step, 0)[np.ix_(rows, rows)], _filled(step, 1)[rows, 0]
        power = np.eye(n + 1, dtype=bool)
        while (more := power | (one @ power)).sum() > power.sum():
            power = more
        return cls(
            rows,
            [np.flatnonzero(one[i]).tolist() for i in range(n)],
            [(i, j) for i in range(n) for j in range(n + 1) if power[i, j]],
        )


@cache
def differentiated(shape: HysteresisLaw) -> list[int]:
    """`Carried.rows` of a wrist whose law has a shape."""
    return Carried.of(example(shape)).rows


def _filled(function: Any, argument: int) -> NDArray[np.bool_]:
    """Which entries of a Jacobian are not always 0."""
    sparsity = function.jac_sparsity(0, argument)
    found = np.zeros(sparsity.shape, bool)
    found[sparsity.row(), sparsity.get_col()] = True
    return found


def carried(
    state: State, s: tuple[Any, ...], command: Any, c: Any, along: Carried
) -> tuple[State, tuple[Any, ...]]:
    """One substep of the wrist at a command [V], and of its sensitivities `s`, on CasADi symbols.

    At a kink (a line just met) the derivative is that of the one side that CasADi takes.
    """
    after, before = dynamics.step(state, command[0], c), tree.leaves(state)
    moved = tree.leaves(after)
    by = slopes([moved[i] for i in along.rows], [*(before[i] for i in along.rows), command[0]])
    n, old = len(along.rows), dict(zip(along.entries, s, strict=True))

    def entry(i: int, j: int) -> Any:
        terms = [by[i, k] * old[k, j] for k in along.by[i] if (k, j) in old]
        if j == n and n in along.by[i]:
            terms.append(by[i, n])
        return sum(terms[1:], terms[0]) if terms else 0.0

    return after, tuple(entry(i, j) for i, j in along.entries)


_HORIZON = """\
def run(start, commands, c, substeps, weights, swing, moves, states, outputs, by_command, by_start, hessian):
    N = commands.shape[0]
    {coefficients}
    {start}
    # Derivatives of the differentiated states (rows) by the commands so far, and by themselves at the start
    # and a shift of all commands (last column); the angle is the last row.
    n = by_start.shape[1] - 1
    m = np.zeros((n, N))
    g = np.eye(n, n + 1)
    for k in range(N):
        u_command = commands[k]
        {seeds}
        for i in range(substeps):
            {body}
        for j in range(k):
            {past}
        {newest}
        for j in range(n + 1):
            {from_start}
        {shifted}
        {kept}
        outputs[k] = x_angle
        for j in range(n + 1):
            by_start[k, j] = g[n - 1, j]
        for j in range(k + 1):
            by_command[k, j] = m[n - 1, j]
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
def _horizon_kernel(shape: HysteresisLaw) -> Callable[..., None]:
    model = example(shape)
    c, state, along = model.sampled(), model.rest(), Carried.of(model)
    x, n = variables(state), len(along.rows)
    s = {(i, j): f"s_{i}_{j}" for i, j in along.entries}
    coefficients = scalars("c", c)
    body = inlined(
        partial(carried, along=along), [state, tuple(s.values()), ("command",), c],
        [x, list(s.values()), ["u_command"], coefficients], x + list(s.values()),
    )  # fmt: skip

    def product(array: str) -> list[str]:
        """A column of an array times the derivatives of a period."""
        rows = [" + ".join(f"{s[i, k]} * d{k}" for k in range(n) if (i, k) in s) for i in range(n)]
        return [f"d{i} = {array}[{i}, j]" for i in range(n)] + [
            f"{array}[{i}, j] = {r}" for i, r in enumerate(rows)
        ]

    by_command = [(i, s[i, n]) for i in range(n) if (i, n) in s]
    return compiled(
        "the wrist over a horizon, with derivatives", _HORIZON,
        coefficients=unpacked(coefficients, "c"), start=unloaded(state),
        seeds=[f"{name} = {float(i == j)}" for (i, j), name in s.items()], body=body, past=product("m"),
        newest=[f"m[{i}, k] = {name}" for i, name in by_command], from_start=product("g"),
        shifted=[f"g[{i}, n] += {name}" for i, name in by_command],
        kept=[f"states[k, {i}] = {name}" for i, name in enumerate(x)],
    )  # fmt: skip


def coefficients(model: Wrist) -> Array:
    """Coefficients of a declared wrist for one substep, flat."""
    return np.array(tree.leaves(model.sampled()), float)


class Linearised(NamedTuple):
    """A horizon about a plan: state that it starts from, commands [V] (N,), lack [kPa]; states
    (N, leaves of a state) at the ends of the periods, angles [deg] without the shift (N,); derivatives of the
    angles by the commands (N, N), and by the differentiated states at the start (`Carried.rows`) and a shift
    of all commands (N, rows + 1); half the Hessian of the cost (N, N).
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
    """The start of a horizon, flat: pressure [kPa], memory, angle [deg]."""
    return np.array(tree.leaves(believed.plant), float)


def linearise(
    problem: MPCProblem, c: Array, weights: Array, moves: Array, start: Array, lack: float, plan: Array
) -> Linearised:
    """The horizon about a plan [V], and what the cost's Hessian is there (Gauss-Newton).

    c: `coefficients`; weights, moves: `problem.stage_weights` and `problem.move_hessian`, made once.
    """
    N = len(plan)
    n = len(differentiated(problem.shape))
    made = Linearised(
        start, plan, lack, np.empty((N, len(start))), np.empty(N), np.empty((N, N)), np.empty((N, n + 1)),
        np.empty((N, N)),
    )  # fmt: skip
    pushed = plan + lack / problem.wrist.regulator.gain
    swing = problem.weights.swing
    _horizon_kernel(problem.shape)(start, pushed, c, problem.substeps, weights, swing, moves, *made[3:])
    return made


_ROLL = """\
def run(start, commands, c, substeps, states):
    {coefficients}
    {start}
    for k in range(commands.shape[0]):
        u_command = commands[k]
        for i in range(substeps):
            {body}
        {kept}
"""


def plain(state: State, command: Any, c: Any) -> State:
    """One substep of the wrist; command: a tuple of one [V]."""
    return dynamics.step(state, command[0], c, QUIET)


@cache
def _roll_kernel(shape: HysteresisLaw) -> Callable[..., None]:
    model = example(shape)
    c, state = model.sampled(), model.rest()
    x, coefficients = variables(state), scalars("c", c)
    body = inlined(plain, [state, ("command",), c], [x, ["u_command"], coefficients], x)
    return compiled(
        "the wrist over a horizon", _ROLL, coefficients=unpacked(coefficients, "c"), start=unloaded(state),
        body=body, kept=[f"states[k, {i}] = {name}" for i, name in enumerate(x)],
    )  # fmt: skip


def roll(problem: MPCProblem, c: Array, start: Array, lack: float, plan: Array) -> Array:
    """States (N, leaves) at the ends of the periods of a plan [V], as `start_of` flattens them."""
    states = np.empty((len(plan), len(start)))
    pushed = plan + lack / problem.wrist.regulator.gain
    _roll_kernel(problem.shape)(start, pushed, c, problem.substeps, states)
    return states
