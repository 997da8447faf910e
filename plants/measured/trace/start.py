"""Where a fit starts: the set that was given, the built-in one of a motion of that name, or a guess."""

from dataclasses import dataclass, replace

import numpy as np

from plants.measured.campaigns.campaign import Campaign
from plants.measured.campaigns.decimation import decimated, rows_for
from plants.measured.guess.rig import followed, guessed_set
from plants.measured.instrument.logger import corrected
from plants.measured.instrument.remark import Remark, angle_delay_of, zero_of
from plants.measured.trace.counting.middle import at_rest_in_log, centred, near_zero
from plants.measured.trace.counting.sign import rising
from plants.measured.trace.counting.zero import counted
from plants.parameters.files import built_in
from plants.parameters.quantities import ParameterSet
from plants.rig import built_in_rig

STARTS, FROM_GUESS = 3, 1
"""Starting points of a fit: from bounds that somebody set, and from a guess, which is near already."""


@dataclass(frozen=True)
class Start:
    """A campaign without its logger's habits, and what those were; a parameter set to start from; guessed:
    whether it was guessed from the log, so that the hysteresis law is open too."""

    campaign: Campaign
    instrument: tuple[Remark, ...]
    parameters: ParameterSet
    guessed: bool

    @property
    def starts(self) -> int:
        """Number of starting points of a fit."""
        return FROM_GUESS if self.guessed else STARTS


def starting(campaign: Campaign, given: ParameterSet | None = None, either_way: bool = False) -> Start:
    """The start of a campaign; given: the set that the user gave; either_way: whether a guessed rig is to
    make steps either way from zero (`plants.measured.trace.counting.middle`).

    >>> from plants import load_campaign
    >>> starting(load_campaign("plants/measured/examples/flexion")).guessed
    False
    """
    campaign, instrument = corrected(campaign)
    late = angle_delay_of(instrument)
    if given is None and campaign.axis in built_in_rig().motions:
        given = built_in(campaign.axis)
    if given is not None:
        rig = given.rig if late is None else replace(given.rig, angle_delay=late)
        return Start(campaign, instrument, replace(given, rig=rig), False)
    campaign, of_rows = _decimated(campaign)
    campaign, of_sign = rising(campaign)
    campaign, of_pressure = counted(campaign)
    unmoved = at_rest_in_log(campaign)
    campaign, of_angle = (centred if either_way else near_zero)(campaign)
    rest = sum((unmoved - r.value for r in of_angle), 0.0)
    if of_sign:  # the angle as it is logged
        of_angle = tuple(replace(r, value=-r.value) for r in of_angle)
    remarks, guess = (*instrument, *of_rows, *of_sign, *of_pressure, *of_angle), guessed_set(campaign)
    rig = replace(guess.rig, zero=replace(zero_of(remarks), rest=rest), angle_delay=late or 0.0)
    return Start(campaign, remarks, replace(guess, rig=rig), True)


def _decimated(campaign: Campaign) -> tuple[Campaign, tuple[Remark, ...]]:
    """The campaign without the rows that its regulator is too slow for, and the remark on them."""
    if rows_for(campaign.recordings, np.inf) == 1:  # so that no lag need be guessed
        return campaign, ()
    rows = rows_for(campaign.recordings, followed(campaign.fit).tau)
    if rows == 1:
        return campaign, ()
    step = campaign.sample_time * rows
    found = replace(campaign.each(lambda r: decimated(r, rows)), sample_time=step)
    return found, (Remark("decimated", "time_s", step, "s", campaign.names),)
