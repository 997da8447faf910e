"""Observer of the MPC: hysteresis memory from the measured pressure, and two constant disturbances.

The pressure is measured, and with it the memory of the loop is known (a play operator that is driven by
the measured pressure), since angle and pressure at rest tell where it starts.  Within a period the pressure
is taken to run as the regulator's model says, bent so that it ends where it was measured.  What the model
then misses is put down to

    lack  [kPa]  added to the commanded pressure, so that pressure = gain v + lack at rest
    shift [deg]  added to the static angle, such as a load, or loop parameters that are wrong

one disturbance for each of the two measurements, which is what it takes for the angle to come to rest at
the reference whatever constant disturbance there is (Pannocchia & Rawlings, AIChE Journal 49 (2003) 426,
doi 10.1002/aic.690490213; Muske & Badgwell, J. Process Control 12 (2002) 617).  Angle and shift have
both poles of their error at exp(-bandwidth period); the lack follows by normalised least mean squares,
since how much the pressure tells of it varies with the regulator's rate.
"""

from collections.abc import Callable
from functools import cache
from math import exp, isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Measured
from design.controllers.double_pole import double_pole
from design.controllers.measurement.memory_estimator import memory_at_rest
from design.mpc.prediction import example, start_of, unloaded, variables
from design.mpc.problem import Believed, MPCProblem
from plants import dynamics
from plants.hysteresis import HysteresisLaw
from plants.kernel import pytrees as tree
from plants.kernel.inlining import compiled, inlined, scalars, unpacked
from plants.wrist import State, Wrist

Array = NDArray[np.float64]

LEAST_SHARE = 0.05
"""Share of an error of pressure gone in a period below which the lack is believed less."""

MOST_MISSED = 0.3
"""Miss of the pressure [kPa] in a period that is counted at most: a constant disturbance is missed by
little at a time, a dead time by much."""

_LOOP = """\
def run(start, command, measured, c, substeps, after):
    {coefficients}
    {start}
    u_command = command
    path = np.empty(substeps + 1)
    path[0] = x_pressure
    for i in range(substeps):
        {press}
        path[i + 1] = x_pressure
    missed = measured - path[substeps] if math.isfinite(measured) else 0.0
    after[after.size - 1] = path[substeps]
    x_pressure = start[0]
    for i in range(substeps):
        u_pressure = path[i + 1] + missed * ((i + 1.0) / substeps)
        {bend}
    {kept}
"""


def _press(state: State, command: Any, c: Any) -> Any:
    return dynamics.press(state, command[0], c)[0]


def _bend(state: State, pressure: Any, c: Any) -> State:
    return dynamics.bend(state, pressure[0], (), c)


@cache
def _kernel(shape: HysteresisLaw) -> Callable[..., None]:
    model = example(shape)
    c, state = model.sampled(), model.rest()
    x = variables(state)
    coefficients = scalars("c", c)
    press = inlined(_press, [state, ("command",), c], [x, ["u_command"], coefficients], ["x_pressure"])
    bend = inlined(_bend, [state, ("pressure",), c], [x, ["u_pressure"], coefficients], x)
    return compiled(
        "a period of the wrist, of measured pressure", _LOOP,
        coefficients=unpacked(coefficients, "c"), start=unloaded(state), press=press, bend=bend,
        kept=[f"after[{i}] = {name}" for i, name in enumerate(x)],
    )  # fmt: skip


class Gains(NamedTuple):
    """Corrections per degree and per kPa missed; gain [kPa/V]; share of the lack; shape of the law."""

    angle: float
    shift: float
    lack: float
    gain: float
    share_at_rest: float
    substeps: int
    shape: HysteresisLaw


def gains(problem: MPCProblem) -> Gains:
    """Gains that put both poles of angle and shift at exp(-bandwidth period)."""
    keep, pole = exp(-problem.period / problem.wrist.Tw), exp(-problem.observer.bandwidth * problem.period)
    angle, shift = double_pole(keep, pole)
    at_rest = 1.0 - exp(-problem.wrist.regulator.k_slow * problem.period)
    return Gains(
        angle, shift, problem.observer.lack, problem.wrist.regulator.gain, at_rest, problem.substeps,
        problem.shape,
    )  # fmt: skip


def begin(angle: Any, pressure: Any, model: Wrist) -> Believed:
    """What is believed of a wrist that is seen to rest at an angle [deg] and a pressure [kPa].

    The memory is what the two tell (`controllers.memory_estimator`); what the angle misses of it is shift.
    """
    memory = memory_at_rest(angle, pressure, model.hysteresis)
    return Believed(State(pressure, memory, memory.h), 0.0, angle - memory.h)


def update(before: Believed, command: float, seen: Measured, g: Gains, c: Array) -> Believed:
    """What is believed one period later, in which `command` [V] was held; c as `prediction.coefficients`.

    A measurement that is not finite is left out: the model goes on alone.
    """
    pushed = command + before.lack / g.gain
    start = start_of(before)
    after = np.empty(len(start) + 1)
    pressure, seen_angle = float(seen.pressure), float(seen.angle)
    _kernel(g.shape)(start, pushed, pressure, c, g.substeps, after)
    *state, predicted = after.tolist()
    plant = tree.like(before.plant, state)
    angle = plant.angle

    lack = before.lack
    if isfinite(pressure):
        error = g.gain * pushed - before.plant.pressure
        share = (predicted - before.plant.pressure) / error if abs(error) > 1e-6 else g.share_at_rest
        missed = min(max(pressure - predicted, -MOST_MISSED), MOST_MISSED)
        lack += g.lack * missed * share / (share * share + LEAST_SHARE**2)
    shift = before.shift
    if isfinite(seen_angle):
        missed = seen_angle - (angle + shift)
        corrected, shift = angle + before.shift + g.angle * missed, shift + g.shift * missed
        angle = corrected - shift
    return Believed(plant._replace(angle=angle), lack, shift)
