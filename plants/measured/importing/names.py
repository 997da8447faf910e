"""What names of columns look like, and the units in them."""

import re

from plants.measured.formats.units import COUNTED, KEPT, quantity

DURATION = r"(?:milli|micro|nano|m|u|µ|n)s(?:ec(?:ond)?s?)?|sec(?:ond)?s?"
"""Units of time that may be a whole name, as ``millis`` of a microcontroller."""

ASKED = r"^d?p(?:d|set|des|soll|cmd)\d*(?:_|$)|^d?p\d*_(?:d|set|des|soll|cmd|ref)(?:_|$)"
"""A pressure that is asked for, of a regulator."""

HINTS = {
    "time_s": rf"^t$|time|stamp|zeit|^(?:{DURATION})$",
    "reference_deg": r"ref|set.?point|target|desired|soll|_des$|^[rw]$|^sp$",
    "command_V": rf"command|cmd|volt|dac|duty|pwm|^u$|input|_v$|stell|spannung|plunger|{ASKED}",
    "pressure_kPa": r"press|kpa|hpa|bar|psi|^p\d?$|druck",
    "angle_deg": r"angle|theta|bend|deg|rad|posit|\bpos|_pos|flex|^y$|output|winkel|^enc|displ|^weg\b",
}
"""What names of columns look like, by the standard name; the first that matches is taken."""

OF_COMMAND = re.compile(r"(?:^|[_ .\[(])(?:(pct|perc|percent)|(counts|lsb))[\])]?$", re.IGNORECASE)
"""The end of the name of a duty in percent, or of a command in counts of a converter."""

LENGTHS = tuple(KEPT["angle"])
"""Units of a motion that is no rotation, which stays as it is."""


def unit_in(name: str) -> str:
    """The unit at the end of a name, or that is the name of a time; "" where there is none.

    >>> unit_in("angle_deg"), unit_in("p [bar]"), unit_in("u"), unit_in("wrist_p"), unit_in("pos_mm")
    ('deg', 'bar', '', '', 'mm')
    >>> unit_in("millis"), unit_in("timestamp_us"), unit_in("t_micros"), unit_in("duty_cycle")
    ('millis', 'us', 'micros', '')
    >>> unit_in("duty_pct"), unit_in("Duty (percent)"), unit_in("DAC_counts")
    ('%', '%', 'counts')
    """
    if of_command := OF_COMMAND.search(name):
        return "%" if of_command[1] else "counts"
    if re.fullmatch(DURATION, name.lower()):
        return name.lower()
    found = re.search(rf"[_ .]\(?\[?([A-Za-z°%µμ]{{1,6}}|{DURATION})\]?\)?$", name)
    unit = found[1] if found else ""
    if unit in LENGTHS:
        return unit
    known = quantity(unit) not in (None, "other") and unit not in ("cycle", "turn")
    return unit if known and len(unit) + (unit in "VAs") > 1 else ""


def is_counted(name: str) -> bool:
    """Whether a word of a name says that its values are counts, as those of an encoder.

    >>> [n for n in ("enc_cnt", "EncoderCounts", "cnt_raw", "ticks2", "encoder", "pct") if is_counted(n)]
    ['enc_cnt', 'EncoderCounts', 'cnt_raw', 'ticks2']
    """
    return any(word.lower() in COUNTED for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+", name))
