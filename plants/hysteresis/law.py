"""What a hysteresis law is: pressure to static angle, with a memory, in a form that everything else can use.

A law is a frozen dataclass of parameters (floats, arrays of lanes or CasADi symbols) with

    initial, step                 its memory, a NamedTuple with the static angle `h`, and how it moves
    ascending, descending         the two outer branches, between which every memory lies, and
    ascending_pressure, ...       their inverses
    resting, recalled, moved      memories that are at rest, guessed from a measurement, corrected
    pressure_for, turn            the inverse with memory, and the way back after a reversal
    branches                      the slopes that its branches have: what linear theory needs
    problem                       why its parameters make no loop
    kinds, from_values, guess     its parameters by name, and a first guess of them from a log

All but `branches`, `problem` and `guess` are NumPy ufuncs, so that they compute with floats, compile to
kernels and export to C from the same lines.  A law has to be rate-independent: however many steps a
monotone move is cut into, the result is the same.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple

import numpy as np

from plants.hysteresis.rough_loop import RoughLoop
from plants.parameters.spec import Kind

Number = Any
Start = Literal["virgin", "line1", "line2", "inside"]
STARTS: tuple[Start, ...] = ("virgin", "line1", "line2", "inside")
"""How a plant came to rest: never moved (the initial curve), on the ascending branch (line 1), on the
descending branch (line 2), or half-way between the two, as after a reversal."""

Side = Literal["ascending", "descending", "inner"]
Role = Literal["outer", "inner", "width"]
SIDES: tuple[Side, ...] = ("ascending", "descending", "inner")
"""Sides of a loop: its two outer branches, and what lies between them."""

REST_PRESSURE = Kind("kPa", "pressure at which the wrist starts and h = 0", -50.0, 500.0)


class Bend(NamedTuple):
    """What effects do to a loop in one sample: shifts of the ascending and of the descending branch [deg],
    and a factor of the slope between them."""

    low: Number
    high: Number
    slope: Number


@dataclass(frozen=True)
class HysteresisLaw(ABC):
    """Base of all laws.

    NAME: as in a plant's TOML; DEAD_ZONE: whether the law has an initial curve of slope 0, which is left
    once, for good; its memory then has a `virgin`, 1.0 until it is left, else 0.0.  Every law has a
    `rest_pressure` [kPa], at which h = 0 on the initial curve.  SHIFTS: whether only the rest pressure moves
    the loop as a whole, so that it is fitted where a recording need not start there.  MONOTONE: whether a
    pressure signal that is never below another gives an angle that is never below either, from ordered
    memories; a play does, and the performance bound (`design.limit`) holds for such laws only.  NEUTRAL: of
    parameters that a law can do without, by name, the value at which they change nothing.
    """

    NAME: ClassVar[str]
    SHIFTS: ClassVar[bool] = False
    DEAD_ZONE: ClassVar[bool] = False
    MONOTONE: ClassVar[bool] = False
    NEUTRAL: ClassVar[Mapping[str, float]] = {}

    if TYPE_CHECKING:

        @property
        def rest_pressure(self) -> Number:
            """A field of every law [kPa]."""

    @classmethod
    @abstractmethod
    def kinds(cls, names: Iterable[str] = ()) -> dict[str, Kind]:
        """Unit, meaning and bounds of each parameter, in order; `names` are those that a set has, for a law
        whose number of parameters varies."""

    @classmethod
    def fits(cls, names: Iterable[str]) -> bool:
        """Whether a set with parameters of these names is one of this law."""
        return set(cls.kinds(names)) <= set(names)

    @property
    def values(self) -> dict[str, Number]:
        """The parameters by name, flat."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @classmethod
    def from_values(cls, values: Mapping[str, Number]) -> "HysteresisLaw":
        """The law with the parameters that `values` has of it."""
        return cls(**{f.name: values[f.name] for f in fields(cls)})

    @classmethod
    @abstractmethod
    def roles(cls, names: Iterable[str]) -> dict[Role, tuple[str, ...]]:
        """Which parameters make the slopes of the outer branches, the slope after a reversal and the loop's
        width: they are varied together where nobody measured them."""

    @classmethod
    @abstractmethod
    def guess(cls, loop: RoughLoop) -> dict[str, float]:
        """Parameters of a loop that is known roughly."""

    @abstractmethod
    def problem(self, low: float, high: float) -> str | None:
        """Why the parameters make no loop between two pressures [kPa], or None if they do."""

    def kept_apart(self, low: float, high: float) -> dict[str, tuple[float, float]]:
        """Bounds of parameters, near these, within which they make a loop between two pressures [kPa]; empty
        for a law whose bounds see to that."""
        return {}

    @abstractmethod
    def initial(self) -> Any:
        """The memory of a plant that never moved from its rest pressure."""

    def unmoved(self, angle: Number) -> Any:
        """The memory of a plant that never moved from an angle [deg] at which it rests; None where the law
        has one initial curve only, from 0."""
        return None if np.any(angle) else self.initial()

    def counted_from(self, angle: float) -> "HysteresisLaw | None":
        """The same loop with an angle [deg] counted as 0, where it then rests in the middle of its width;
        None for a law that is no other one of its kind there."""
        return None

    @abstractmethod
    def step(self, memory: Any, before: Number, after: Number, bend: Bend | None = None) -> Any:
        """The memory after the pressure has moved monotonically from `before` to `after` [kPa]; `bend`: what
        effects make of the loop at `after`."""

    @abstractmethod
    def ascending(self, pressure: Number) -> Number:
        """Angle [deg] of the outer branch on which the pressure rises, the lower one."""

    @abstractmethod
    def descending(self, pressure: Number) -> Number:
        """Angle [deg] of the outer branch on which the pressure falls, the upper one."""

    @abstractmethod
    def ascending_pressure(self, angle: Number) -> Number:
        """Pressure [kPa] at which the ascending branch has an angle [deg]."""

    @abstractmethod
    def descending_pressure(self, angle: Number) -> Number:
        """Pressure [kPa] at which the descending branch has an angle [deg]."""

    def rise(self, pressure: Number) -> tuple[Number, Number]:
        """What the ascending and the descending branch have of the angle [deg] without the loop's width;
        effects that soften a plant act on it."""
        middle = 0.5 * (self.ascending(pressure) + self.descending(pressure))
        return middle, middle

    def halves(self, pressure: Number) -> tuple[Number, Number]:
        """How far [deg] the ascending branch lies below its `rise`, and the descending one above."""
        half = 0.5 * (self.descending(pressure) - self.ascending(pressure))
        return half, half

    @property
    @abstractmethod
    def steepness(self) -> tuple[Number, Number]:
        """Typical slopes [deg/kPa] of the ascending and of the descending branch."""

    @property
    @abstractmethod
    def flattest(self) -> Number:
        """Slope [deg/kPa] just after a reversal."""

    def first_slope(self, memory: Any) -> Number:
        """Slope [deg/kPa] along which a move against the one before begins."""
        return self.flattest

    @abstractmethod
    def resting(
        self, start: Start, angle: Number, pressure: Number, low: Number = 0.0, high: Number = 0.0
    ) -> Any:
        """The memory of a plant that holds still at a static angle [deg] and a pressure [kPa], having come
        there by `start`; low, high: shifts of the branches there [deg]."""

    @abstractmethod
    def recalled(self, angle: Number, pressure: Number) -> Any:
        """A memory that rests at a measured angle [deg] and pressure [kPa]; what lies outside the loop is
        moved to its nearest branch."""

    def doubted(self, memory: Any, doubt: Number) -> Any:
        """The memory without the belief to be on the initial curve where `doubt` is true; the same for a law
        whose memory does not tell."""
        return memory

    @abstractmethod
    def moved(self, memory: Any, shift: Number, pressure: Number) -> Any:
        """The memory with its angle moved by a shift [deg] as far as the loop allows at a pressure [kPa]: the
        correction of an observer."""

    @abstractmethod
    def pressure_for(self, memory: Any, before: Number, angle: Number) -> Number:
        """Pressure [kPa] after a monotone move from `before` [kPa] that takes the loop to an angle [deg]: the
        exact inverse with memory.  Not bounded: `clamped` keeps an angle within reach."""

    @abstractmethod
    def turn(self, memory: Any, before: Number, end: Number, up: Number) -> tuple[Number, Number]:
        """Pressure [kPa] and angle [deg] on the way from `before` to `end` [kPa] (`up` true: the pressure
        rises) at which the slope changes most, where the first slope ends; beyond `end` it is `end`'s."""

    @abstractmethod
    def branches(
        self, low: float, high: float, within: tuple[float, float] | None = None
    ) -> dict[str, float]:
        """Slopes [deg/kPa] of the branches on which a loop can work between two pressures [kPa], by name; all
        that occur lie between the least and the largest.  Names do not depend on the pressures; two ends
        of one branch have their names after a comma.  within: pressures [kPa] that are never left; any
        where not given."""

    def straight(self) -> bool:
        """Whether the two outer branches are straight lines."""
        return False

    def sides(self, branch: str) -> tuple[Side, ...]:
        """Where in the loop a branch of `branches` lies: all sides, unless a law knows better."""
        return SIDES

    def reachable(self, low: Number, high: Number) -> tuple[Number, Number]:
        """Angles [deg] that pressures from `low` to `high` [kPa] reach whatever the memory: from the
        descending branch at the one to the ascending branch at the other."""
        return self.descending(low), self.ascending(high)

    def clamped(self, angle: Number, low: Number, high: Number) -> Number:
        """The angle [deg] that is nearest to `angle` among those that pressures from `low` to `high` [kPa]
        reach whatever the memory; `pressure_for` of it lies between these pressures."""
        least, most = self.reachable(low, high)
        return np.minimum(np.maximum(angle, least), most)

    def rest_between(self, angle: Number) -> dict[Start, Number]:
        """The pressures [kPa] at which a plant rests at an angle [deg], by how it came there."""
        low, high = self.descending_pressure(angle), self.ascending_pressure(angle)
        return {"line1": high, "line2": low, "inside": (low + high) / 2}
