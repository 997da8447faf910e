"""From where the pressure is counted: the sensor's zero beside the pressure that a command of zero asks for.

A rig may log absolute pressures, or a pump may begin at some count of its DAC.  The regulator's law has no
such offset, so the pressure is counted from where the law's is zero.  How fast the regulator fills and
exhausts decides where it would come to rest, and so has to be fitted with it.
"""

from dataclasses import replace

import numpy as np

from plants.effects.regulator.dead_time import DeadTime
from plants.effects.regulator.fill_exhaust import PressureDependentRates
from plants.measured.begin import first_begin
from plants.measured.campaign import Campaign
from plants.measured.guess.rig import guessed_set
from plants.measured.guess.rough_models import first_order, recorded
from plants.measured.logger import Remark, shifted
from plants.measured.playback import Playback
from plants.measured.residual.stillness import noise_of_campaign
from plants.measured.stage import Stage
from plants.measured.trace.stages.model import Model

WORTH = 0.01
"""Share of the pressure's range by which the zeros must differ: less is within what a regulator leaves."""


BELOW = 0.1
"""Share of the range by which no pressure may lie below what the lowest command asks for: else the line is
bent, as by a supply that gives no more, and says nothing of its zero."""


def counted(campaign: Campaign) -> tuple[Campaign, tuple[Remark, ...]]:
    """The campaign with its pressure counted from what a command of zero asks for, and that it was."""
    logged = tuple(r for r in campaign.fit if r.pressure is not None)
    if not logged:
        return campaign, ()
    start = guessed_set(replace(campaign, fit=logged, stage="regulator"))
    seen = first_order(recorded(logged, "pressure"))
    moved = shifted(campaign, -seen.offset)
    played = tuple(Playback(r, start.rig.sample_time) for r in moved.fit if r.pressure is not None)
    noise = noise_of_campaign(logged, "pressure_kPa") or 1.0
    begins = None
    if campaign.start == "unknown":
        begins = tuple(first_begin(p.recording, 0.0) for p in played)
    stage = Stage("regulator", "pressure_kPa", noise, played, (), start.rig, None, begins, floating=True)
    model = Model(stage, start, start.values)
    late = model.plus(DeadTime, {"delay": seen.delay})
    fitted = late.plus(PressureDependentRates, {"ratio": 0.9, "fill": 0.0, "exhaust": 0.0}).fitted()
    offset = seen.offset + float(np.mean(stage.target - stage.simulate(fitted.values, fitted.forms)[:, 0]))
    span = float(np.ptp(stage.target))
    ends = [end for r in logged for end in (float(r.command.min()), float(r.command.max()))]
    lowest = min(fitted.values["gain"] * end for end in ends) + offset
    below = lowest - min(float(r.pressure.min()) for r in logged if r.pressure is not None)
    if abs(offset) < WORTH * span or below > BELOW * span:
        return campaign, ()
    names = tuple(r.name for r in (*campaign.fit, *campaign.validate))
    return shifted(campaign, -offset), (Remark("counted from", "pressure_kPa", offset, "kPa", names),)
