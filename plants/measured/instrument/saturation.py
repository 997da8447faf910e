"""Angle sensors that saturate: what they show between two ends only, and where those are.

Rows at an end tell that the true angle is not within it, and no more: a simulation is compared as such a
sensor reads it (`plants.measured.campaigns.playback`).
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plants.errors import InputError
from plants.measured.campaigns.campaign import Campaign
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.noise import noise_floor, resolution
from plants.measured.instrument.remark import Habit, Remark

Array = NDArray[np.float64]
Range = tuple[float, float]
ANGLE = "angle_deg"
ANYTHING: Range = (-np.inf, np.inf)

REST_ROWS = 30
"""Rows at exactly zero that make a sensor rest."""

FLAT = 30
"""Rows in which a noisy channel stays at one and the same extreme value: a clipped sensor."""

DITHER = 0.7
"""Noise, in steps of the sensor, from which on a channel does not stay at one value by itself."""


def ranged(campaign: Campaign, remarks: list[Remark]) -> Campaign:
    """The campaign with the range of the angle sensor where it saturates: as campaign.toml states it, else at
    exactly zero, and at an extreme at which it stays.

    That a sensor rests at zero is remarked where the angle goes either way as well.

    Raises InputError, in one line, for an angle beyond a range that is stated.
    """
    if ANGLE in campaign.logger.ranges:
        return _stated(campaign, campaign.logger.ranges[ANGLE], remarks)
    campaign = _resting(campaign, remarks)
    for which in (np.min, np.max):
        campaign = _clipped(campaign, which, remarks)
    return campaign


def stays_at(values: Array, extreme: float) -> int:
    """For how many rows a noisy channel (rows,) stays at one and the same extreme: 0 where it may well do so,
    as one without noise may, and a sensor where it was at first."""
    at = values == extreme
    if extreme in (0.0, values[0]) or (rows := longest(at)) < FLAT or (~at).sum() < FLAT:
        return 0
    return rows if noise_floor(values[~at]) > DITHER * resolution(values) else 0


def longest(flags: NDArray[np.bool_]) -> int:
    """Longest run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    return int(max(edges[1::2] - edges[::2], default=0))


def _stated(campaign: Campaign, range_: Range, remarks: list[Remark]) -> Campaign:
    low, high = range_
    for r in campaign.recordings:
        beyond = (
            [] if r.angle is None else [v for v in (r.angle.min(), r.angle.max()) if not low <= v <= high]
        )
        if beyond:
            raise InputError(
                f"{campaign.name}/{r.name}: column {ANGLE!r}: {beyond[0]:g} lies beyond [logger] "
                f"angle_range_deg, {low:g} to {high:g}; correct that range"
            )
    for end in range_:
        names = [r.name for r in campaign.recordings if r.angle is not None and (r.angle == end).any()]
        if names:
            remarks.append(Remark("clipped", ANGLE, end, "deg", tuple(names), True))
    return campaign.each(lambda r: r if r.angle is None else replace(r, ranges={ANGLE: range_}))


def _resting(campaign: Campaign, remarks: list[Remark]) -> Campaign:
    found: dict[Habit, dict[str, float]] = {"saturated": {}, "resting": {}}

    def zero(r: Recording) -> Recording:
        if r.angle is None or np.ptp(r.angle) == 0.0 or (rows := longest(r.angle == 0.0)) < REST_ROWS:
            return r
        low = 0.0 if r.angle.min() == 0.0 else -np.inf
        high = 0.0 if r.angle.max() == 0.0 else np.inf
        ends = 0.0 in (low, high)
        found["saturated" if ends else "resting"][r.name] = rows * float(np.median(np.diff(r.time)))
        return replace(r, ranges={ANGLE: (low, high)}) if ends else r

    campaign = campaign.each(zero)
    for habit, lasts in found.items():
        if lasts:
            remarks.append(Remark(habit, ANGLE, max(lasts.values()), "s", tuple(lasts)))
    return campaign


def _clipped(campaign: Campaign, which: Callable[[Array], float], remarks: list[Remark]) -> Campaign:
    """With the end of the range at an extreme, the least or the largest, at which the angle stays."""
    found: dict[float, list[str]] = {}

    def end(r: Recording) -> Recording:
        own = r.fresh(ANGLE)
        if r.angle is None or not own.any():
            return r
        extreme = float(which(r.angle[own]))
        if not stays_at(r.angle[own], extreme):
            return r
        found.setdefault(extreme, []).append(r.name)
        low, high = r.ranges.get(ANGLE, ANYTHING)
        return replace(r, ranges={ANGLE: (extreme, high) if which is np.min else (low, extreme)})

    campaign = campaign.each(end)
    remarks += [Remark("clipped", ANGLE, at, "deg", tuple(names)) for at, names in found.items()]
    return campaign
