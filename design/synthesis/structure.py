"""Structures that are tuned by a PI's two gains: a PI, one with two degrees of freedom, one with feedforward,
a cascade.

A structure names the settings that its controller has beside Kp and Ki, and the values that a tuning tries
of them: the cost is flat along these, so that a few round values do.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from design.controllers.cascade import CascadePI
from design.controllers.feedforward import FeedforwardPI
from design.controllers.lqi import LQI
from design.controllers.pi import PI
from design.controllers.pi_two_dof import TwoDofPI
from plants.wrist import Wrist

WEIGHTS = tuple(round(0.5 + 0.1 * k, 10) for k in range(21))
"""Reference weights b [1] that are tried."""

INNER_GAINS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.3, 1.6, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
"""Gains Kc [1] of the inner loop on the pressure that are tried."""

SPEEDS = (1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0)
"""Rates [1/s] of the feedforward's reference filter that are tried."""

FILTERS = (0.01, 0.02, 0.005)
"""Time constants [s] of the filter of the angle that are tried, as long as the first of them lowers the
cost."""


@dataclass(frozen=True)
class Structure:
    """A structure: its controller of a wrist, Kp [kPa/deg], Ki [kPa/(deg s)], floats or lanes, and settings
    by name.

    settings: those that a tuning begins with; ladders: settings that it goes downhill along, one after the
    other, and their values in order; strides: of its first search along them; filters: time constants [s] of
    the filter Tf that are tried after that.  loop_kept: the gains stay those that are known, so that the
    loop's margins stay too, and the ladders alone are searched.
    """

    name: str
    of: Callable[..., Any] = field(repr=False)
    settings: Mapping[str, float] = field(default_factory=dict)
    ladders: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    strides: tuple[int, ...] = (4, 2, 1)
    filters: tuple[float, ...] = ()
    loop_kept: bool = False


def _forward(wrist: Wrist, Kp: Any, Ki: Any, **settings: Any) -> FeedforwardPI:
    # Effects have no inverse: the model is the wrist without them, and the PI takes out what they do.
    made: FeedforwardPI = FeedforwardPI.of(replace(wrist, effects=()), Kp=Kp, Ki=Ki, **settings)
    return made


PLAIN_PI = Structure("PI", PI.of)
TWO_DOF_PI = Structure("2-DOF PI", TwoDofPI.of, {"b": 1.0, "Tf": 0.0}, {"b": WEIGHTS}, filters=FILTERS)
FORWARD_PI = Structure(
    "PI + feedforward", _forward, {"speed": 4.0, "dead_time": 0.0}, {"speed": SPEEDS},
    strides=(1,), loop_kept=True,
)  # fmt: skip

CASCADE_PI = Structure(
    "cascade PI", CascadePI.of, {"b": 1.0, "Kc": 1.0}, {"Kc": INNER_GAINS, "b": WEIGHTS}, strides=(4, 2, 1)
)
"""It measures the pressure too."""


def forward_pi(dead_time: float) -> Structure:
    """A PI with feedforward whose model answers late by a dead time [s]."""
    return replace(FORWARD_PI, settings={**FORWARD_PI.settings, "dead_time": dead_time})


def weighted_mpc(wrist: Wrist, swing: float, move: float, delay: float = 0.0) -> Any:
    """The MPC by real-time iteration in its robust setting, with weights [1/deg^2], [1/V^2] of changes of
    angle and command; its model is the wrist without its effects, behind a dead time of `delay` periods.
    Raises InputError where its solver is not installed.
    """
    from design.mpc.formulations.real_time import real_time_mpc
    from design.mpc.problem import robust, weighted

    return real_time_mpc(weighted(robust(replace(wrist, effects=())), swing, move, delay))


def with_gains(wrist: Wrist, gains: Mapping[str, Any]) -> Any:
    """The controller of a wrist with gains and settings by name: an LQI, a PI with feedforward, a robust MPC,
    a cascade, a PI with two degrees of freedom, or a plain PI where weight and filter are those of one.

    >>> type(with_gains(Wrist.flexion(), {"Kp": 2.0, "Ki": 5.0, "b": 1.0, "Tf": 0.0})).__name__
    'PI'
    >>> type(with_gains(Wrist.flexion(), {"Kp": 2.0, "Ki": 5.0, "speed": 8.0, "dead_time": 0.02})).__name__
    'FeedforwardPI'

    Raises InputError for a feedforward of a wrist that has no inverse.
    """
    if "Ke" in gains:
        return LQI.of(wrist, **gains)
    if "swing" in gains:
        return weighted_mpc(wrist, **gains)
    if "speed" in gains:
        return FORWARD_PI.of(wrist, **gains)
    if "Kc" in gains:
        return CascadePI.of(wrist, **gains)
    if gains.get("b", 1.0) == 1.0 and gains.get("Tf", 0.0) == 0.0:
        return PI.of(wrist, gains["Kp"], gains["Ki"])
    return TwoDofPI.of(wrist, **gains)
