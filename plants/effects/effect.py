"""What an effect is: parameters with a null at which it vanishes, a state, and laws at named ports.

An effect's coefficients for one sample time are a NamedTuple whose methods are
its laws; the method's name is the port of the wrist that it acts on.  The wrist
(`plants.wrist.step`) calls, in this order, those that an effect has:

    target(s, target, around)            -> s, target          commanded pressure [kPa]
    valve(s, pressure, error, around)    -> error, speed       pressure error [kPa], factor of the rate
    supply(s, before, after)             -> s, after           pressure [kPa]
    drive(s, before, after, around)      -> s, before, after   pressure that drives the loop [kPa]
    bend(s, before, after, loop, around) -> s, low, high, slope  shifts of line 1 and 2 [deg],
                                                               factor of the transit's slope
    static(s, before, after, around)     -> s, before, after   static angle [deg]
    joint(s, angle, before, after, pressure) -> s, angle       in place of the lag [deg]
    stop(s, angle)                       -> angle              where the joint may go [deg]
    sensor(s, angle, around)             -> angle              what is measured [deg]

``s`` is the effect's state, ``before`` and ``after`` are the ends of the sample.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from itertools import product
from typing import Any, ClassVar, Literal, NamedTuple

from plants.hysteresis import Side
from plants.parameters.spec import Kind

Number = Any
EffectStage = Literal["regulator", "wrist", "sensor"]


class Around(NamedTuple):
    """What comes from outside during a sample: the time at its start [s] and the pressure of the
    other motion [kPa]."""

    time: Number = 0.0
    other_pressure: Number = 100.0


@dataclass(frozen=True)
class Linear:
    """What an effect does to small motions about an equilibrium: factors of the declared wrist's.

    command, static: frequency responses, shape of z, in the commanded pressure and in the
    static angle; joint: that from the static angle to the angle, in place of the lag's;
    rates: factors of the regulator's rate that occur; slopes: least and largest factor
    of the slope on each side of the loop where it is changed.
    """

    command: Any = 1.0
    static: Any = 1.0
    joint: Any = None
    rates: tuple[float, ...] = (1.0,)
    slopes: Mapping[Side, tuple[float, float]] = field(default_factory=dict)


class Nothing(NamedTuple):
    """The state of an effect that remembers nothing."""


def parameter(
    unit: str, meaning: str, low: float, high: float, null: float, trials: tuple[float, ...] = ()
) -> Any:
    """A parameter of an effect: its unit, meaning and bounds, its value where the effect vanishes (or,
    for one that has no meaning there, a typical one), and values to try it at when effects are ranked."""
    return field(default=null, metadata={"kind": Kind(unit, meaning, low, high), "trials": trials or (null,)})


@dataclass(frozen=True)
class Effect(ABC):
    """Base of all effects.

    NAME: of the phenomenon, fixed; FORM: which of the functional forms that go
    under that name; STAGE: where it sits.  An effect made without arguments is absent.
    """

    NAME: ClassVar[str]
    FORM: ClassVar[str]
    STAGE: ClassVar[EffectStage]

    @classmethod
    def kinds(cls) -> dict[str, Kind]:
        """Unit, meaning and bounds of each parameter."""
        return {f.name: f.metadata["kind"] for f in fields(cls)}

    @classmethod
    def trials(cls) -> Iterator[dict[str, float]]:
        """Values to try the effect at: every combination of its parameters' trial values."""
        names = [f.name for f in fields(cls)]
        for values in product(*(f.metadata["trials"] for f in fields(cls))):
            yield dict(zip(names, values, strict=True))

    @property
    def values(self) -> dict[str, Number]:
        """The parameters by their names in a wrist, such as ``creep.gain``."""
        return {f"{self.NAME}.{n}": v for n, v in vars(self).items()}

    @classmethod
    def from_values(cls, values: Mapping[str, Number]) -> "Effect":
        """The effect with the parameters that `values` has of it, by their names in a wrist."""
        return cls(**{f.name: values[f"{cls.NAME}.{f.name}"] for f in fields(cls)})

    @abstractmethod
    def sampled(self, wrist: Any, dt: float) -> Any:
        """Coefficients for a sample time `dt` [s] in a wrist; a NamedTuple with laws at ports."""

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Any:
        """State of the effect in a wrist at rest for long at a pressure [kPa] and a static angle [deg]."""
        return Nothing()

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        """What is linear of the effect at points z = exp(j omega dt), within pressures `reach` [kPa]."""
        return Linear()

    def obstacle(self, pressure: float, angle: float) -> str | None:
        """What keeps a wrist that needs a pressure [kPa] for it from an angle [deg], in words, or None."""
        return None
