"""The wrist drive system: regulator, hysteresis and lag in series (section 5.2 of the paper).

A wrist is a value: its parameters, and the effects that were added to it.  Its
state is another value, and `plants.dynamics.step` takes one to the next.  Parameters may be
floats, arrays (one lane each, for batches) or CasADi symbols: the laws are the same.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import prod
from typing import TYPE_CHECKING, Any

from plants import hysteresis, lag
from plants.actuator import regulator
from plants.actuator.regulator import Regulator
from plants.dynamics import SampledWrist, State
from plants.effects.effect import Effect
from plants.equilibrium import at_rest
from plants.hysteresis import STARTS, HysteresisLaw, Start
from plants.rig import Rig, built_in_rig

if TYPE_CHECKING:
    from plants.parameters.quantities import ParameterSet

Number = Any
SAMPLE_TIME = built_in_rig().sample_time
"""Sample time of loop and model [s] of the built-in rig, for values that are made without a rig."""

COMMAND_RANGE = built_in_rig().command_range
"""Range of the command [V] of the built-in rig, likewise."""

__all__ = ["COMMAND_RANGE", "SAMPLE_TIME", "STARTS", "Start", "State", "Wrist"]


@dataclass(frozen=True)
class Wrist:
    """Parameters of one motion of the wrist: regulator, loop, lag time constant Tw [s], effects; and the rig
    that it is a motion of, the paper's where not given.

    >>> wrist = Wrist.flexion()
    >>> wrist.hysteresis.s, wrist.regulator.gain
    (0.0803, 49.4)
    >>> response = wrist.simulate([3.0] * 10_000)
    >>> round(float(response.pressure[-1]), 1)
    148.2

    An effect is added with ``+``:

    >>> from plants.effects.wrist.creep import Creep
    >>> creeping = wrist + Creep(gain=0.1, time_constant=4.0)
    >>> round(float(creeping.simulate([3.0] * 10_000).angle[-1] - response.angle[-1]), 2)
    1.03
    """

    regulator: Regulator
    hysteresis: HysteresisLaw
    Tw: Number
    effects: tuple[Effect, ...] = ()
    rig: Rig = field(default_factory=built_in_rig, metadata={"static": True}, repr=False)

    def __add__(self, effect: Effect) -> "Wrist":
        """The wrist with one more effect, one that is not registered last; raises ValueError for a second
        form of the same."""
        from plants.effects import in_order

        if effect.NAME in (e.NAME for e in self.effects):
            raise ValueError(f"the wrist has an effect {effect.NAME} already")
        return replace(self, effects=in_order((*self.effects, effect)))

    @classmethod
    def from_values(
        cls, values: Mapping[str, Number], effects: tuple[type[Effect], ...] = (), rig: Rig | None = None
    ) -> "Wrist":
        """The wrist with the parameters of `values`, by their names in a parameter set, effects of the forms
        given, and a rig, the paper's where not given."""
        declared = cls(
            Regulator(*(values[n] for n in ("gain", "k_fast", "k_slow", "e0"))),
            hysteresis.with_values(values),
            values["Tw"],
            rig=built_in_rig() if rig is None else rig,
        )
        for form in effects:
            declared = declared + form.from_values(values)
        return declared

    @classmethod
    def of(cls, parameters: "ParameterSet") -> "Wrist":
        """The wrist of a parameter set, its effects included."""
        return cls.from_values(parameters.values, parameters.effects, parameters.rig)

    @classmethod
    def flexion(cls) -> "Wrist":
        """Palmar/dorsal flexion with the parameters of ``plants/parameters/flexion.toml``."""
        from plants.parameters.files import built_in

        return cls.of(built_in("flexion"))

    @classmethod
    def deviation(cls) -> "Wrist":
        """Radial/ulnar deviation with the parameters of ``plants/parameters/deviation.toml``."""
        from plants.parameters.files import built_in

        return cls.of(built_in("deviation"))

    @property
    def values(self) -> dict[str, Number]:
        """The parameters by name, flat, as in a parameter set; an effect's as ``creep.gain``."""
        values = {**vars(self.regulator), **self.hysteresis.values, "Tw": self.Tw}
        for effect in self.effects:
            values |= effect.values
        return values

    @property
    def forms(self) -> tuple[type[Effect], ...]:
        """The forms of the wrist's effects."""
        return tuple(type(e) for e in self.effects)

    @property
    def reach(self) -> tuple[Number, Number]:
        """Pressures [kPa] between which the range of the command takes the regulator.

        >>> Wrist.flexion().reach
        (0.0, 197.6)
        """
        low, high = self.rig.command_range
        return self.regulator.gain * low, self.regulator.gain * high

    @property
    def static_gain(self) -> Number:
        """Factor from the loop's angle to the joint's that effects make of it at rest, as creep that has
        crept."""
        return prod((e.static_gain for e in self.effects), start=1.0)

    @property
    def unmoved(self) -> tuple[Number, Number] | tuple[()]:
        """Angle of the loop [deg] and pressure [kPa] at which the rig rests until it is moved first
        (`plants.rig.Zero.rest`); empty where these are 0 and the rest pressure."""
        if not self.rig.zero.rest:
            return ()
        angle, loop = self.rig.zero.rest / self.static_gain, self.hysteresis
        return angle, 0.5 * (loop.ascending_pressure(angle) + loop.descending_pressure(angle))

    def with_values(self, **changes: Number) -> "Wrist":
        """The same wrist with some parameters changed.

        >>> Wrist.flexion().with_values(Tw=0.2).Tw
        0.2
        """
        unknown = set(changes) - set(self.values)
        if unknown:
            raise TypeError(f"no such parameter of the wrist: {', '.join(sorted(unknown))}")
        return self.made_of({**self.values, **changes})

    def made_of(self, values: Mapping[str, Number]) -> "Wrist":
        """A wrist of the same rig, hysteresis law and forms of effects, with the parameters of `values`."""
        return Wrist.from_values(values, self.forms, self.rig)

    def sampled(self, dt: float | None = None) -> SampledWrist:
        """Coefficients of the wrist for a sample time `dt` [s], the rig's where not given."""
        dt = self.rig.sample_time if dt is None else dt
        return SampledWrist(
            regulator.sampled(self.regulator, dt),
            self.hysteresis,
            lag.sampled(self.Tw, dt),
            tuple(e.sampled(self, dt) for e in self.effects),
        )

    def rest(self, start: Start = "virgin", angle: float = 0.0) -> State:
        """The state of a wrist that holds still at an angle [deg], having come there by `start`.

        See `plants.equilibrium.at_rest`.  Raises ValueError for an unknown start or a virgin
        wrist away from 0.
        """
        return at_rest(self, start, angle)

    def as_lag_regulator(self, time_constant: float = 0.111) -> "Wrist":
        """The same wrist behind the paper's first-order lag regulator (section 3)."""
        return replace(self, regulator=Regulator.lag(self.regulator.gain, time_constant))

    def simulate(self, commands: Any, state: State | None = None, every: int = 1) -> Any:
        """Open-loop response to commands [V], one per ms; see `plants.simulation.open_loop.open_loop`."""
        from plants.simulation.open_loop import open_loop

        return open_loop(self, commands, state=state, every=every)

    def to_control(self) -> Any:
        """The sampled wrist as a discrete ``control.nlsys``; see `plants.linearisation.nlsys`.

        python-control starts it at 0 kPa unless it is given `plants.linearisation.wrist_x0`.
        """
        from plants.linearisation import nlsys

        return nlsys(self)

    def linearised(self, branch: str, rate: str = "fast") -> Any:
        """``control.ss`` of one branch at one regulator rate; see `plants.linearisation.branch_ss`."""
        from plants.linearisation import branch_ss

        return branch_ss(self, branch, rate)
