"""What a controller is: a value that is sampled into coefficients whose method `act` is its law.

A module of this package that holds a controller has

    a frozen dataclass, a `Controller`      its settings, floats or arrays of lanes
    class State(NamedTuple)                 what it remembers, with units by `remembers`
    class Sampled(NamedTuple)               its coefficients for one sample time, a `SampledController`
    def step(state, measured, c)            one sample, which `act` hands on to; NumPy ufuncs only

so that the loop in `plants.simulation.closed_loop` can be simulated in plain Python, compiled,
differentiated and exported from the same lines.  `design.controllers.pi` is the first one (its step
takes the error alone), `design.controllers.lqi` another, which uses angle and pressure as well.
"""

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np

from plants.kernel import pytrees
from plants.meanings import remembers
from plants.simulation.sensor import Measured
from plants.wrist import SAMPLE_TIME

__all__ = ["ControlLaw", "Controller", "Measured", "SampledController", "remembers", "stacked"]

Number = Any
ControlLaw = Callable[[Any, Number, Any], tuple[Any, Number]]
"""``(state, measured or error [deg], coefficients) -> (state, command [V])``, once a sample, before the
plant moves."""


class SampledController(Protocol):
    """Coefficients of a controller for one sample time, a NamedTuple."""

    def act(self, state: Any, seen: Measured) -> tuple[Any, Number]:
        """State after, and command [V] of, one sample."""
        ...


class Controller(Protocol):
    """Settings of a controller, a frozen dataclass whose fields are floats or arrays of lanes."""

    @property
    def gain(self) -> Number:
        """What the controller knows of the regulator [kPa/V]."""
        ...

    @property
    def low(self) -> Number:
        """Least command [V]."""
        ...

    @property
    def high(self) -> Number:
        """Largest command [V]."""
        ...

    def sampled(self, dt: float = SAMPLE_TIME) -> Any:
        """Coefficients for a sample time [s], a `SampledController`."""
        ...

    def holding(self, pressure: Number, seen: Measured | None = None) -> Any:
        """The state in which it holds a pressure [kPa] (by its own idea of the regulator's gain) while
        the error is zero; `seen` is what is measured then, for a controller that needs it."""
        ...

    def command(self, state: Any) -> Number:
        """The command [V] that a state gives while the error is zero."""
        ...


def stacked(controllers: Sequence[Any], repeat: int = 1) -> Any:
    """Controllers of one kind, whose settings are floats, as one with arrays of lanes, each `repeat` times
    in a row."""
    rows = zip(*(pytrees.leaves(c) for c in controllers), strict=True)
    return pytrees.like(controllers[0], [np.repeat(np.array(row, float), repeat) for row in rows])


def sensors_of(controller: Any) -> tuple[str, ...]:
    """What a controller measures, the angle, or angle and pressure: as its class says in `SENSORS`, else all
    that it is shown."""
    return tuple(getattr(controller, "SENSORS", ("angle", "pressure")))


def settings_of(controller: Any) -> dict[str, float]:
    """The settings of a controller or an observer by name, those of its model included."""
    declared = getattr(controller, "settings", None)
    return {n: float(v) for n, v in (vars(controller) if declared is None else declared).items()}
