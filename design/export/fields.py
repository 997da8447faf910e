"""Quantities that cross into C: name, unit and meaning of every field of a struct.

A state is a tree of NamedTuples without units; plant, hysteresis law and controller tell those of their own
(`plants.meanings.remembers`), of a field of several numbers once.  A field that is not described is not
exported, since a struct of numbers that nobody can name helps no one.
"""

import re
from typing import Any, NamedTuple

from plants.actuator.delay import DelayLine
from plants.errors import InputError
from plants.kernel import pytrees
from plants.meanings import MEANINGS


class Quantity(NamedTuple):
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

        >>> Quantity("angle", "deg", "").member, Quantity("late", "deg", "", 3).member
        ('angle_deg', 'late_deg')

        Of a unit that a rig's file names, what C takes in a name:

        >>> Quantity("angle", 'x; system("ls")', "").member
        'angle_x_system_ls'
        """
        named = f"{self.name}_{self.unit.replace('/', '_per_')}" if self.unit else self.name
        return re.sub(r"[\W_]+", "_", named, flags=re.ASCII).strip("_")

    @property
    def declaration(self) -> str:
        """The member as it is declared in C."""
        kind = "int" if self.counts else "double"
        return f"{kind} {self.member}[{self.size}];" if self.size > 1 else f"{kind} {self.member};"


REFERENCE = Quantity("reference", "deg", "angle that is asked for")
ANGLE = Quantity("angle", "deg", "angle that the sensor shows")
PRESSURE = Quantity("pressure", "kPa", "pressure that the sensor shows")
MANUAL = Quantity("manual", "", "above 0.5: the command is given by hand")
MANUAL_COMMAND = Quantity("manual_command", "V", "command by hand")
BY_HAND = (MANUAL, MANUAL_COMMAND)
COMMAND = Quantity("command", "V", "command to the regulator, within its range")


def described(state: Any) -> tuple[Quantity, ...]:
    """The leaves of a state as members of a struct, in order.

    Raises InputError for a field without unit and meaning.

    >>> from design.controllers.pi import PIState
    >>> [f.declaration for f in described(PIState(0.0))]
    ['double integral_kPa;']
    """
    paths = [name.replace(".", "_") for name in pytrees.names(state)]
    return tuple(Quantity(path, *known) for path, known in zip(paths, _known(state), strict=True))


def _known(state: Any) -> list[tuple[str, str]]:
    found: list[tuple[str, str]] = []
    for name, part in zip(state._fields, state, strict=True):
        numbers, key = len(pytrees.leaves(part)), (type(state), name)
        if not numbers:
            continue
        # What a state says of a part goes before what the part says of itself: a delay line holds anything.
        if key not in MEANINGS and hasattr(part, "_fields"):
            found += _known(part)
            continue
        if key not in MEANINGS and isinstance(part, tuple) and all(hasattr(p, "_fields") for p in part):
            found += [known for p in part for known in _known(p)]
            continue
        if key not in MEANINGS:
            raise InputError(
                f"{type(state).__name__}.{name}: a state without unit or meaning; decorate "
                f"{type(state).__name__} with plants.meanings.remembers"
            )
        found += [MEANINGS[key]] * numbers
    return found


def lines_of(state: Any) -> list[int]:
    """Number of the first leaf of each delay line in a state."""
    return pytrees.places(state, DelayLine)
