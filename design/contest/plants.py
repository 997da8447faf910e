"""The plants of the contest: drawn within their uncertainty, and rigs with an effect that no model has.

Every wrist of the contest carries the same effects, at their null where it has none of them, so that one
law serves all; at its null an effect is not there (the tests of the effects show it).
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.contest.statistics import FEWEST
from design.evaluation.cases import lanes_of
from design.evaluation.scenarios import HEADROOM, Spread
from design.robustness.box import SIGMAS, Box, box_of, shares_of
from design.robustness.samples.draws import generator
from plants.effects.effect import Effect
from plants.effects.regulator.dead_time import DeadTime
from plants.effects.regulator.fill_exhaust import TwoRates
from plants.effects.wrist.branch_curvature import Polynomial
from plants.effects.wrist.creep import Creep
from plants.effects.wrist.cross_coupling import Coupling
from plants.effects.wrist.load_step import LoadStep
from plants.equilibrium import at_rest
from plants.errors import InputError
from plants.parameters.quantities import Fitted, ParameterSet
from plants.wrist import Start, Wrist

Array = NDArray[np.float64]

PLANTS = 100
"""Plants that are drawn where nothing else is asked for."""

SHARE = 5
"""A rig with an effect is seen on one in so many of the plants."""

DRAWS, NOISE = 2, 3  # streams of the generator, beside those of `design.robustness.samples.draws`

PARTS = (1.0, 0.75, 0.5, 0.25)
"""Shares of the spread from day to day that are tried, the first that a loop allows being taken."""

FORMS: tuple[type[Effect], ...] = (DeadTime, Creep, LoadStep, Polynomial, TwoRates, Coupling)
"""The effects that every wrist of the contest carries."""

RIGS: dict[str, dict[str, float]] = {
    "dead time 50 ms": {"dead-time.delay": 0.05},
    "creep 10 % in 3 s": {"creep.gain": 0.1, "creep.time_constant": 3.0},
    "branches bent by a cubic 0.15": {"branch-curvature.cubic": 0.15},
    "exhausts at 0.7 of filling": {"fill-exhaust-asymmetry.ratio": 0.7},
}
"""Rigs: what they have that no controller's model does, at values at which the trace tries these effects
(the dead time is what rigs of this kind show)."""

COUPLING = 0.02
"""Shift of the static angle per kPa of the other motion [deg/kPa], a trial value of the effect."""


@dataclass(frozen=True)
class PlantField:
    """Plants that are met side by side: a wrist with lanes, how many, and how many were set aside
    because no command in the range holds 15 deg on them."""

    name: str
    wrist: Wrist
    count: int
    set_aside: int = 0


def carrying(wrist: Wrist, lanes: int) -> Wrist:
    """A wrist, of floats or lanes, that carries all effects of the contest at their nulls, as lanes.

    Raises InputError for one that has effects already.
    """
    if wrist.effects:
        names = ", ".join(e.NAME for e in wrist.effects)
        raise InputError(f"contest: the wrist has effects ({names}) of its own; give one without them")
    for form in FORMS:
        wrist = wrist + form()
    values = {n: np.broadcast_to(np.asarray(v, float), (lanes,)) for n, v in wrist.values.items()}
    return wrist.made_of(values)


def nominal(wrist: Wrist) -> PlantField:
    """The plant as it is."""
    return PlantField("nominal plant", carrying(wrist, 1), 1)


def perturbed(plant: ParameterSet, count: int = PLANTS, seed: int = 0) -> PlantField:
    """Independent draws, uniform over the box of a parameter set (`day_to_day`); the i-th is the same
    whatever the count.

    Raises InputError as `design.robustness.box.box_of`, and for fewer than `FEWEST` plants.
    """
    if count < FEWEST:
        raise InputError(f"contest: {count} plants are too few for an interval; give at least {FEWEST}")
    box, _ = day_to_day(plant)
    shares = generator(seed, 0, DRAWS).random((count, len(box.intervals))).T
    drawn = PlantField("perturbed plants", carrying(box.at(shares), count), count)
    return within_reach(drawn)


def day_to_day(plant: ParameterSet) -> tuple[Box, float]:
    """The box that plants are drawn from, and the share of `design.evaluation.scenarios.Spread` that it has.

    The standard error of one campaign says how well that day is known.  Gains are tuned for the assumed
    spread from day to day, and so are the plants of the contest drawn: all of it, or as much as leaves a
    loop that does not run backwards anywhere in the range of pressure.  Raises InputError as `box_of`.
    """
    for share in PARTS:
        full = Spread.of(plant.rig)
        spread = Spread(share * full.width, share * full.slope, share * full.lag)
        try:
            return box_of(another_day(plant, spread), spread), share
        except InputError:
            continue
    return box_of(plant), 0.0


def another_day(plant: ParameterSet, spread: Spread) -> ParameterSet:
    """The set without those standard errors that are smaller than what a refit on another day moves."""
    shares, found = shares_of(plant, spread), dict(plant.parameters)
    for name, share in shares.items():
        p = plant.parameters[name]
        if isinstance(p.provenance, Fitted) and SIGMAS * (p.provenance.std_error or 0.0) < share * abs(
            p.value
        ):
            found[name] = replace(p, provenance=replace(p.provenance, std_error=None))
    return replace(plant, parameters=found)


def first(of: PlantField, count: int, name: str) -> PlantField:
    """The first plants of a field."""
    pick = np.arange(min(count, of.count))
    return PlantField(name, lanes_of(of.wrist, pick), pick.size)


def rig(name: str, of: PlantField, every: int = SHARE, called: str | None = None) -> PlantField:
    """One in `every` of the plants of a field, with the effect of a rig of `RIGS`."""
    pick = np.arange(0, of.count, every)
    changed: dict[str, Any] = {n: np.full(pick.size, v) for n, v in RIGS[name].items()}
    return within_reach(
        PlantField(called or name, lanes_of(of.wrist, pick).with_values(**changed), pick.size)
    )


def within_reach(field: PlantField) -> PlantField:
    """The plants of a field on which a command within the range, with some headroom, holds the step either
    way; the others say nothing about controllers."""
    least, most = field.wrist.rig.command_range
    low, high, step = least + HEADROOM, most - HEADROOM, field.wrist.rig.task.step
    held = np.ones(field.count, bool)
    ends: tuple[tuple[Start, float], ...] = (("line1", step), ("line2", -step))
    for start, angle in ends:
        state = at_rest(field.wrist, start, np.full(field.count, angle))
        command = state.pressure / field.wrist.regulator.gain
        held &= (command >= low) & (command <= high)
    pick = np.flatnonzero(held)
    wrist = lanes_of(field.wrist, pick)
    return PlantField(field.name, wrist, pick.size, field.set_aside + field.count - pick.size)
