"""Where the angle of a rig that nobody declared is counted from: near zero, for a design amid its range.

Steps of a task go either way from zero, as those of a joint with two muscles do.  A rig that bends to one
side has its zero at the end of its range, beyond which no command takes it: for a design its angle is counted
from the middle of what the log shows.  What curves and softens does so about where the rig rests, so that the
log is traced as it is and the plant that was found is counted from the middle: exactly the same plant.  One
that is another there (`plants.effects.effect.Effect.counted_from`) is traced from a log that is.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import floor, log10
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plants.equilibrium import at_pressure, at_rest, obstacle
from plants.measured.campaigns.campaign import Campaign
from plants.measured.guess.rig import guessed_rig, with_step
from plants.measured.guess.rough_models import extent
from plants.measured.instrument.logger import counted_from
from plants.measured.instrument.remark import Remark
from plants.parameters.correlation import ParameterCorrelation, matrix_of
from plants.parameters.quantities import Fitted, Parameter, ParameterSet
from plants.rig import Zero
from plants.wrist import Wrist

Array = NDArray[np.float64]
ROOM = 1.1
"""Steps of the task that the range must have on either side of zero."""


HELD = 1.25
"""Steps of a guessed task that a command must hold either way: with the load that the requirement adds, and
slopes a tenth off, the angle is to be held as well."""

SHORTER = np.linspace(1.0, 0.4, 13)
"""Shares of a step that are tried where the whole of it is not held."""

NUDGE = 1e-3
"""Standard errors by which an estimate is moved to see what follows."""

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
    middle = _middle(campaign, guessed_rig(campaign).task.step)
    if middle is None:
        return campaign, ()
    moved = counted_from(replace(campaign, start="unknown"), Zero(angle=middle))
    return moved, (Remark("counted from", "angle_deg", middle, "deg", campaign.names),)


def _middle(campaign: Campaign, step: float) -> float | None:
    """The middle of the range of the logged angle, None where steps [deg] go either way from zero in it."""
    angles = [r.angle for r in campaign.recordings if r.angle is not None]
    low, high = extent(angles) if angles else (-np.inf, np.inf)
    return None if min(-low, high) >= ROOM * step else _rounded(0.5 * (low + high), step)


def about_middle(plant: ParameterSet, campaign: Campaign, guessed: bool) -> ParameterSet | None:
    """The plant of a campaign with its angle counted from the middle of the range of the log, where that goes
    to one side, and a step that it then holds; the plant itself where it goes to both, None where it cannot
    be counted from there.  guessed: whether the rig was; of one that somebody declared, zero stays where it
    is as long as the step is held either way."""
    middle = _middle(campaign, plant.rig.task.step)
    if middle is None or (not guessed and _holds(plant, plant.rig.task.step)):
        return plant
    moved = counted_elsewhere(plant, middle)
    return None if moved is None else with_reachable_step(moved)


def counted_elsewhere(plant: ParameterSet, angle: float) -> ParameterSet | None:
    """The plant with an angle [deg] counted as 0: what it simulates differs by that and by nothing else, and
    standard errors and correlations are those of the same estimates, to first order.  None for a law or an
    effect that counts from where it rests."""
    moved = _moved(plant, plant.values, angle)
    if moved is None:
        return None
    known = plant.parameters
    errors = {n: p.provenance.std_error for n, p in known.items() if isinstance(p.provenance, Fitted)}
    sizes = {n: e for n, e in errors.items() if e}
    names, size = list(sizes), np.array(list(sizes.values()))

    def estimates(name: str, by: float) -> Array:
        """The estimates counted from there, one of them moved by so much."""
        found = _moved(plant, {**plant.values, name: plant.values[name] + by}, angle)
        assert found is not None  # what can be moved hangs on no value
        return np.array([found[n] for n in names])

    steps = zip(names, NUDGE * size, strict=True)
    columns = [(estimates(n, step) - estimates(n, -step)) / (2.0 * step) for n, step in steps]
    change = np.array(columns).reshape(len(names), len(names)).T
    before = size[:, None] * matrix_of(plant.correlation, names) * size
    after = change @ before @ change.T
    error = np.sqrt(np.maximum(np.diag(after), 0.0))
    matrix = after / np.maximum(error[:, None] * error, np.finfo(float).tiny)
    found = {n: _at(p, moved[n]) for n, p in known.items()}
    for name, e in zip(names, error, strict=True):
        provenance: Any = found[name].provenance
        found[name] = replace(found[name], provenance=replace(provenance, std_error=float(e)))
    zero = plant.rig.zero
    there = replace(zero, angle=zero.logged(angle), rest=zero.rest - angle)
    rig = replace(plant.rig, zero=there)
    pairs = ParameterCorrelation(tuple(names), matrix).pairs
    return replace(plant, parameters=found, rig=rig, correlation=pairs)


def _moved(plant: ParameterSet, values: Mapping[str, float], angle: float) -> dict[str, float] | None:
    """Values of a plant with some of its own, its angle counted from another."""
    wrist = Wrist.from_values(values, plant.effects, plant.rig)
    # What follows the loop, as creep does, multiplies it: less has to be taken off there.
    law = wrist.hysteresis.counted_from(float(angle / wrist.static_gain))
    effects = [e.counted_from(angle) for e in wrist.effects]
    if law is None or any(e is None for e in effects):
        return None
    own = [e.values for e in effects if e is not None]
    return {n: float(v) for x in ({**values}, law.values, *own) for n, v in x.items()}


def _at(p: Parameter, value: float) -> Parameter:
    """At another value, within bounds that hold it."""
    return replace(p, value=value, low=min(p.low, value), high=max(p.high, value))


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
    low, high = _pressures(wrist)
    least, most = (float(at_pressure(wrist, *end).angle) for end in (("line2", low), ("line1", high)))
    from_virgin = _driven(wrist)
    tried = min((most - least) / 3.0, rig.task.step) * SHORTER
    step = next(
        (float(s) for s in tried if s > 0.0 and from_virgin >= HELD * s and _holds(plant, HELD * s)),
        rig.task.step,
    )
    return plant if step >= rig.task.step else replace(plant, rig=with_step(rig, float(f"{step:.2g}")))


def _pressures(wrist: Wrist) -> tuple[float, float]:
    """The least and the largest pressure [kPa] of a wrist's rig that a command asks for."""
    low, high = (float(np.clip(p, *wrist.reach)) for p in wrist.rig.pressure_range)
    return low, high


def _holds(plant: ParameterSet, angle: float) -> bool:
    """Whether pressures of the rig hold the plant at an angle [deg] either way, on the line it arrives on."""
    wrist = Wrist.of(plant)
    low, high = _pressures(wrist)
    up, down = at_rest(wrist, "line1", angle).pressure, at_rest(wrist, "line2", -angle).pressure
    stopped = obstacle(wrist, "line1", angle) or obstacle(wrist, "line2", -angle)
    return bool(low <= down and up <= high) and not stopped


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
