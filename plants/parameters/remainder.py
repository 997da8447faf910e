"""What a fitted plant leaves of a channel: part of the plant, for whoever designs on it or checks a log."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from plants.errors import InputError
from plants.toml import check_keys, is_number

BANDS = (0.0, 0.1, 1.0, 10.0)
"""Edges [Hz] of the bands that a residual's spectrum is told in; the last is open."""

CHANNELS = ("angle_deg", "pressure_kPa")
"""Channels of which a residual is told."""


@dataclass(frozen=True)
class RemainderSize:
    """What is left of a channel on held-out recordings, without the noise.

    rms, largest: in the channel's unit, the largest once the noise is averaged out; correlation_s [s]: lag at
    which its autocovariance has fallen to 1/e; correlation_way: likewise, along the way that the simulated
    channel goes, in its unit; noise: floor of the channel, in its unit; share_of_range: rms over the range
    of what was measured; spectrum: share of its power in bands, by lower edge [Hz].
    """

    rms: float
    largest: float
    correlation_s: float
    correlation_way: float
    noise: float
    share_of_range: float
    spectrum: Mapping[float, float]


NUMBERS = ("rms", "largest", "correlation_s", "correlation_way", "noise", "share_of_range")


def remainder_table(left: RemainderSize) -> dict[str, Any]:
    """A residual as a TOML table."""
    return {n: float(getattr(left, n)) for n in NUMBERS} | {
        "spectrum": [float(left.spectrum.get(edge, 0.0)) for edge in BANDS]
    }


def parse_remainders(table: Any, where: str) -> dict[str, RemainderSize]:
    """Remainders by channel of the ``[remainder]`` table of a parameter set; `where` begins the errors.

    Raises InputError, in one line, for an unknown channel or key and for what is no number, or negative.
    """
    if not isinstance(table, dict):
        raise InputError(f"{where}: remainder must be [remainder.CHANNEL] tables of {' and '.join(CHANNELS)}")
    check_keys(table, CHANNELS, f"{where}: remainder")
    return {n: _parsed(own, f"{where}: remainder.{n}") for n, own in table.items()}


def _parsed(own: Any, where: str) -> RemainderSize:
    if not isinstance(own, dict):
        raise InputError(f"{where}: must be a table with {', '.join(NUMBERS)}")
    check_keys(own, (*NUMBERS, "spectrum"), where)
    for name in NUMBERS:
        value = own.get(name)
        if not is_number(value) or value < 0.0:
            raise InputError(f"{where}: {name} = {value!r} is not a finite number, or is negative")
    shares = own.get("spectrum", [0.0] * len(BANDS))
    if not (isinstance(shares, list) and len(shares) == len(BANDS) and all(map(is_number, shares))):
        raise InputError(f"{where}: spectrum must be {len(BANDS)} shares, of the bands from {BANDS} Hz")
    spectrum = dict(zip(BANDS, map(float, shares), strict=True))
    return RemainderSize(**{n: float(own[n]) for n in NUMBERS}, spectrum=spectrum)
