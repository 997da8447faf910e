"""Hysteresis laws: pressure to static angle, with memory; `plants.hysteresis.law` says what one is.

A law is a file here and a line in `LAWS`.  A plant's TOML names its law, and a set of parameters is
recognised by their names, which no two laws share but for the rest pressure.
"""

from collections.abc import Iterable, Mapping
from typing import Any

from plants.hysteresis.four_segment import FourSegment, Memory
from plants.hysteresis.law import SIDES, STARTS, Bend, HysteresisLaw, Role, Side, Start
from plants.hysteresis.prandtl_ishlinskii import PlayMemory, PrandtlIshlinskii
from plants.hysteresis.rough_loop import RoughLoop

LAWS: dict[str, type[HysteresisLaw]] = {
    law.NAME: law
    for law in (
        FourSegment,
        PrandtlIshlinskii,
    )
}
"""The laws by name; the first is the paper's."""

__all__ = [
    "LAWS", "SIDES", "STARTS", "Bend", "FourSegment", "HysteresisLaw", "Memory", "PlayMemory",
    "PrandtlIshlinskii", "Role", "RoughLoop", "Side", "Start",
    "law_of", "register", "with_values",
]  # fmt: skip


def register(law: type[HysteresisLaw]) -> None:
    """Make a law known that is not in this package.

    Raises ValueError for a name, or a name of a parameter, that another law has.
    """
    for other in LAWS.values():
        shared = (set(law.kinds()) & set(other.kinds())) - {"rest_pressure"}
        if law.NAME == other.NAME or shared:
            raise ValueError(
                f"hysteresis law {law.NAME!r}: shares {sorted(shared) or 'its name'} with {other.NAME!r}"
            )
    LAWS[law.NAME] = law


def law_of(names: Iterable[str]) -> type[HysteresisLaw]:
    """The law whose parameters a set with these names has.

    Raises KeyError where no law has them all.

    >>> law_of(["a1", "w1", "a2", "w2", "s", "rest_pressure", "Tw"]).NAME
    'four-segment'
    """
    given = set(names)
    for law in LAWS.values():
        if law.fits(given):
            return law
    raise KeyError(f"no hysteresis law has its parameters among {', '.join(sorted(given))}")


def with_values(values: Mapping[str, Any]) -> HysteresisLaw:
    """The law, with its parameters, of a flat mapping of values."""
    return law_of(values).from_values(values)
