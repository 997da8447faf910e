"""Signs of the log of a rig that nobody declared: the pressure of a plant rises with the command, its angle
with the pressure."""

import numpy as np

from plants.errors import InputError
from plants.measured.campaigns.campaign import Campaign
from plants.measured.formats.columns import is_vacuum
from plants.measured.guess.rough_models import extent, first_order, recorded
from plants.measured.instrument.logger import counted_from
from plants.measured.instrument.remark import Remark
from plants.rig import Zero

FOR_CERTAIN = 0.5
"""Correlation of angle and pressure, each about its mean in a recording, from which on a sign is certain."""


def rising(campaign: Campaign) -> tuple[Campaign, tuple[Remark, ...]]:
    """The campaign with an angle that rises with the pressure, and whether its sign was turned for that.

    Raises InputError where the pressure falls as the command rises: a controller would have to turn its
    command, which only who builds it can; a vacuum is counted as such instead.
    """
    pressures = recorded(campaign.fit, "pressure")
    if any(np.ptp(x) > 0.0 for x, _, _ in pressures):
        seen = first_order(pressures)
        spread = float(np.std(np.concatenate([v for _, v, _ in pressures])))
        if seen.gain < 0.0 and seen.rms < (1.0 - FOR_CERTAIN**2) ** 0.5 * spread:
            low, high = extent([v for _, v, _ in pressures])
            channel = "pressure_kPa, which is a vacuum's," if is_vacuum(low, high) else "command_V"
            raise InputError(
                f"{campaign.name}: the pressure falls as the command rises; map {channel} with scale = -1, "
                "or command and pressure of another channel"
            )
    if _correlation(campaign) > -FOR_CERTAIN:
        return campaign, ()
    names = campaign.names
    turned = counted_from(campaign, Zero(reversed=True))
    return turned, (Remark("reversed", "angle_deg", -1.0, "1", names),)


def _correlation(campaign: Campaign) -> float:
    """Correlation of the angle with the pressure, or with the command where none was logged, in the
    recordings to fit on; 0 where either never moves."""
    pairs = [
        (x - x.mean(), r.angle - r.angle.mean())
        for r in campaign.fit
        if r.angle is not None and (x := r.command if r.pressure is None else r.pressure) is not None
    ]
    if not pairs:
        return 0.0
    x, y = (np.concatenate(series) for series in zip(*pairs, strict=True))
    power = float(np.sqrt((x @ x) * (y @ y)))
    return float(x @ y) / power if power > 0.0 else 0.0
