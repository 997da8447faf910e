"""The linear MPC as C: observer, condensed QP, first move.

The QP's answer depends on four numbers alone, theta = (static angle h, angle a without the shift, shift - r,
u of the period before), and only its first move is used.  With A = (I, D) the matrix of the bounds,

    unconstrained    A u = T theta,        T = -A H^-1 F,      F theta = f,
    dual             A u = T theta - G lambda,     G = A H^-1 A',

so that T (2N, 4) and G (2N, 2N), computed here, are all that the target needs: what is solved there is a
least-distance problem in the multipliers (`design.export.active_set`).  The observer and the move that
follows the plan are graphs of the very laws of the plant; in Python the same is done by `design.mpc`,
whose compiled loops and daqp the test vector comes from.
"""

from collections.abc import Callable
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Measured
from design.export.fields import COMMAND, Quantity, described
from design.export.part import SEEN, Part, Seen
from design.mpc import linear, observer
from design.mpc.prediction import coefficients
from design.mpc.problem import Believed, MPCProblem
from plants import dynamics
from plants.dynamics import SampledWrist
from plants.kernel import pytrees as tree
from plants.kernel.graphs import baked, c_source, graph
from plants.wrist import State

Number = Any
Begin = Callable[[float, float], tuple[Any, float]]
Step = Callable[[Any, Seen], tuple[Any, float]]
Array = NDArray[np.float64]

LOST = (
    "the observer goes on, by its model where a measurement is lost, since the wrist goes on too; the output "
    "is that of the last good sample"
)


class MPCMemory(NamedTuple):
    """What the C remembers beside its last command: belief, u of the period before [deg], and whether there
    was one (1) or not (0)."""

    believed: Believed
    u: Number
    planned: Number


class LossyMeasurement(NamedTuple):
    """What is measured, and whether it is (1) or was lost (0)."""

    angle: Number
    pressure: Number
    angle_seen: Number
    pressure_seen: Number


def of_linear_mpc(name: str, title: str, problem: MPCProblem) -> Part:
    """The linear MPC of a problem.  Raises InputError where daqp, which the test vector needs, is missing."""
    c, g = problem.wrist.sampled(), observer.gains(problem)
    planner = linear.planner(problem, coefficients(problem.wrist))
    example, given = (
        MPCMemory(observer.begin(0.0, 100.0, problem.wrist), 0.0, 0.0),
        LossyMeasurement(0.0, 0.0, 1.0, 1.0),
    )

    def start(at: Any) -> Any:
        believed = observer.begin(at[1], at[0], problem.wrist)
        return MPCMemory(believed, 0.0, 0.0), within(at[0] / problem.wrist.regulator.gain, problem)

    def believe(b: Believed, command: Any, seen: LossyMeasurement, k: SampledWrist) -> Believed:
        return believed_after(b, command[0], seen, k, g)

    def target(m: MPCMemory, at: Any, k: SampledWrist) -> Any:
        return parameters(m, at[0], at[1], k, planner)

    def wanted(b: Believed, u: Any, k: SampledWrist) -> Any:
        return pressure_wanted(b, u[0], k, planner)

    def pressed(at: Any, k: SampledWrist) -> Any:
        return after_period(at[0], at[1], k, problem.substeps)[-1]

    code = c_source(
        f"{name}_law",
        baked(f"{name}_init_law", graph(start, (0.0, 0.0))),
        baked(f"{name}_believe_law", graph(believe, example.believed, (0.0,), given, c), c),
        baked(f"{name}_target_law", graph(target, example, (0.0, 0.0), c), c),
        baked(f"{name}_wanted_law", graph(wanted, example.believed, (0.0,), c), c),
        baked(f"{name}_press_law", graph(pressed, (0.0, 0.0), c), c),
    )
    state = (
        *described(example.believed),
        Quantity("wish", "deg", "static angle that the command of the period before points to"),
        Quantity("planned", "", "1 once there was a plan, 0 before"),
    )
    T, G = condensed(planner)
    settings = {
        **{n: float(v) for n, v in problem.wrist.values.items()}, "period": problem.period,
        "horizon": problem.horizon, **{f"weight {n}": v for n, v in vars(problem.weights).items()},
        **{f"observer {n}": v for n, v in vars(problem.observer).items()}, "low": problem.low,
        "high": problem.high, "rate": problem.rate,
    }  # fmt: skip
    begin, step = _python(problem, planner, g)
    constants = {
        "steps": problem.horizon, "rate": planner.rate, "lowest": problem.low, "highest": problem.high,
        "change": problem.rate, "gain": float(problem.wrist.regulator.gain),
        "lack": [f.name for f in state].index("lack"), "tables": {"T": T.tolist(), "G": G.tolist()},
    }  # fmt: skip
    return Part(
        name, title, problem.period, SEEN, state, COMMAND, problem.low, problem.high, settings, code,
        begin, step, problem.plausible, tolerance=1e-6, template="mpc.c.jinja", constants=constants,
        lost=LOST, takes_lost=True,
        notes=(
            f"The QP (horizon {problem.horizon}, range and rate of the command bounded) is solved by a dual "
            f"active-set method with a bound on its iterations; its matrices are about "
            f"{8 * (G.size + T.size) // 1000} kB of constants, and a step takes about "
            f"{8 * ((problem.horizon + 1) ** 2 + 8 * problem.horizon) // 1000 + 2} kB of stack. Where it "
            f"finds no answer the command is held and the return code is {name.upper()}_FAILED; the ladder "
            f"of fallbacks that Python has below that is the caller's.",
        ),
    )  # fmt: skip


