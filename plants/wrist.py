"""The wrist drive system: regulator, hysteresis and lag in series (section 5.2 of the paper).

A wrist is a value: its parameters.  Its state is another value, and ``step``
takes one to the next.  Parameters may be floats, arrays (one lane each, for
batches) or CasADi symbols: the laws are the same.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from plants import hysteresis, lag, regulator
from plants.hysteresis import Hysteresis, Memory
from plants.regulator import Regulator

Number = Any
SAMPLE_TIME = 0.001
"""Sample time of loop and model [s] (section 4)."""

COMMAND_RANGE = (0.0, 4.0)
"""Range of the command [V] (section 3)."""

Start = Literal["virgin", "line1", "line2", "inside"]
STARTS: tuple[Start, ...] = ("virgin", "line1", "line2", "inside")


class State(NamedTuple):
    """What the wrist remembers: pressure [kPa], the loop's memory, angle [deg]."""

    pressure: Number
    memory: Memory
    angle: Number


class SampledWrist(NamedTuple):
    """Coefficients of the wrist for one sample time."""

    regulator: regulator.SampledRegulator
    a1: Number
    w1: Number
    a2: Number
    w2: Number
    s: Number
    rest_pressure: Number
    lag: lag.SampledLag


def step(state: State, command: Number, c: SampledWrist) -> State:
    """The wrist one sample later, the command [V] held in between."""
    pressure = regulator.step(state.pressure, command, c.regulator)
    loop = Hysteresis(c.a1, c.w1, c.a2, c.w2, c.s, c.rest_pressure)
    memory = hysteresis.step(state.memory, state.pressure, pressure, loop)
    angle = lag.step(state.angle, state.memory.h, memory.h, c.lag)
    return State(pressure, memory, angle)


@dataclass(frozen=True)
class Wrist:
    """Parameters of one motion of the wrist: regulator, loop, lag time constant Tw [s].

    >>> wrist = Wrist.flexion()
    >>> wrist.hysteresis.s, wrist.regulator.gain
    (0.0803, 49.4)
    >>> response = wrist.simulate([3.0] * 10_000)
    >>> round(float(response.pressure[-1]), 1)
    148.2
    """

    regulator: Regulator
    hysteresis: Hysteresis
    Tw: Number

    @classmethod
    def from_values(cls, values: Mapping[str, Number]) -> "Wrist":
        """The wrist with the parameters of `values`, by their names in a parameter set."""
        return cls(
            Regulator(*(values[n] for n in ("gain", "k_fast", "k_slow", "e0"))),
            Hysteresis(*(values[n] for n in ("a1", "w1", "a2", "w2", "s", "rest_pressure"))),
            values["Tw"],
        )

    @classmethod
    def flexion(cls) -> "Wrist":
        """Palmar/dorsal flexion with the parameters of ``plants/parameters/flexion.toml``."""
        from plants.quantities import built_in

        return cls.from_values(built_in("flexion").values)

    @classmethod
    def deviation(cls) -> "Wrist":
        """Radial/ulnar deviation with the parameters of ``plants/parameters/deviation.toml``."""
        from plants.quantities import built_in

        return cls.from_values(built_in("deviation").values)

    @property
    def values(self) -> dict[str, Number]:
        """The parameters by name, flat, as in a parameter set."""
        return {**vars(self.regulator), **vars(self.hysteresis), "Tw": self.Tw}

    def with_values(self, **changes: Number) -> "Wrist":
        """The same wrist with some parameters changed.

        >>> Wrist.flexion().with_values(Tw=0.2).Tw
        0.2
        """
        unknown = set(changes) - set(self.values)
        if unknown:
            raise TypeError(f"no such parameter of the wrist: {', '.join(sorted(unknown))}")
        return Wrist.from_values({**self.values, **changes})

    def sampled(self, dt: float = SAMPLE_TIME) -> SampledWrist:
        """Coefficients of the wrist for a sample time `dt` [s]."""
        p = self.hysteresis
        return SampledWrist(
            regulator.sampled(self.regulator, dt),
            p.a1, p.w1, p.a2, p.w2, p.s, p.rest_pressure,
            lag.sampled(self.Tw, dt),
        )  # fmt: skip

    def rest(self, start: Start = "virgin", angle: float = 0.0) -> State:
        """The state of a wrist that holds still at an angle [deg], having come there by `start`.

        ``virgin``: never moved from the rest pressure; only at angle 0.  ``line1``,
        ``line2``: arrived in the plus, the minus direction.  ``inside``: half-way
        in pressure between the two lines, as after a reversal.
        Raises ValueError for an unknown start or a virgin wrist away from 0.
        """
        p = self.hysteresis
        if start == "virgin" and np.any(np.asarray(angle) != 0.0):
            raise ValueError("a virgin wrist rests at angle 0; start on line1, line2 or inside")
        low, high = hysteresis.line2_pressure(angle, p), hysteresis.line1_pressure(angle, p)
        pressures = {
            "virgin": p.rest_pressure,
            "line1": high,
            "line2": low,
            "inside": (low + high) / 2,
        }
        if start not in pressures:
            raise ValueError(f"unknown start {start!r}; one of {', '.join(STARTS)}")
        return State(pressures[start], Memory(angle, float(start == "virgin")), angle)

    def as_lag_regulator(self, time_constant: float = 0.111) -> "Wrist":
        """The same wrist behind the paper's first-order lag regulator (section 3)."""
        return replace(self, regulator=Regulator.lag(self.regulator.gain, time_constant))

    def simulate(self, commands: Any, state: State | None = None, every: int = 1) -> Any:
        """Open-loop response to commands [V], one per ms; see `plants.simulate.open_loop`."""
        from plants.simulate import open_loop

        return open_loop(self, commands, state=state, every=every)

    def to_control(self) -> Any:
        """The sampled wrist as a discrete ``control.nlsys``; see `plants.linear.nlsys`.

        python-control starts it at 0 kPa unless it is given `plants.linear.wrist_x0`.
        """
        from plants.linear import nlsys

        return nlsys(self)

    def linearised(self, branch: str, rate: str = "fast") -> Any:
        """``control.ss`` of one branch at one regulator rate; see `plants.linear.branch_ss`."""
        from plants.linear import branch_ss

        return branch_ss(self, branch, rate)
