"""What the logger does, as apart from what the rig does: found by tests, taken out, and said.

None of it is an effect of the rig: a channel that is renewed less often than rows are written, a pressure
that is counted from somewhere else, an angle sensor that is offset anew in each recording, a sensor that
rests at its zero, rows written twice or in the wrong order, empty cells, lost packets, single values far off,
a clock that counts from elsewhere, a channel that is logged late.  What campaign.toml states of it is not
looked for.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plants.measured.campaigns.begin import rows_before_move
from plants.measured.campaigns.campaign import Campaign
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.noise import noise_floor, resolution
from plants.measured.guess.rough_models import extent
from plants.measured.instrument.alignment import delay_between, in_step
from plants.measured.instrument.missing import lines_between, spikes
from plants.measured.instrument.offsets import offsets_between
from plants.measured.instrument.pressure_offsets import SAME, pressure_offsets
from plants.measured.instrument.remark import Habit, Remark
from plants.measured.instrument.renewals import interval, renewals
from plants.measured.instrument.saturation import REST_ROWS, ranged
from plants.measured.instrument.single_sine import only_sines
from plants.rig import Zero

Array = NDArray[np.float64]
READ: Mapping[Habit, str] = {
    "repeated": "rows", "swapped": "rows", "empty": "cells", "gaps": "gaps", "clock": "s",
}  # fmt: skip
"""What is put right when a recording is read, and what it is counted in."""

FIELDS = {"pressure_kPa": "pressure", "angle_deg": "angle"}

LOWEST = 3
"""Rows of rest before the command first moves that are needed to see an offset."""

LOUD = 3.0
"""Times its noise that an angle at rest has to be off to be offset: a sinusoid may be off by less."""

AT_REST = 1.0
"""Largest angle [deg] at rest that is taken for an offset, where recordings do not begin under one command:
what is further off starts elsewhere."""

OFF = 0.1
"""Share of the angle's range up to which an angle at rest is taken for an offset."""

CERTAIN = 5.0
"""Times its standard error that the slope of an angle at rest has to be for the sensor to drift."""


def corrected(campaign: Campaign) -> tuple[Campaign, tuple[Remark, ...]]:
    """The campaign without the logger's habits, and what they were.

    Values of a held channel are replaced by straight lines between renewals, a channel that is logged late is
    put back, and offsets of the angle are taken off.  (The zero of the pressure: `trace.counting.zero`.)
    """
    remarks = _mended(campaign)
    campaign = _renewed(campaign, remarks)
    campaign = _without_spikes(campaign, remarks)
    campaign = ranged(campaign, remarks)
    campaign = _in_step(campaign, remarks)
    for channel, by_file in campaign.logger.offsets.items():
        campaign = _taken_off(campaign, channel, by_file, remarks, True)
    if "pressure_kPa" not in campaign.logger.offsets:
        campaign = _taken_off(campaign, "pressure_kPa", pressure_offsets(campaign), remarks)
    if "angle_deg" not in campaign.logger.offsets:
        if campaign.start == "rest":
            campaign = _without_offsets(campaign, remarks)
        else:
            campaign = _taken_off(campaign, "angle_deg", offsets_between(campaign), remarks)
    return campaign, tuple(remarks)


def _mended(campaign: Campaign) -> list[Remark]:
    """What was put right when the recordings were read."""
    recordings = campaign.recordings
    found: list[Remark] = []
    for habit, unit in READ.items():
        counts = {r.name: r.mended[habit] for r in recordings if habit in r.mended}
        if counts:
            value = min(counts.values()) if habit == "clock" else sum(counts.values())
            found.append(Remark(habit, "time_s", value, unit, tuple(counts)))
    return found


def _in_step(campaign: Campaign, remarks: list[Remark]) -> Campaign:
    """The campaign with channels that are logged late put back: those that are stated, else what is found."""
    late = dict(campaign.logger.delays)
    if not late:
        by = delay_between(campaign)
        late = {"angle_deg" if by > 0.0 else "pressure_kPa": abs(by)} if by else {}
    for channel, delay in late.items():
        campaign = campaign.each(lambda r, c=channel, d=delay: in_step(r, c, d))  # type: ignore[misc]
        stated = bool(campaign.logger.delays)
        doubtful = not stated and only_sines(campaign.fit)
        remarks.append(Remark("late", channel, delay, "s", campaign.names, stated, doubtful))
    return campaign


def _taken_off(
    campaign: Campaign,
    channel: str,
    offsets: Mapping[str, float],
    remarks: list[Remark],
    stated: bool = False,
) -> Campaign:
    """The campaign with offsets of a channel taken off, by recording."""
    if not offsets:
        return campaign
    largest, unit = max(map(abs, offsets.values())), channel.split("_")[1]
    remarks.append(Remark("offset", channel, largest, unit, tuple(offsets), stated))

    def taken(r: Recording) -> Recording:
        values, off = getattr(r, FIELDS[channel]), offsets.get(r.name, 0.0)
        if values is None:
            return r
        moved: dict[str, Any] = {FIELDS[channel]: values - off}
        if channel in r.ranges:
            low, high = r.ranges[channel]
            moved["ranges"] = {**r.ranges, channel: (low - off, high - off)}
        return replace(r, **moved)

    return campaign.each(taken)


