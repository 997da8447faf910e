"""What a controller is: a value that is sampled into coefficients, and a pure step function.

A module of this package that holds a controller has

    class State(NamedTuple)                             what it remembers
    class Sampled(NamedTuple)                           its coefficients for one sample time
    def step(state, error, c) -> (state, command)       one sample; NumPy ufuncs only

so that the loop in `design.loop` can be simulated in plain Python, compiled,
differentiated and exported from the same lines.  `design.pi` is the first one.
"""

from collections.abc import Callable
from typing import Any

Number = Any
ControlLaw = Callable[[Any, Number, Any], tuple[Any, Number]]
"""``(state, error [deg], coefficients) -> (state, command [V])``, once a sample, before the plant moves."""