def within(command: Number, problem: MPCProblem) -> Number:
    """A command [V] in the range."""
    return np.minimum(np.maximum(command, problem.low), problem.high)


def after_period(pressure: Number, command: Number, c: SampledWrist, substeps: int) -> list[Number]:
    """Pressures [kPa] at the start of a period and after each of its substeps."""
    path = [pressure]
    for _ in range(substeps):
        at = State(path[-1], None, 0.0)
        path.append(dynamics.press(at, command, c)[0])
    return path


def believed_after(
    b: Believed, command: Number, seen: LossyMeasurement, c: SampledWrist, g: observer.Gains
) -> Believed:
    """`design.mpc.observer.update`, made of NumPy ufuncs; command [V]."""
    gain = c.regulator.gain
    pushed = command + b.lack / gain
    path = after_period(b.plant.pressure, pushed, c, g.substeps)
    predicted = path[-1]
    missed = seen.pressure_seen * (seen.pressure - predicted)
    state = b.plant
    for i, pressure in enumerate(path[1:], 1):
        state = dynamics.bend(state, pressure + missed * (i / g.substeps), (), c)

    error = gain * pushed - b.plant.pressure
    large = np.abs(error) > 1e-6
    share = np.where(large, (predicted - b.plant.pressure) / np.where(large, error, 1.0), g.share_at_rest)
    believed = np.minimum(np.maximum(missed, -observer.MOST_MISSED), observer.MOST_MISSED)
    lack = b.lack + g.lack * believed * share / (share * share + observer.LEAST_SHARE**2)
    off = seen.angle_seen * (seen.angle - (state.angle + b.shift))
    shift = b.shift + g.shift * off
    # Where the angle is lost both the shift and the angle stay: off is 0, shift - b.shift too.
    angle = state.angle + g.angle * off - (shift - b.shift)
    return Believed(State(state.pressure, state.memory, angle), lack, shift)


def parameters(m: MPCMemory, command: Number, reference: Number, c: SampledWrist, of: linear.Planner) -> Any:
    """theta, and the bounds [deg] on u: what `design.mpc.linear.plan` hands to its solver."""
    b, problem = m.believed, of.problem
    h = b.plant.memory.h
    commands = problem.low, problem.high, command
    least, most, was = linear.bounds(b.plant, b.lack, commands, reference - b.shift > h, c)
    least, most, was = linear.feasible(least, most, np.where(m.planned > 0.5, m.u, was), of.rate)
    return (h, b.plant.angle, b.shift - reference, was), least, most


def pressure_wanted(b: Believed, u: Number, c: SampledWrist, of: linear.Planner) -> Number:
    """Pressure [kPa] that the first move u [deg] of a plan asks for at the end of the period."""
    h = b.plant.memory.h
    angle = of.static_free[0, 0] * h + of.static_free[0, 1] * b.plant.angle + of.static_forced[0, 0] * u
    return linear.pressure_for(b.plant, angle, c)


def condensed(of: linear.Planner) -> tuple[Array, Array]:
    """T (2N, 4) and G (2N, 2N); see the module."""
    from scipy.linalg import cho_factor, cho_solve

    N = of.problem.horizon
    A = np.vstack([np.eye(N), of.problem.differences])
    free = np.column_stack([of.free, np.ones(N)])  # of h, a, shift - reference
    F = np.column_stack([of.forced.T @ of.weights @ free, np.eye(N)[:, 0] * -of.move])
    solved = cho_solve(cho_factor(of.hessian), np.column_stack([F, A.T]))
    return -A @ solved[:, :4], A @ solved[:, 4:]


def _python(problem: MPCProblem, of: linear.Planner, g: observer.Gains) -> tuple[Begin, Step]:
    """The law in Python, by `design.mpc`, its output held where something is lost."""
    idle = np.zeros(2 * problem.horizon, dtype=np.int32)

    def begin(pressure: float, angle: float) -> tuple[Any, float]:
        believed = observer.begin(angle, pressure, problem.wrist)
        floats = tree.like(believed, [float(x) for x in tree.leaves(believed)])
        command = float(within(pressure / problem.wrist.regulator.gain, problem))
        return (floats, None, command), command

    def step(state: Any, seen: Seen) -> tuple[Any, float]:
        before, u, command = state
        measured = Measured(seen.reference - seen.angle, seen.angle, seen.pressure)
        believed = observer.update(before, command, measured, g, of.coefficients)
        if not all(isfinite(x) for x in seen):
            return (believed, u, command), command
        angles, found = linear.plan(of, believed, command, seen.reference, idle, u)
        if not found.found:
            return (believed, u, command), command
        wanted = float(linear.follow(of, believed, command, angles[:1])[0])
        moved = min(max(wanted, command - problem.rate), command + problem.rate)
        command = min(max(moved, problem.low), problem.high)
        return (believed, float(found.x[0]), command), command

    return begin, step
