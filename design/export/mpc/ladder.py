"""The ladder of fallbacks as C (`templates/ladder.c.jinja`): what it remembers, its PI as a graph; and the
law in Python that a target is compared with, `design.mpc.fallback.step` itself.

What differs from Python's own loop: there is no clock, so that no answer is late; nothing is prepared for the
next period.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from design.controllers import pi
from design.controllers.controller import Measured, remembers
from design.controllers.pi import PIState
from design.export.part import Seen
from design.mpc import fallback
from design.mpc.fallback import Fallback, Planning
from plants.kernel.graphs import baked, graph

Number = Any
Begin = Callable[[float, float], tuple[Any, float]]
Step = Callable[[Any, Seen], tuple[Any, float]]


@remembers(
    reference=("deg", "last reference that was believed"),
    referred=("", "1 once a reference was believed, 0 before"),
    planned=("", "1 while there is a plan, 0 else"),
    failures=("", "periods in a row in which nothing was solved"),
    integral=("kPa", "integral of the PI below the plan, gain included"),
    by_pi=("", "1 while that PI is in charge, 0 else"),
)
class Ladder(NamedTuple):
    """What the C remembers of the rungs; the rest of `design.mpc.fallback.MPCState` is belief and plan."""

    reference: Number = 0.0
    referred: Number = 0.0
    planned: Number = 0.0
    failures: Number = 0.0
    integral: Number = 0.0
    by_pi: Number = 0.0


def descend(name: str, ladder: Fallback, period: float) -> Any:
    """The graph of the PI: integral [kPa] after and command [V], of integral, whether it is in charge (1) or
    not (0), command of the period before and error [deg]."""
    c = ladder.pi.sampled(period)

    def law(at: Any) -> Any:
        integral, in_charge, command, error = at
        begun = c.following(PIState(integral), Measured(error, 0.0, 0.0), command).integral
        after, asked = pi.step(PIState(np.where(in_charge > 0.5, integral, begun)), error, c)
        return after.integral, asked

    return baked(f"{name}_descend_law", graph(law, (0.0, 0.0, 0.0, 0.0)))


def in_python(controller: Planning) -> tuple[Begin, Step]:
    """The law in Python, with nothing prepared."""

    def begin(pressure: float, angle: float) -> tuple[Any, float]:
        state = fallback.begin(controller, Measured(0.0, angle, pressure))
        return state, state.command

    def step(state: Any, seen: Seen) -> tuple[Any, float]:
        measured = Measured(seen.reference - seen.angle, seen.angle, seen.pressure)
        after, command, _ = fallback.step(controller, state, measured)
        return after._replace(prepared=None), command

    return begin, step
