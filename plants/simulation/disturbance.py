"""Disturbances of a loop as effects of its plant: a dead time and a load beside the plant's own."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from plants import dynamics as plant
from plants.dynamics import State
from plants.effects.effect import Around, dead_time_of
from plants.effects.regulator.dead_time import DeadTime
from plants.effects.wrist.load_step import LoadStep
from plants.errors import InputError
from plants.hysteresis import Start

if TYPE_CHECKING:
    from plants.wrist import Wrist

Number = Any
BEFORE = -1.0
"""Moment [s] of a constant load: before the run, and before the wrist came to rest."""


def burdened(
    wrist: "Wrist", dead_time: Number | None, load: Number | None, moment: Number = BEFORE
) -> "Wrist":
    """The wrist with more dead time [s] and a load [deg] that is there from a moment [s] on, before the run
    where not given; None leaves an effect out.

    A load step that the wrist carries at its null takes the load.  Raises InputError for a load on a wrist
    that has a load step of its own.
    """
    if dead_time is not None:
        own = wrist.values.get("dead-time.delay")
        wrist = (
            wrist + DeadTime(dead_time)
            if own is None
            else wrist.with_values(**{"dead-time.delay": own + dead_time})
        )
    if load is not None:
        carried = [e for e in wrist.effects if e.NAME == LoadStep.NAME]
        if any(not isinstance(e, LoadStep) or np.any(e.shift) for e in carried):
            raise InputError("load: the plant has a load step of its own; leave the load at 0")
        given = {"load-step.shift": load, "load-step.moment": moment}
        wrist = wrist.with_values(**given) if carried else wrist + LoadStep(load, moment)
    return wrist


def dead_time_left(wrist: "Wrist", longest: float) -> float:
    """What a wrist's own dead time leaves of the longest of a loop [s]; all of it where it has none, 0 where
    less than a sample is left.

    A dead time that was traced says what the recordings had, not that the next tube is no longer.

    >>> from plants.wrist import Wrist
    >>> known = Wrist.flexion() + DeadTime(0.03)
    >>> round(dead_time_left(known, 0.05), 6), dead_time_left(Wrist.flexion(), 5e-4)
    (0.02, 0.0005)
    """
    own = float(np.max(dead_time_of(wrist.effects)))
    left = longest - own
    return left if own == 0.0 or left >= wrist.rig.sample_time else 0.0


def at_rest(
    wrist: "Wrist",
    start: Start,
    angle: Number,
    dead_time: Number | None = None,
    load: Number | None = None,
    moment: Number = BEFORE,
) -> State:
    """State of the wrist with dead time and load that holds still at an angle [deg], the virgin one
    where the load puts it; a load that comes at a later `moment` [s] bends nothing yet."""
    if load is not None:
        load = np.where(np.asarray(moment) < 0.0, load, 0.0)
    loaded = burdened(wrist, dead_time, load)
    if start == "virgin":
        state = loaded.rest()
        return state if load is None else plant.settled(state, loaded.sampled(), Around())
    if not all(e.SILENT for e in wrist.effects):
        return loaded.rest(start, angle)
    # The same in closed form, since a search asks for it thousands of times: only the load bends it.
    state = replace(wrist, effects=()).rest(start, angle if load is None else angle - load)
    effects = tuple(e.rest(loaded, state.pressure, state.memory.h) for e in loaded.effects)
    return state._replace(angle=angle, effects=effects)
