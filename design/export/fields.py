"""Quantities that cross into C: name, unit and meaning of every field of a struct.

A state is a tree of NamedTuples without units, so each of their fields is described here once; one that
is not described is not exported, since a struct of numbers that nobody can name helps no one.
"""

from typing import Any, NamedTuple

from plants import tree
from plants.delay import DelayLine
from plants.errors import InputError


class Field(NamedTuple):
    """A member of a struct: name in C without its unit, unit ("" where it has none), meaning; how many
    numbers it holds, and whether it counts."""

    name: str
    unit: str
    meaning: str
    size: int = 1
    counts: bool = False

    @property
    def member(self) -> str:
        """The member's name, its unit included.

        >>> Field("angle", "deg", "").member, Field("late", "deg", "", 3).member
        ('angle_deg', 'late_deg')
        """
        return f"{self.name}_{self.unit.replace('/', '_per_')}" if self.unit else self.name

    @property
    def declaration(self) -> str:
        """The member as it is declared in C."""
        kind = "int" if self.counts else "double"
        return f"{kind} {self.member}[{self.size}];" if self.size > 1 else f"{kind} {self.member};"


REFERENCE = Field("reference", "deg", "angle that is asked for")
ANGLE = Field("angle", "deg", "angle that the sensor shows")
PRESSURE = Field("pressure", "kPa", "pressure that the sensor shows")
COMMAND = Field("command", "V", "command to the regulator, within its range")

DESCRIBED = {
    "PIState.integral": ("kPa", "integral part of the command, gain included"),
    "LQIState.target": ("kPa", "pressure that is commanded"),
    "LQIState.static_angle": ("deg", "static angle as observed"),
    "LQIState.angle": ("deg", "angle as observed"),
    "LQIState.pressure": ("kPa", "pressure of the sample before"),
    "LQIState.lack": ("kPa", "mean of commanded less measured pressure"),
    "LQIState.reference": ("deg", "reference of the sample before"),
    "State.pressure": ("kPa", "pressure of the model"),
    "State.angle": ("deg", "angle of the model"),
    "Memory.h": ("deg", "static angle: the memory of the loop"),
    "Memory.virgin": ("", "1 before the wrist has met a line of its loop, 0 afterwards"),
    "Course.outside": ("", "samples in which the reference was out of reach and the nearest was taken"),
    "FeedforwardState.trim": ("kPa", "pressure needed beside the model's to hold still at the start"),
    "FeedforwardPIState.trim": ("kPa", "integral part of the command, gain included"),
    "DelayLine.near": ("deg", "angle of the model so many whole samples ago"),
    "DelayLine.far": ("deg", "angle of the model one sample before that"),
    "DelayLine.newest": ("deg", "angle of the model put into the delay last"),
    "ObserverState.angle": ("deg", "angle as observed"),
    "ObserverState.pressure": ("kPa", "pressure of the sample before"),
    "Believed.lack": ("kPa", "what the regulator lacks of the pressure that is commanded"),
    "Believed.shift": ("deg", "shift of the angle, such as by a load"),
}
"""Unit and meaning of the fields of states, by type and name."""


def described(state: Any) -> tuple[Field, ...]:
    """The leaves of a state as members of a struct, in order.

    Raises InputError for a field that `DESCRIBED` lacks.

    >>> from design.controllers.pi import PIState
    >>> [f.declaration for f in described(PIState(0.0))]
    ['double integral_kPa;']
    """
    paths = [name.replace(".", "_") for name in tree.names(state)]
    return tuple(Field(path, *known) for path, known in zip(paths, _known(state), strict=True))


def _known(state: Any) -> list[tuple[str, str]]:
    found: list[tuple[str, str]] = []
    for name, part in zip(getattr(state, "_fields", range(len(state))), state, strict=True):
        if isinstance(part, tuple):
            found += _known(part)
            continue
        key = f"{type(state).__name__}.{name}"
        if key not in DESCRIBED:
            raise InputError(f"{key}: a state without unit or meaning; add it to design/export/fields.py")
        found.append(DESCRIBED[key])
    return found


def lines_of(state: Any) -> list[int]:
    """Number of the first leaf of each delay line in a state."""
    return tree.places(state, DelayLine)
