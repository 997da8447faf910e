"""Where the angle of a rig that nobody declared is counted from: near zero, for a design amid its range.

Steps of a task go either way from zero, as those of a joint with two muscles do.  A rig that bends to one
side has its zero at the end of its range, beyond which no command takes it.  It is traced as it was logged,
since its loop bends and its slopes soften about that end; the plant that was found is then counted from the
middle of what it reaches, for a design.
"""

from dataclasses import replace
from math import floor, log10, prod

import numpy as np

from plants.equilibrium import at_pressure
from plants.hysteresis import ORIGIN
from plants.measured.campaign import Campaign
from plants.measured.guess.rig import guessed_rig, with_step
from plants.measured.guess.rough_models import extent
from plants.measured.logger import Remark, counted_from
from plants.parameters.quantities import Parameter, ParameterSet, Stated, in_units
from plants.rig import Zero
from plants.wrist import Wrist

ROOM = 1.1
"""Steps of the task that the range must have on either side of zero."""


FAR = 1.0
"""Ranges of the angle by which it lies from zero at least to be far from it."""


def near_zero(campaign: Campaign) -> tuple[Campaign, tuple[Remark, ...]]:
    """The campaign with an angle that lies far from zero for its range, as that of a sensor that nobody
    zeroed, counted from the lower end of its range, and that it was.  An output curve bends about zero."""
    recordings = (*campaign.fit, *campaign.validate)
    angles = [r.angle for r in recordings if r.angle is not None]
    if not angles:
        return campaign, ()
    (low, high), step = extent(angles), guessed_rig(campaign).task.step
    if high == low or max(low, -high) < FAR * (high - low):
        return campaign, ()
    end = _rounded(low, step)
    names = tuple(r.name for r in recordings)
    return counted_from(campaign, Zero(angle=end)), (Remark("far", "angle_deg", end, "deg", names),)


def about_middle(plant: ParameterSet, campaign: Campaign) -> ParameterSet:
    """The plant of a campaign with its angle counted from the middle of the range that it reaches, where that
    goes to one side, and with a step of a third of that range at most: the same motions of the same rig.

    `plant` itself where it goes to both sides, and where its hysteresis law cannot be counted from elsewhere.
    """
    angles = [r.angle for r in (*campaign.fit, *campaign.validate) if r.angle is not None]
    if not angles:
        return plant
    (low, high), step = _reached(plant, *extent(angles)), plant.rig.task.step
    if min(-low, high) >= ROOM * step or not low < high:
        return plant
    angle = _rounded(0.5 * (low + high), step)
    moved = counted_elsewhere(plant, angle, Stated(f"the log of {campaign.name}", "middle of its range"))
    if moved is None:
        return plant
    third = float(f"{(high - low) / 3.0:.2g}")
    return replace(moved, rig=with_step(moved.rig, min(step, third)))


def counted_elsewhere(plant: ParameterSet, angle: float, said: Stated) -> ParameterSet | None:
    """The plant with its angle counted from another [deg]: what it simulates differs by that and by nothing
    else, its effects included.  said: who says so; None for a law that cannot be counted from elsewhere."""
    wrist = Wrist.of(plant)
    rest = float(wrist.rest("inside", angle).pressure)
    # What follows the loop, as creep does, multiplies it: less has to be taken off there.
    law = wrist.hysteresis.counted_from(rest, angle / _static_gain(wrist))
    if law is None:
        return None
    values = law.values | {n: v for e in wrist.effects for n, v in e.counted_from(angle).values.items()}
    known = dict(plant.parameters)
    for name, kind in ((n, in_units(kind, plant.rig)) for n, kind in ORIGIN.items()):
        known[name] = Parameter(float(values[name]), kind.unit, kind.low, kind.high, said)
    names = replace(plant, parameters=known).kinds
    parameters = {n: _at(known[n], float(values.get(n, known[n].value))) for n in names}
    zero = plant.rig.zero
    sign = -1.0 if zero.reversed else 1.0
    rig = replace(plant.rig, zero=replace(zero, angle=zero.angle + sign * angle))
    return replace(plant, parameters=parameters, rig=rig)


def _reached(plant: ParameterSet, lowest: float, highest: float) -> tuple[float, float]:
    """Angles [deg] that the plant holds whatever it did before: from the descending branch at the least
    pressure to the ascending one at the largest, of those that were logged and can be commanded; within the
    angles that were logged."""
    wrist = Wrist.of(plant)
    ends = [wrist.regulator.gain * v for v in plant.rig.command_range]
    low, high = (float(np.clip(p, min(ends), max(ends))) for p in plant.rig.pressure_range)
    held = at_pressure(wrist, "line2", low).angle, at_pressure(wrist, "line1", high).angle
    return max(float(held[0]), lowest), min(float(held[1]), highest)


def _static_gain(wrist: Wrist) -> float:
    """By which effects that follow the loop multiply its angle, at rest."""
    still = np.ones(1)
    parts = [e.linear(wrist, still, wrist.rig.sample_time, wrist.rig.pressure_range) for e in wrist.effects]
    return prod(float(np.real(np.ravel(p.static)[0])) for p in parts)


def _at(p: Parameter, value: float) -> Parameter:
    """At another value, within bounds that hold it."""
    return replace(p, value=value, low=min(p.low, value), high=max(p.high, value))


def _rounded(middle: float, step: float) -> float:
    """To a decade that a tenth of the step holds at least once: far from zero, two digits are too few."""
    return round(middle, -floor(log10(0.1 * step)))
