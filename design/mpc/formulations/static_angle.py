"""From static angles to commands, by the inverses of law and regulator, and the angles within their range."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from design.mpc.prediction import example, plain, unloaded, variables
from plants import dynamics
from plants.hysteresis import HysteresisLaw
from plants.kernel.inlining import compiled, inlined, scalars, unpacked
from plants.wrist import State

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
def commands_kernel(shape: HysteresisLaw) -> Callable[..., None]:
    """Compiled, for wrists of one law: commands [V] that follow static angles [deg], a period each, by the
    regulator's own law."""
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
