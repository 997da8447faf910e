"""What a pressure is counted from: the pressure of the air, vacuum, or, below that of the air, downwards."""

import re

import numpy as np

from plants.measured.formats.channel import LoggedChannel
from plants.measured.formats.columns import ATMOSPHERE, is_vacuum
from plants.measured.formats.units import is_absolute
from plants.measured.importing.lead import lead

BAROMETER, ALTITUDES = "hPa", (80.0, 106.0)
"""The unit in which pressures above vacuum are told, and what those of the air [kPa] are on the ground."""

RARE = 0.02
"""Share of the samples that may lie lower than a lowest pressure."""

DEEPENS = -0.5
"""Correlation of the pressure with the command before it, from which on the one falls as the other rises."""


def above_vacuum(channel: LoggedChannel, to_kpa: float) -> bool:
    """Whether a pressure may count from vacuum: by its values it starts at that of the air and hardly ever
    falls below, by its name it never falls as low as no air does."""
    least = to_kpa * float(np.quantile(channel.values, RARE))
    if _named_absolute(channel):
        return least > ALTITUDES[0]
    first = to_kpa * float(np.median(channel.values[:3]))
    return all(ALTITUDES[0] < p < ALTITUDES[1] for p in (first, least))


def counts_from_vacuum(channel: LoggedChannel) -> bool:
    """Whether a name or a unit says so of a pressure that may."""
    return channel.unit == BAROMETER or _named_absolute(channel)


def _named_absolute(channel: LoggedChannel) -> bool:
    return is_absolute(channel.unit) or bool(
        re.search(r"(?:^|[^a-z])abs(?:[^a-z]|$|ol)", channel.name.lower())
    )


def of_air(channel: LoggedChannel, to_kpa: float) -> float:
    """The pressure of the air, in the unit of a channel that is an absolute pressure at or below it; 0 for
    any other.

    >>> t = np.arange(2000) * 0.01
    >>> of_air(LoggedChannel("p", "kPa", t, 70.0 + 30.0 * np.cos(t)), 1.0), ATMOSPHERE
    (101.325, 101.325)
    """
    low, high = (to_kpa * float(np.quantile(channel.values, q)) for q in (RARE, 1.0 - RARE))
    whole = 0.0 < low < ALTITUDES[0] < high < ALTITUDES[1]
    return ATMOSPHERE / to_kpa if whole else 0.0


def deepens(command: LoggedChannel, pressure: LoggedChannel, air: float = 0.0) -> bool:
    """Whether a pressure [kPa] below that of the air, which is told in the unit of the channel, falls as the
    command [V, %] rises.

    >>> t = np.arange(2000) * 0.01
    >>> duty = LoggedChannel("duty", "%", t, 50.0 + 40.0 * np.sin(t))
    >>> deepens(duty, LoggedChannel("p", "kPa", t, -30.0 - 20.0 * np.sin(t - 0.3)))
    True
    """
    lowest, highest = (float(v) - air for v in (pressure.values.min(), pressure.values.max()))
    if not is_vacuum(lowest, highest):
        return False
    late, _ = lead(command, pressure)
    inside = pressure.time - late >= command.time[0]
    before = np.interp(pressure.time[inside] - late, command.time, command.values)
    return bool(np.ptp(before) > 0.0 and np.corrcoef(before, pressure.values[inside])[0, 1] < DEEPENS)
