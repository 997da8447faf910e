"""Units as recorders write them, into those of the rig: by pint."""

import re
from functools import cache
from typing import Any

from plants.errors import InputError

SPELLED = {
    "°": "deg", "º": "deg", "grad": "deg", "mbar": "mbar", "hpa": "hPa", "kg/cm²": "kgf/cm**2", "sec": "s",
    "sek": "s", "%": "percent", "volt": "V", "volts": "V", "bar(g)": "bar", "barg": "bar", "bar g": "bar",
    "kpag": "kPa", "kpa": "kPa", "mpa": "MPa", "psig": "psi", "rad": "rad", "degrees": "deg", "°c": "degC",
}  # fmt: skip
"""What recorders write, and pint does not take as it is meant: ``grad`` is degrees to a German logger, and
gons to pint."""

KINDS = {"command": "V", "pressure": "kPa", "angle": "deg", "reference": "deg", "time": "s"}
"""Units that a campaign is kept in."""

SUCH = {
    "command": "V, mV, % or counts", "pressure": "kPa, Pa, MPa, hPa, bar, mbar or psi",
    "angle": "deg, rad, mm, um or counts", "reference": "deg, rad, mm, um or counts", "time": "s, ms or us",
}  # fmt: skip
"""Units of each role that an error proposes; every other that pint knows is understood."""


FROM_VACUUM = re.compile(
    r"(?:[ _]?[(\[]?abs(?:ol?ut\w*)?\.?[)\]]?|(?<=psi|bar)[(\[]?a[)\]]?)$", re.IGNORECASE
)
"""The end of a unit of pressure that says that it counts from vacuum."""

COUNTED = dict.fromkeys(("counts", "count", "cnts", "cnt", "lsb", "ticks", "pulses"), "counts")
MOVED = {"mm": "mm", "cm": "cm", "um": "um", "µm": "um", "μm": "um", **COUNTED}
KEPT = {"command": {"%": "%", "percent": "%", **COUNTED}, "angle": MOVED, "reference": MOVED}
"""Units of each role that stay as they are, by what recorders write: of a duty, of a converter or an encoder,
of a motion that is no rotation."""

AS_THEY_ARE = frozenset(name for names in KEPT.values() for name in names.values())
"""All of them."""


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


@cache
def quantity(unit: str) -> str | None:
    """What a unit measures: ``command``, ``pressure``, ``angle``, ``time`` or ``other``; None for one that is
    not known.

    >>> quantity("mbar"), quantity("°"), quantity("mV"), quantity("ms"), quantity("°C"), quantity("counts7")
    ('pressure', 'angle', 'command', 'time', 'other', None)
    """
    parsed = _parsed(unit)
    if parsed is None:
        return None
    for kind, standard in KINDS.items():
        if kind != "reference" and parsed.is_compatible_with(standard):
            # To pint an angle has no dimension, as a share has none.
            return kind if kind != "angle" or "radian" in str(_base(parsed)) else "other"
    return "other"


def is_absolute(unit: str) -> bool:
    """Whether a unit says that a pressure counts from vacuum.

    >>> [u for u in ("mbar abs", "psia", "bar(a)", "kPa_absolute", "bar", "psig") if is_absolute(u)]
    ['mbar abs', 'psia', 'bar(a)', 'kPa_absolute']
    """
    return bool(FROM_VACUUM.search(unit.strip())) and quantity(unit) == "pressure"


def kept(unit: str, role: str) -> str:
    """The unit in which a role stays; "" where it is put into the standard one.

    >>> kept("percent", "command"), kept("mm", "angle"), kept("mV", "command")
    ('%', 'mm', '')
    """
    return KEPT.get(role, {}).get(unit.strip().lower(), "")


def factor(unit: str, role: str, where: str) -> float:
    """What a number in a unit is to be multiplied with, to be in that of a role.

    A unit that is `kept` is left as it is.  Raises InputError for a unit that is unknown and for
    one of another quantity.

    >>> factor("bar", "pressure", "log"), round(factor("rad", "angle", "log"), 5)
    (100.0, 57.29578)
    >>> factor("%", "command", "log")
    1.0
    """
    if kept(unit, role):
        return 1.0
    kind = quantity(unit)
    if kind is None or kind != ("angle" if role == "reference" else role):
        raise InputError(f"{where}: the unit {unit!r} is none of {role}; give one such as {SUCH[role]}")
    parsed = _parsed(unit)
    return float(f"{_registry().Quantity(1.0, parsed).to(KINDS[role]).magnitude:.12g}")


def _base(parsed: Any) -> Any:
    return _registry().Quantity(1.0, parsed).to_base_units().units


@cache
def _parsed(unit: str) -> Any:
    said = unit.strip()
    if not said:
        return None
    plain = FROM_VACUUM.sub("", said)
    try:
        return _registry().Unit(SPELLED.get(plain.lower(), plain))
    except Exception:  # pint raises of many kinds for what is no unit, down to the tokenizer's
        return None
