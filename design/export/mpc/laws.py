"""What the exported MPCs have in common: observer, linear plan and regulator as graphs, made of the very laws
of the plant.  In Python the same is done by `design.mpc`, whose compiled loops and daqp the test vectors come
from.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.export.fields import COMMAND, Quantity
from design.export.mpc.ladder import Ladder, in_python
from design.export.part import SEEN, Part
from design.mpc import observer
from design.mpc.fallback import Fallback, Planning
from design.mpc.formulations import linear, static_angle
from design.mpc.prediction import plain
from design.mpc.problem import Believed, MPCProblem
from plants import dynamics
from plants.actuator import regulator
from plants.dynamics import SampledWrist
from plants.kernel import pytrees as tree
from plants.kernel.graphs import baked, graph
from plants.wrist import State

Number = Any
Array = NDArray[np.float64]


class LossyMeasurement(NamedTuple):
    """What is measured, and whether it is (1) or was lost (0)."""

    angle: Number
    pressure: Number
    angle_seen: Number
    pressure_seen: Number


ACCURATE = 2.5e-7
"""Share of the command's range by which a plan in C may be from Python's: two solvers end at their own
rounding."""


def lost(ladder: Fallback) -> str:
    """What happens where a measurement is not believed."""
    return (
        "the observer goes on, by its model where a measurement is lost, since the wrist goes on too, and a "
        "reference that is lost stays what it was; where angle or pressure is lost, the command is that of "
        f"the last plan for up to {ladder.patience} periods in a row, then that of a PI on the angle, which "
        "begins without a jump, and without an angle or a reference the command is held"
    )


class PlanInput(NamedTuple):
    """Command [V] of the period before, reference [deg], u of the period before [deg], and whether there was
    a plan then (1) or not (0)."""

    command: Number
    reference: Number
    u: Number
    planned: Number


def laws(name: str, problem: MPCProblem, of: linear.Planner, g: observer.Gains) -> list[Any]:
    """The graphs of both, NAME_LAW_law each, the coefficients of the wrist in them as constants:

    believe: what is believed one period later, of that before, the command [V] and a `LossyMeasurement`;
    target: of that and `PlanInput`, theta = (h, a, shift - r, u before) and the bounds on u;
    ahead: h and a [deg] one period later, of (h, a, u);
    wanted: the pressure [kPa], of the state of a wrist, at which its static angle will be h [deg];
    press: the pressure after a period, of that before and the command [V].
    """
    c = problem.wrist.sampled()
    belief, nothing = observer.begin(0.0, 100.0, problem.wrist), (0.0,)

    def believe(b: Believed, command: Any, seen: LossyMeasurement, k: SampledWrist) -> Believed:
        return believed_after(b, command[0], seen, k, g)

    def target(b: Believed, asked: PlanInput, k: SampledWrist) -> Any:
        return parameters(b, asked, k, of)

    def ahead(at: Any) -> Any:
        h, a, u = at
        rows = (of.static_free[0], of.static_forced[0, 0]), (of.free[0], of.forced[0, 0])
        return tuple(free[0] * h + free[1] * a + forced * u for free, forced in rows)

    def wanted(state: State, h: Any, k: SampledWrist) -> Any:
        return static_angle.pressure_for(state, h[0], k)

    def press(at: Any, k: SampledWrist) -> Any:
        return after_period(at[0], at[1], k, problem.substeps)[-1]

    seen, asked = LossyMeasurement(0.0, 0.0, 1.0, 1.0), PlanInput(0.0, 0.0, 0.0, 0.0)
    return [
        baked(f"{name}_believe_law", graph(believe, belief, nothing, seen, c), c),
        baked(f"{name}_target_law", graph(target, belief, asked, c), c),
        baked(f"{name}_ahead_law", graph(ahead, (0.0, 0.0, 0.0))),
        baked(f"{name}_wanted_law", graph(wanted, belief.plant, nothing, c), c),
        baked(f"{name}_press_law", graph(press, (0.0, 0.0), c), c),
    ]


def play(name: str, problem: MPCProblem) -> Any:
    """The graph of the wrist, of its state a substep before and the command [V]."""
    c = problem.wrist.sampled()
    plant = observer.begin(0.0, 100.0, problem.wrist).plant
    return baked(f"{name}_play_law", graph(plain, plant, (0.0,), c), c)


def part(
    name: str,
    title: str,
    controller: Planning,
    state: tuple[Quantity, ...],
    code: str,
    template: str,
    constants: Mapping[str, Any],
    note: str,
) -> Part:
    """An MPC as a part of C: what it remembers, the code of its graphs, the template of the source and what
    that needs."""
    problem, (begin, step) = controller.problem, in_python(controller)
    return Part(
        name, title, problem.period, SEEN, state, COMMAND, problem.low, problem.high, settings(problem), code,
        begin, step, problem.plausible, tolerance=ACCURATE * (problem.high - problem.low),
        template=template, constants=constants,
        lost=lost(controller.fallback), takes_lost=True, notes=(note, *late(problem)),
        under_way=problem.delay,
    )  # fmt: skip


def late(problem: MPCProblem) -> tuple[str, ...]:
    """What is to be said of a dead time in the model."""
    if not problem.delay:
        return ()
    return (
        f"Its model takes commands to arrive {problem.delay} periods late, "
        f"{problem.delay * problem.period:g} s: the commands under way are kept, the observer is told of the "
        "one that acts, and the plan begins where the model stands once they have acted.",
    )


def settings(problem: MPCProblem) -> Mapping[str, float]:
    """The settings of a problem by name."""
    return {
        **{n: float(v) for n, v in problem.wrist.values.items()}, "period": problem.period,
        "horizon": problem.horizon, **{f"weight {n}": v for n, v in vars(problem.weights).items()},
        **{f"observer {n}": v for n, v in vars(problem.observer).items()}, "low": problem.low,
        "high": problem.high, "rate": problem.rate, "delay": float(problem.delay),
    }  # fmt: skip


def constants(problem: MPCProblem, of: linear.Planner, ladder: Fallback) -> Mapping[str, Any]:
    """What the templates of both need, where the leaves of the belief come first in the state, those of the
    ladder next."""
    belief = observer.begin(0.0, 100.0, problem.wrist)
    names = tree.names(belief)
    return {
        "steps": problem.horizon, "rate": of.rate, "lowest": problem.low, "highest": problem.high,
        "change": problem.rate, "gain": float(problem.wrist.regulator.gain),
        "believed_leaves": len(names), "plant_leaves": len(tree.leaves(belief.plant)),
        "lack": names.index("lack"), "substeps": problem.substeps, "ladder": Ladder._fields,
        "patience": float(ladder.patience),
    }  # fmt: skip


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

    # The share of an error that a period takes: the quotient in Python would be of two small differences of
    # pressures, of which single precision leaves nothing.
    left: Number = 1.0
    for pressure in path[:-1]:
        left = left * (1.0 - regulator.share(gain * pushed - pressure, c.regulator))
    share = 1.0 - left
    believed = np.minimum(np.maximum(missed, -observer.MOST_MISSED), observer.MOST_MISSED)
    lack = b.lack + g.lack * believed * share / (share * share + observer.LEAST_SHARE**2)
    off = seen.angle_seen * (seen.angle - (state.angle + b.shift))
    shift = b.shift + g.shift * off
    # Where the angle is lost both the shift and the angle stay: off is 0, shift - b.shift too.
    angle = state.angle + g.angle * off - (shift - b.shift)
    return Believed(State(state.pressure, state.memory, angle), lack, shift)


def parameters(b: Believed, asked: PlanInput, c: SampledWrist, of: linear.Planner) -> Any:
    """theta, and the bounds [deg] on u: what `design.mpc.formulations.linear.plan` hands to its solver."""
    problem, h = of.problem, b.plant.memory.h
    commands = problem.low, problem.high, asked.command
    least, most, was = static_angle.bounds(b.plant, b.lack, commands, asked.reference - b.shift > h, c)
    least, most, was = static_angle.feasible(
        least, most, np.where(asked.planned > 0.5, asked.u, was), of.rate
    )
    return (h, b.plant.angle, b.shift - asked.reference, was), least, most


def without_bounds(of: linear.Planner) -> Array:
    """X (N, 4), with X theta the answer without bounds to the linear plan's QP: -H^-1 F, F theta = f."""
    from scipy.linalg import cho_factor, cho_solve

    N = of.problem.horizon
    free = np.column_stack([of.free, np.ones(N)])  # of h, a, shift - reference
    F = np.column_stack([of.forced.T @ of.weights @ free, np.eye(N)[:, 0] * -of.move])
    return np.asarray(-cho_solve(cho_factor(of.hessian), F), float)
