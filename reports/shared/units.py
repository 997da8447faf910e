"""Units of the rig that is shown, and what its angle is counted from.  Words and labels are written in the
units of the built-in rig, deg, kPa and V; what is shown of a rig with others is translated where it leaves: a
line on a terminal, a page, a figure."""

import re
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any, TextIO

from plants.rig import Rig, built_in_rig

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SHOWN: ContextVar[Rig | None] = ContextVar("rig", default=None)

ANGLE = "Angle [deg]"
"""Label of an axis of the angle."""

_UNIT = re.compile(r"(?<![\w.])(degrees|degree|deg|kPa|V)(?!\w)")
_TEXT = re.compile(r"(<(script|style)\b.*?</\2>)|(?<=>)([^<]+)(?=<)", re.DOTALL)


def show(rig: Rig) -> None:
    """From now on show what is shown in the units of a rig, and its angle as the rig's plants count it."""
    _SHOWN.set(rig if rig.units != built_in_rig().units or rig.zero.angle else None)


def in_units(text: str) -> str:
    """A text in the units of the rig that is shown.

    >>> in_units("0 to 15 deg at 49.4 kPa/V")
    '0 to 15 deg at 49.4 kPa/V'
    """
    rig = _SHOWN.get()
    if rig is None:
        return text
    units = rig.units
    to = {"degrees": units.angle, "degree": units.angle, "deg": units.angle}
    to |= {"kPa": units.pressure, "V": units.command}
    return _UNIT.sub(lambda m: to[m[1]], text)


def page_in_units(page: str) -> str:
    """An HTML text whose words are in the units of the rig that is shown; tags, scripts and styles stay."""
    if _SHOWN.get() is None:
        return page
    return _TEXT.sub(lambda m: m[0] if m[1] else in_units(m[0]), page)


def relabel(figure: "Figure") -> None:
    """Put the labels of a figure into the units of the rig that is shown; an axis of the angle says what it
    is counted from, where that is not zero."""
    rig = _SHOWN.get()
    if rig is None:
        return
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        words = text.get_text()
        if rig.zero.angle and words == ANGLE:
            words = f"Angle from {rig.zero.angle:.4g} [deg]"
        text.set_text(in_units(words))


class StreamInUnits:
    """A stream to which text is written in the units of the rig that is shown."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    def write(self, text: str) -> int:
        """Write a text, translated."""
        return self.stream.write(in_units(text))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)
