"""What an effect is: parameters with a null at which it vanishes, a state, and laws at named ports.

An effect's coefficients for one sample time are a NamedTuple whose methods are
its laws; the method's name is the port of the wrist that it acts on.  The wrist
(`plants.dynamics.step`) calls, in this order, those that an effect has:

    target(s, target, around)            -> s, target          commanded pressure [kPa]
    valve(s, pressure, error, around)    -> error, speed       pressure error [kPa], factor of the rate
    chamber(s, before, target, after)    -> after              pressure [kPa], in place of the regulator's
    supply(s, before, after)             -> s, after           pressure [kPa]
    drive(s, before, after, around)      -> s, before, after   pressure that drives the loop [kPa]
    bend(s, before, after, loop, around) -> s, low, high, slope  shifts of line 1 and 2 [deg],
                                                               factor of the transit's slope
    steepen(s, h, before, after, loop) -> factor              further factor of the transit's slope
    static(s, before, after, around)     -> s, before, after   static angle [deg]
    joint(s, angle, before, after, pressure) -> s, angle       in place of the lag [deg]
    friction(s, angle, free, share)          -> s, friction    [deg] that holds a joint back, which would come
                                                               to `free` without, less `share` times it
    stop(s, angle)                       -> angle              where the joint may go [deg]
    sensor(s, angle, around)             -> angle              what is measured [deg]

``s`` is the effect's state, ``before`` and ``after`` are the ends of the sample.  Coefficients whose law at
``drive`` only watches the pressure, and returns it as it is, have a property ``watches`` that is true.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from itertools import product
from typing import Any, ClassVar, Literal, NamedTuple

from plants.effects.hints import ExcitationHints, TrialHints
from plants.hysteresis import Side
from plants.parameters.spec import Kind
from plants.rig import Rig, built_in_rig

Number = Any
EffectStage = Literal["regulator", "wrist", "sensor"]


class Around(NamedTuple):
    """What comes from outside during a sample: the time at its start [s] and how far the pressure of the
    other motion is from its rest [kPa]."""

    time: Number = 0.0
    other_pressure: Number = 0.0


@dataclass(frozen=True)
class Linear:
    """What an effect does to small motions about an equilibrium: factors of the declared wrist's.

    command, static: frequency responses, shape of z, in the commanded pressure and in the
    static angle; joint: that from the static angle to the angle, in place of the lag's;
    rates: factors of the regulator's rate that occur; flows: least and largest rate [1/s] in place of the
    regulator's; slopes: least and largest factor
    of the slope on each side of the loop where it is changed; added: least and largest slope [deg/kPa]
    that is added on each side where one is.
    """

    command: Any = 1.0
    static: Any = 1.0
    joint: Any = None
    rates: tuple[float, ...] = (1.0,)
    flows: tuple[float, ...] = ()
    slopes: Mapping[Side, tuple[float, float]] = field(default_factory=dict)
    added: Mapping[Side, tuple[float, float]] = field(default_factory=dict)


class Nothing(NamedTuple):
    """The state of an effect that remembers nothing."""


def parameter(
    unit: str,
    meaning: str,
    low: float,
    high: float,
    null: float,
    trials: tuple[float, ...] = (),
    spread: float | None = None,
) -> Any:
    """A parameter of an effect: its unit, meaning and bounds, its value where the effect vanishes (or,
    for one that has no meaning there, a typical one), and values to try it at when effects are ranked.
    spread: by how much, in its unit, a trial is moved to refine it; None: by a factor."""
    kind = Kind(unit, meaning, low, high)
    return field(default=null, metadata={"kind": kind, "trials": trials or (null,), "spread": spread})


@dataclass(frozen=True)
class Effect(ABC):
    """Base of all effects.  One made without arguments is absent.

    What an effect is:

    - NAME: of the phenomenon, fixed; FORM: which of the functional forms that go under that name;
    - STAGE: where it sits; HAPPENS: what happens on a rig that has it, the beginning of a sentence.

    What others need to know of it, and it alone can say:

    - LOG: what a log needs beside command, pressure and angle for it to show, columns with their meaning;
    - FROM_REMAINDER: whether `trials_on` takes values from the residual, which are as small as it is;
    - WANDERS: whether its sensor wanders besides, which no model foresees;
    - DELAY: the parameter that is its transport delay [s], for one that delays and smooths the command alone;
    - STOPS: whether it is a stop that the joint runs into;
    - RUGGED: whether a fit of it has many minima, so that it has to be started from each of its trials;
    - THRESHOLD: the parameter that only decides whether something happens, so that recordings tell no
      more than an interval of it;
    - COMMON: whether nearly any pneumatic joint has some of it, so that it is looked for first, with
      others of the kind, where nothing was measured between command and angle;
    - FIRST: whether it acts on the command before all others, wherever its name stands among theirs;
    - SILENT: whether it grows from nothing once a run begins, so that a wrist rests as it does without;
    - JOINT: whether it is a law of the joint, mass or friction, so that what it does hangs on the others;
    - MASSLESS: whether it takes the place of any other law of the joint, a mass too;
    - FROM_REST: whether it counts from where the wrist rests, as a curve about the rest pressure, so that it
      is another one where the angle is counted from elsewhere;
    - EVENT: whether it happened once, in the recordings, and is no property of the rig;
    - LEARNT: whether it is a map that was learnt from a residual, without a cause;
    - SUPPLIES: whether it has a supply of its own, at whose pressure nothing flows in; a rig has one;
    - LOSES: whether air is lost at rest, so that more is commanded than the pressure that is held;
    - REGULATES: whether the pressure rests where it is commanded, but for what is lost;
    - BOUND: what the performance bound makes of it: ``kept``, where the wrist is a monotone cascade with it,
      ``taken away``, where the wrist without it goes at least as far, or None, where no bound is known.
    """

    NAME: ClassVar[str]
    FORM: ClassVar[str]
    STAGE: ClassVar[EffectStage]
    HAPPENS: ClassVar[str]
    LOG: ClassVar[Mapping[str, str]] = {}
    FROM_REMAINDER: ClassVar[bool] = False
    WANDERS: ClassVar[bool] = False
    DELAY: ClassVar[str | None] = None
    STOPS: ClassVar[bool] = False
    RUGGED: ClassVar[bool] = False
    THRESHOLD: ClassVar[str | None] = None
    COMMON: ClassVar[bool] = False
    FIRST: ClassVar[bool] = False
    SILENT: ClassVar[bool] = False
    JOINT: ClassVar[bool] = False
    MASSLESS: ClassVar[bool] = False
    FROM_REST: ClassVar[bool] = False
    EVENT: ClassVar[bool] = False
    LEARNT: ClassVar[bool] = False
    SUPPLIES: ClassVar[bool] = False
    LOSES: ClassVar[bool] = False
    REGULATES: ClassVar[bool] = True
    BOUND: ClassVar[Literal["kept", "taken away"] | None] = None

    @classmethod
    def kinds(cls) -> dict[str, Kind]:
        """Unit, meaning and bounds of each parameter."""
        return {f.name: f.metadata["kind"] for f in fields(cls)}

    @classmethod
    def trials(cls, rig: Rig | None = None) -> Iterator[dict[str, float]]:
        """Values to try the effect at: every combination of its parameters' trial values, in the units of a
        rig, the built-in one where not given."""
        rig, kinds = rig or built_in_rig(), cls.kinds()
        names = [f.name for f in fields(cls)]
        for values in product(*(f.metadata["trials"] for f in fields(cls))):
            yield {n: rig.scaled(v, kinds[n].unit) for n, v in zip(names, values, strict=True)}

    @staticmethod
    def pressures(rig: Rig | None = None) -> tuple[float, float]:
        """Lowest and highest pressure [kPa] of a rig, the built-in one where not given."""
        return (rig or built_in_rig()).pressure_range

    @classmethod
    def trials_on(cls, log: TrialHints) -> Iterable[dict[str, float]]:
        """Values to try the effect at on a log: the trials, unless the data alone can tell where."""
        return cls.trials(log.rig)

    @classmethod
    def spreads(cls) -> dict[str, float | None]:
        """By how much each trial value is moved to refine it, in its unit; None: by a factor."""
        return {f.name: f.metadata["spread"] for f in fields(cls)}

    @property
    def values(self) -> dict[str, Number]:
        """The parameters by their names in a wrist, such as ``creep.gain``."""
        return {f"{self.NAME}.{n}": v for n, v in vars(self).items()}

    @classmethod
    def from_values(cls, values: Mapping[str, Number]) -> "Effect":
        """The effect with the parameters that `values` has of it, by their names in a wrist."""
        return cls(**{f.name: values[f"{cls.NAME}.{f.name}"] for f in fields(cls)})

    def borrowed(self, asked: ExcitationHints) -> str | None:
        """Why the effect, with these values, may be nothing but what the model does not make of the command,
        and which recording would tell; None where it cannot."""
        return None

    @property
    def static_gain(self) -> Number:
        """By what it multiplies the loop's angle at rest, as creep that has crept."""
        return 1.0

    def counted_from(self, angle: Number) -> "Effect | None":
        """The same effect of a wrist whose angle is counted from `angle` [deg]; None where it counts from
        where the wrist rests (`FROM_REST`)."""
        return None if self.FROM_REST else self

    def redundant(self, wrist: Any) -> bool:
        """Whether with these values it does nearly what a declared wrist does, so that its name is not that
        of what happens."""
        return False

    def hinders(self, band: float, unit: str) -> str | None:
        """Why no feedback without a jump holds the angle within a band to either side, in its unit; None
        where nothing of the effect keeps it from there."""
        return None

    @abstractmethod
    def sampled(self, wrist: Any, dt: float) -> Any:
        """Coefficients for a sample time `dt` [s] in a wrist; a NamedTuple with laws at ports."""

    def rest(self, wrist: Any, pressure: Number, angle: Number) -> Any:
        """State of the effect in a wrist at rest for long at a pressure [kPa] and a static angle [deg].

        For an effect that acts on the commanded pressure it is that, which a leak holds above the wrist's.
        """
        return Nothing()

    def beside(self, wrist: Any, pressure: Number) -> Number:
        """Angle [deg] that it adds to the loop's, at rest at a pressure [kPa]."""
        return 0.0

    def linear(self, wrist: Any, z: Any, dt: float, reach: tuple[float, float]) -> Linear:
        """What is linear of the effect at points z = exp(j omega dt), within pressures `reach` [kPa], which
        may be a small part of those that occur."""
        return Linear()

    @property
    def dead_time(self) -> Number:
        """Transport delay [s] that it puts between command and pressure."""
        return getattr(self, self.DELAY) if self.DELAY else 0.0

    def delayed(self, dead_time: Number) -> "Effect":
        """The same effect with another transport delay [s]; raises TypeError for one that has none."""
        if self.DELAY is None:
            raise TypeError(f"{self.NAME} has no dead time")
        return replace(self, **{self.DELAY: dead_time})

    @property
    def only_delays(self) -> bool:
        """Whether it does nothing but delay: what knows of a dead time, an inverse, say, knows all of it."""
        return False

    def lags(self, wrist: Any) -> tuple[Number, ...]:
        """Time constants [s] that it puts between command and pressure."""
        return ()

    def joint_lags(self, wrist: Any) -> tuple[Number, ...] | None:
        """Time constants [s] of the joint with the effect, None where the wrist's lag stays."""
        return None

    def no_bound(self, wrist: Any) -> str | None:
        """Why no performance bound is known of a wrist with the effect, or None."""
        return None if self.BOUND else "its wrist is not a monotone cascade"

    def bound_ends(self, wrist: Any) -> float | None:
        """Time [s] up to which a performance bound is claimed, None: for ever."""
        return None

    def obstacle(self, pressure: float, angle: float) -> str | None:
        """What keeps a wrist that needs a pressure [kPa] for it from an angle [deg], in words, or None."""
        return None


def dead_time_of(effects: Iterable[Effect]) -> Number:
    """Transport delay [s] of all effects together."""
    return sum((e.dead_time for e in effects), 0.0)