def _every(r: Recording, period: float) -> NDArray[np.bool_]:
    """Rows at which a channel was renewed that is renewed every so many seconds."""
    count = np.floor((r.time - r.time[0]) / period + 1e-6)
    return np.append(True, np.diff(count) > 0.0)


def _renewed(campaign: Campaign, remarks: list[Remark]) -> Campaign:
    for channel, field in FIELDS.items():
        held: dict[str, float] = {}
        stated = campaign.logger.renewed.get(channel)

        def straight(
            r: Recording, channel: str = channel, field: str = field, held: dict[str, float] = held,
            stated: float | None = stated,
        ) -> Recording:  # fmt: skip
            values = getattr(r, field)
            fresh = None if values is None or channel in r.renewed else renewals(values)
            if fresh is None and stated is not None and values is not None:
                fresh = _every(r, stated)
            if fresh is None:
                return r
            held[r.name] = interval(r.time[fresh])
            return _only(r, channel, fresh)

        campaign = campaign.each(straight)
        if held:
            every = float(np.median(list(held.values())))
            remarks.append(Remark("held", channel, every, "s", tuple(held), stated is not None))
    return campaign


def _only(r: Recording, channel: str, fresh: NDArray[np.bool_]) -> Recording:
    """A recording in which only some rows of a channel count, with straight lines between them."""
    lines: dict[str, Any] = {FIELDS[channel]: lines_between(r.time, getattr(r, FIELDS[channel]), fresh)}
    return replace(r, **lines, renewed={**r.renewed, channel: fresh})


def _without_spikes(campaign: Campaign, remarks: list[Remark]) -> Campaign:
    for channel, field in FIELDS.items():
        counts: dict[str, int] = {}

        def smooth(
            r: Recording, channel: str = channel, field: str = field, counts: dict[str, int] = counts
        ) -> Recording:
            values, there = getattr(r, field), r.fresh(channel)
            off = np.zeros(0, bool) if values is None else spikes(values[there])
            if not off.any():
                return r
            counts[r.name] = int(off.sum())
            there = there.copy()
            there[np.flatnonzero(there)[off]] = False
            return _only(r, channel, there)

        campaign = campaign.each(smooth)
        if counts:
            remarks.append(Remark("spikes", channel, sum(counts.values()), "rows", tuple(counts)))
    return campaign


def counted_from(campaign: Campaign, zero: Zero) -> Campaign:
    """The campaign with pressures and angles counted from a zero."""
    return campaign.each(lambda r: r.counted_from(zero))


def _without_offsets(campaign: Campaign, remarks: list[Remark]) -> Campaign:
    off: dict[str, float] = {}
    most = _largest_offset(campaign)

    def taken(r: Recording) -> Recording:
        if r.angle is None or r.other_pressure is not None:
            return r
        rows = rows_before_move(r)
        if rows < LOWEST or rows == len(r.time):
            return r
        own = r.fresh("angle_deg")
        if own[:rows].sum() < LOWEST:
            return r
        middle, first = _at_rest(r.angle[:rows][own[:rows]])
        least = max(LOUD * noise_floor(r.angle[own]), resolution(r.angle[own]))
        if least < min(abs(middle), abs(first)) and abs(first) < most:
            off[r.name] = first
        return r

    campaign.each(taken)
    # One and the same offset everywhere is where the rig rests, not what a sensor does.
    values = np.array([off.get(n, 0.0) for n in campaign.names])
    if not off or np.ptp(values) < 0.5 * float(np.max(np.abs(values))):
        return campaign
    return _taken_off(campaign, "angle_deg", off, remarks)


def _largest_offset(campaign: Campaign) -> float:
    """The largest angle [deg] that is taken for an offset: a share of its range, where all recordings begin
    under one command."""
    first = [float(r.command[0]) for r in campaign.recordings]
    angles = [r.angle for r in campaign.recordings if r.angle is not None]
    if not angles or np.ptp(first) > SAME * np.ptp(extent([r.command for r in campaign.recordings])):
        return AT_REST
    return max(AT_REST, OFF * float(np.ptp(extent(angles))))


def _at_rest(angle: Array) -> tuple[float, float]:
    """Mean of an angle at rest (rows,), and where it began: that of a straight line, where there is one for
    certain.  A sensor that drifts has moved by the end of a long rest, and was at zero nevertheless."""
    n, middle = angle.size, float(angle.mean())
    if n < REST_ROWS:
        return middle, middle
    t = np.linspace(-1.0, 1.0, n)
    slope = float(t @ angle / (t @ t))
    spread = float(np.std(angle - middle - slope * t, ddof=2)) / float(t @ t) ** 0.5
    return middle, middle - slope if abs(slope) > CERTAIN * spread else middle
