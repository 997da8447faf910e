"""What a fitted plant leaves of a channel: part of the plant, for whoever designs on it or checks a log."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plants.errors import InputError
from plants.toml import check_keys, is_number

BANDS = (0.0, 0.1, 1.0, 10.0)
"""Edges [Hz] of the bands that a residual's spectrum is told in; the last is open."""

CHANNELS = ("angle_deg", "pressure_kPa")
"""Channels of which a residual is told."""


@dataclass(frozen=True)
class UncertaintyWeight:
    """The part of a residual that follows the simulated channel linearly, as unmodelled dynamics: the rig is
    the plant times 1 + W delta, delta any stable system of gain at most 1.

    W(s) = (high s/w + low) / (s/w + 1), w = 2 pi corner_Hz: gain [1] `low` at low and `high` at high
    frequencies.  known_Hz: up to which frequency the recordings tell of it; above, it is extrapolated.

    Source: Skogestad, Postlethwaite, Multivariable Feedback Control, 2nd ed. 2005, section 7.4.

    >>> weight = UncertaintyWeight(0.1, 0.5, 1.0, 3.0)
    >>> np.round(np.abs(weight.response(2.0 * np.pi * np.array([0.0, 1.0, 1e6]))), 3).tolist()
    [0.1, 0.361, 0.5]
    """

    low: float
    high: float
    corner_Hz: float
    known_Hz: float

    def response(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """W at frequencies [rad/s], of their shape."""
        s = 1j * np.asarray(omega, float) / (2.0 * np.pi * self.corner_Hz)
        found: NDArray[np.complex128] = (self.high * s + self.low) / (s + 1.0)
        return found


@dataclass(frozen=True)
class RemainderSize:
    """What is left of a channel on held-out recordings, without the noise.

    rms, largest: in the channel's unit, the largest once the noise is averaged out; correlation_s [s]: lag at
    which its autocovariance has fallen to 1/e; correlation_way: likewise, along the way that the simulated
    channel goes, in its unit; noise: floor of the channel, in its unit; share_of_range: rms over the range
    of what was measured; spectrum: share of its power in bands, by lower edge [Hz]; weight: of what follows
    the simulated channel linearly, None where nothing does.
    """

    rms: float
    largest: float
    correlation_s: float
    correlation_way: float
    noise: float
    share_of_range: float
    spectrum: Mapping[float, float]
    weight: UncertaintyWeight | None = None


NUMBERS = ("rms", "largest", "correlation_s", "correlation_way", "noise", "share_of_range")


def remainder_table(left: RemainderSize) -> dict[str, Any]:
    """A residual as a TOML table."""
    table: dict[str, Any] = {n: float(getattr(left, n)) for n in NUMBERS}
    table["spectrum"] = [float(left.spectrum.get(edge, 0.0)) for edge in BANDS]
    return table if left.weight is None else table | {"weight": asdict(left.weight)}


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
    check_keys(own, (*NUMBERS, "spectrum", "weight"), where)
    numbers = _numbers(own, NUMBERS, where)
    shares = own.get("spectrum", [0.0] * len(BANDS))
    if not (isinstance(shares, list) and len(shares) == len(BANDS) and all(map(is_number, shares))):
        raise InputError(f"{where}: spectrum must be {len(BANDS)} shares, of the bands from {BANDS} Hz")
    spectrum = dict(zip(BANDS, map(float, shares), strict=True))
    weight = own.get("weight")
    return RemainderSize(
        **numbers, spectrum=spectrum, weight=None if weight is None else _weight(weight, f"{where}.weight")
    )


def _weight(own: Any, where: str) -> UncertaintyWeight:
    names = tuple(UncertaintyWeight.__dataclass_fields__)
    if not isinstance(own, dict):
        raise InputError(f"{where}: must be a table with {', '.join(names)}")
    check_keys(own, names, where)
    numbers = _numbers(own, names, where)
    if numbers["corner_Hz"] == 0.0:
        raise InputError(f"{where}: corner_Hz = 0; give the frequency [Hz] between low and high gain")
    return UncertaintyWeight(**numbers)


def _numbers(own: Mapping[str, Any], names: tuple[str, ...], where: str) -> dict[str, float]:
    for name in names:
        value = own.get(name)
        if not is_number(value) or value < 0.0:
            raise InputError(f"{where}: {name} = {value!r} is not a finite number, or is negative")
    return {n: float(own[n]) for n in names}
