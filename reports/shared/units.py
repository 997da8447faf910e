"""Units of the rig that is shown.  Words and labels are written in those of the built-in rig, deg, kPa and V;
what is shown of a rig with others is translated where it leaves: a line on a terminal, a page, a figure."""

import re
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any, TextIO

from plants.rig import Rig, Units, built_in_rig

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SHOWN: ContextVar[Units | None] = ContextVar("units", default=None)

_UNIT = re.compile(r"(?<![\w.])(degrees|degree|deg|kPa|V)(?!\w)")
_TEXT = re.compile(r"(<(script|style)\b.*?</\2>)|(?<=>)([^<]+)(?=<)", re.DOTALL)


def show(rig: Rig) -> None:
    """From now on show what is shown in the units of a rig."""
    _SHOWN.set(None if rig.units == built_in_rig().units else rig.units)


def in_units(text: str) -> str:
    """A text in the units of the rig that is shown.

    >>> in_units("0 to 15 deg at 49.4 kPa/V")
    '0 to 15 deg at 49.4 kPa/V'
    """
    units = _SHOWN.get()
    if units is None:
        return text
    to = {"degrees": units.angle, "degree": units.angle, "deg": units.angle}
    to |= {"kPa": units.pressure, "V": units.command}
    return _UNIT.sub(lambda m: to[m[1]], text)


def page_in_units(page: str) -> str:
    """An HTML text whose words are in the units of the rig that is shown; tags, scripts and styles stay."""
    if _SHOWN.get() is None:
        return page
    return _TEXT.sub(lambda m: m[0] if m[1] else in_units(m[0]), page)


def relabel(figure: "Figure") -> None:
    """Put the labels of a figure into the units of the rig that is shown."""
    if _SHOWN.get() is None:
        return
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        text.set_text(in_units(text.get_text()))


class StreamInUnits:
    """A stream to which text is written in the units of the rig that is shown."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    def write(self, text: str) -> int:
        """Write a text, translated."""
        return self.stream.write(in_units(text))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)
