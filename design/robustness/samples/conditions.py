"""What a controller meets beside an uncertain plant: a tube, a load, a sensor that is not perfect."""

from dataclasses import dataclass, fields, replace

import numpy as np

from plants.effects.regulator.dead_time import DeadTime
from plants.effects.wrist.load_step import LoadStep
from plants.errors import InputError
from plants.rig import Rig, built_in_rig
from plants.simulation.disturbance import dead_time_left
from plants.wrist import Wrist

_PAPER = built_in_rig().uncertainty


@dataclass(frozen=True)
class Conditions:
    """Bounds within which the conditions of a run are drawn; 0 leaves one out.

    All defaults are those of the built-in rig's file, which says that they are assumed.

    dead_time [s]: of the whole loop; drawn uniformly from the plant's own, 0 of most, to it.
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


def beside(wrist: Wrist, conditions: Conditions) -> Conditions:
    """What of the conditions a wrist meets beside its own effects: the dead time that is left of the longest,
    and no load where it has a load step.

    >>> round(beside(Wrist.flexion() + DeadTime(0.03), Conditions()).dead_time, 6)
    0.02
    """
    late = dead_time_left(wrist, conditions.dead_time)
    loaded = any(e.NAME == LoadStep.NAME for e in wrist.effects)
    return replace(conditions, dead_time=late, load=0.0 if loaded else conditions.load)


def left_out(wrist: Wrist, conditions: Conditions) -> tuple[str, ...]:
    """Conditions that are not drawn because the plant has as much of its own, in words.

    >>> left_out(Wrist.flexion() + DeadTime(0.08), Conditions())
    ('dead_time: the plant has its own dead-time',)
    """
    met = beside(wrist, conditions)
    asked = {"dead_time": DeadTime.NAME, "load": LoadStep.NAME}
    return tuple(
        f"{name}: the plant has its own {effect}"
        for name, effect in asked.items()
        if getattr(conditions, name) > 0.0 and getattr(met, name) == 0.0
    )
