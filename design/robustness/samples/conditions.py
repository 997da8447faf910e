"""What a controller meets beside an uncertain plant: a tube, a load, a sensor that is not perfect."""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from plants.effects.regulator.dead_time import DeadTime
from plants.effects.wrist.load_step import LoadStep
from plants.errors import InputError
from plants.rig import Rig, built_in_rig
from plants.simulation.disturbance import burdened
from plants.wrist import Wrist

Number = Any
_PAPER = built_in_rig().uncertainty


@dataclass(frozen=True)
class Conditions:
    """Bounds within which the conditions of a run are drawn; 0 leaves one out.

    All defaults are those of the built-in rig's file, which says that they are assumed.

    dead_time [s]: drawn uniformly from 0 to it.
    load [deg]: shift of the static angle, drawn uniformly from -load to load, there from the start.
    noise [deg]: standard deviation of white noise of the sensor, normal, a new value every 10 ms, held
        in between.
    quantum [deg]: resolution of the angle sensor.

    Raises InputError for a value that is negative or not finite, and a dead time beyond that of the effect.
    """

    dead_time: float = _PAPER.dead_time[1]
    load: float = _PAPER.load
    noise: float = _PAPER.noise
    quantum: float = _PAPER.resolution

    @classmethod
    def of(cls, rig: Rig) -> "Conditions":
        """What a rig declares."""
        u = rig.uncertainty
        return cls(u.dead_time[1], u.load, u.noise, u.resolution)

    def __post_init__(self) -> None:
        for f in fields(self):
            value = getattr(self, f.name)
            if not (np.isfinite(value) and value >= 0.0):
                raise InputError(f"conditions: {f.name} = {value:g}; give a number that is not negative")
        longest = DeadTime.kinds()["delay"].high
        if self.dead_time > longest:
            raise InputError(f"conditions: dead_time = {self.dead_time:g} s; give at most {longest:g} s")

    @property
    def by_name(self) -> dict[str, float]:
        """The conditions as a dictionary, for JSON."""
        return {f.name: float(getattr(self, f.name)) for f in fields(self)}


NONE = Conditions(0.0, 0.0, 0.0, 0.0)
"""Conditions that add nothing: only plant, memory and sign of the step vary."""


def left_out(wrist: Wrist, conditions: Conditions) -> tuple[str, ...]:
    """Conditions that are not drawn because the plant has an effect of that name, in words.

    >>> left_out(Wrist.flexion() + DeadTime(0.03), Conditions())
    ('dead_time: the plant has its own dead-time',)
    """
    own = {e.NAME for e in wrist.effects}
    asked = {"dead_time": (conditions.dead_time, DeadTime.NAME), "load": (conditions.load, LoadStep.NAME)}
    return tuple(
        f"{name}: the plant has its own {effect}"
        for name, (size, effect) in asked.items()
        if size > 0.0 and effect in own
    )


def added(wrist: Wrist, conditions: Conditions, dead_time: Number, load: Number) -> Wrist:
    """The wrist behind a tube of a dead time [s] and under a load [deg], one entry per lane, as far as the
    conditions ask for them and the wrist has none of its own."""
    own = {e.NAME for e in wrist.effects}
    late = conditions.dead_time > 0.0 and DeadTime.NAME not in own
    loaded = conditions.load > 0.0 and LoadStep.NAME not in own
    return burdened(wrist, dead_time if late else None, load if loaded else None)
