"""Where the angle of a rig that nobody declared is counted from: near zero, for a design amid its range.

Steps of a task go either way from zero, as those of a joint with two muscles do.  A rig that bends to one
side has its zero at the end of its range, beyond which no command takes it: for a design its angle is counted
from the middle of what the log shows.
"""

from dataclasses import replace
from math import floor, log10

import numpy as np

from plants.equilibrium import at_pressure, at_rest, obstacle
from plants.measured.campaigns.campaign import Campaign
from plants.measured.guess.rig import guessed_rig, with_step
from plants.measured.guess.rough_models import extent
from plants.measured.instrument.logger import counted_from
from plants.measured.instrument.remark import Remark
from plants.parameters.quantities import ParameterSet
from plants.rig import Zero
from plants.wrist import Wrist

ROOM = 1.1
"""Steps of the task that the range must have on either side of zero."""


HELD = 1.25
"""Steps of a guessed task that a command must hold either way: with the load that the requirement adds, and
slopes a tenth off, the angle is to be held as well."""

SHORTER = np.linspace(1.0, 0.4, 13)
"""Shares of a step that are tried where the whole of it is not held."""

FAR = 1.0
"""Ranges of the angle by which it lies from zero at least to be far from it."""


def near_zero(campaign: Campaign) -> tuple[Campaign, tuple[Remark, ...]]:
    """The campaign with an angle that lies far from zero for its range, as that of a sensor that nobody
    zeroed, counted from the lower end of its range, and that it was.  An output curve bends about zero."""
    end = at_rest_in_log(campaign)
    if not end:
        return campaign, ()
    return counted_from(campaign, Zero(angle=end)), (Remark("far", "angle_deg", end, "deg", campaign.names),)


def at_rest_in_log(campaign: Campaign) -> float:
    """The logged angle of a rig that never moved: 0, or the lower end of its range where it lies far from
    zero."""
    angles = [r.angle for r in campaign.recordings if r.angle is not None]
    if not angles:
        return 0.0
    low, high = extent(angles)
    far = high > low and max(low, -high) >= FAR * (high - low)
    return _rounded(low, guessed_rig(campaign).task.step) if far else 0.0


def centred(campaign: Campaign) -> tuple[Campaign, tuple[Remark, ...]]:
    """The campaign with its angle counted from the middle of its range, where it goes to one side, and that
    it was.  It may start anywhere, as on the virgin curve, which then begins where the rig rests
    (`plants.rig.Zero.rest`)."""
    recordings = campaign.recordings
    angles = [r.angle for r in recordings if r.angle is not None]
    if not angles:
        return campaign, ()
    (low, high), step = extent(angles), guessed_rig(campaign).task.step
    if min(-low, high) >= ROOM * step:
        return campaign, ()
    middle = _rounded(0.5 * (low + high), step)
    names = tuple(r.name for r in recordings)
    moved = counted_from(replace(campaign, start="unknown"), Zero(angle=middle))
    return moved, (Remark("counted from", "angle_deg", middle, "deg", names),)


def with_reachable_step(plant: ParameterSet) -> ParameterSet:
    """The plant of a guessed rig with a step of the task that it holds either way from zero whatever it did
    before: at most a third of the angles from the descending branch at the least pressure to the ascending
    one at the largest, short of what stops the joint, and of where the full command takes it from the initial
    curve in the time of the task.  A step that is guessed from the log is a third of what was reached on any
    branch.

    `plant` itself where that step is no shorter, and where there is none, as on a rig that bends to one side
    and is counted from there.
    """
    wrist, rig = Wrist.of(plant), plant.rig
    low, high = (float(np.clip(p, *wrist.reach)) for p in rig.pressure_range)
    least, most = (float(at_pressure(wrist, *end).angle) for end in (("line2", low), ("line1", high)))
    from_virgin = _driven(wrist)

    def held(angle: float) -> bool:
        if from_virgin < angle:
            return False
        up, down = at_rest(wrist, "line1", angle).pressure, at_rest(wrist, "line2", -angle).pressure
        stopped = obstacle(wrist, "line1", angle) or obstacle(wrist, "line2", -angle)
        return bool(low <= down and up <= high) and not stopped

    tried = min((most - least) / 3.0, rig.task.step) * SHORTER
    step = next((float(s) for s in tried if s > 0.0 and held(HELD * s)), rig.task.step)
    return plant if step >= rig.task.step else replace(plant, rig=with_step(rig, float(f"{step:.2g}")))


def _driven(wrist: Wrist) -> float:
    """How far [deg] the least and the largest command take a wrist that never moved, each in the time of a
    step of the task: the smaller of the two.  Plays that are wide for the range of the pressure leave the
    initial curve well inside the branches."""
    samples = max(round(wrist.rig.task.duration / wrist.rig.sample_time), 1)
    down, up = (
        float(wrist.simulate(np.full(samples, command), every=samples).angle[-1])
        for command in wrist.rig.command_range
    )
    return min(-down, up)


def _rounded(middle: float, step: float) -> float:
    """To a decade that a tenth of the step holds at least once: far from zero, two digits are too few."""
    return round(middle, -floor(log10(0.1 * step)))
