"""Recordings that would mislead a trace: clipped sensors, and too little motion to tell."""

import numpy as np
from numpy.typing import NDArray

from plants.errors import InputError
from plants.measured.campaigns.begin import measured
from plants.measured.campaigns.campaign import Campaign
from plants.measured.campaigns.recording import Recording
from plants.measured.instrument.saturation import stays_at
from plants.measured.residual.series.joined import FEWEST

Array = NDArray[np.float64]
SHORT = 20.0
"""Seconds of recordings to fit on below which slow effects cannot show."""


def check(campaign: Campaign) -> tuple[str, ...]:
    """Remarks on the recordings of a campaign.

    Raises InputError, in one line with file and column, for a clipped sensor:
    what it hides would pass for an effect.
    """
    for recording in campaign.recordings:
        for channel in ("angle_deg", "pressure_kPa"):
            values = measured(recording, channel)
            if values is not None:
                # Of a channel that is held only renewed values count: three equal ones fill many rows.
                _check_clipped(campaign, recording, channel, values[recording.fresh(channel)])
    for channel in ("angle_deg", "pressure_kPa"):
        rows = max((len(v) for r in campaign.fit if (v := measured(r, channel)) is not None), default=FEWEST)
        if rows < FEWEST:
            raise InputError(
                f"{campaign.name}: no recording to fit on has {FEWEST} rows of {channel} (the longest has "
                f"{rows}): too short to tell noise from anything else; record for longer"
            )
    seconds = sum(float(r.time[-1] - r.time[0]) for r in campaign.fit)
    said = []
    if seconds < SHORT:
        said.append(f"Only {seconds:.3g} s of recordings to fit on: slow effects cannot show in them.")
    return tuple(said)


def _check_clipped(campaign: Campaign, recording: Recording, channel: str, values: Array) -> None:
    for extreme in (values.min(), values.max()):
        rows = 0 if extreme in recording.ranges.get(channel, ()) else stays_at(values, extreme)
        if rows:
            raise InputError(
                f"{campaign.name}/{recording.name}: column {channel!r}: stays at exactly {extreme:g}, its "
                f"extreme, for {rows} rows though it is noisy elsewhere: the sensor is clipped; "
                "widen its range or cut those rows out"
            )
