"""What of a traced plant a controller is designed for.

An effect of the sensor is the same under any gains.  An event of the recordings, such as a load that was
picked up, is no property of the rig: at its moment every run of the design would have it, and no gains keep
the overshoot of a step small that has a load step within it.  Loads of the size that the rig states are cases
of the requirement.

An angle that is read late is late for the controller too, unless the logger alone is (which its
campaign.toml states).  In a loop a delay of the sensor and one of the command are the same, so that it is
added to the plant's dead time.
"""

from dataclasses import replace

from plants.actuator.delay import LONGEST
from plants.effects.regulator.dead_time import DeadTime
from plants.errors import InputError
from plants.parameters.correlation import pairs_of
from plants.parameters.quantities import ParameterSet


def designed(plant: ParameterSet) -> ParameterSet:
    """The plant without what a design leaves out, the delay of its angle in its dead time.

    Raises InputError, in one line, for a dead time of more samples than a loop of compiled laws can hold.
    """
    found = in_loop(without(plant, left_out(plant)))
    late, dt = found.values.get(f"{DeadTime.NAME}.{DeadTime.DELAY}", 0.0), found.rig.sample_time
    if late > (LONGEST - 1) * dt:
        raise InputError(
            f"{plant.title}: a dead time of {late:.3g} s is more than {LONGEST - 1} samples of {dt:g} s; "
            "give a longer sample time of the loop, loop_s in [rig.time]"
        )
    return found


def in_loop(plant: ParameterSet) -> ParameterSet:
    """The plant as a controller meets it: the delay of its angle is added to its dead time.

    >>> from plants.parameters.files import built_in
    >>> flexion = built_in("flexion")
    >>> in_loop(replace(flexion, rig=replace(flexion.rig, angle_delay=0.08))).values["dead-time.delay"]
    0.08
    """
    late = plant.rig.angle_delay
    if not late:
        return plant
    rig, delay = replace(plant.rig, angle_delay=0.0), f"{DeadTime.NAME}.{DeadTime.DELAY}"
    if delay in plant.parameters:
        own = plant.parameters[delay]
        own = replace(own, value=own.value + late, high=max(own.high, own.value + late))
        return replace(plant, rig=rig, parameters={**plant.parameters, delay: own})
    of_log = "the delay of the angle in the log"
    whole = plant.revised((DeadTime,), {delay: late}, {}, of_log, plant.title)
    return replace(whole, rig=rig, remainder=plant.remainder, correlation=plant.correlation)


def left_out(plant: ParameterSet) -> tuple[str, ...]:
    """Names of the plant's effects that sit in its sensor or happened once.

    >>> from plants.effects import LoadStep
    >>> from plants.parameters.files import built_in
    >>> left_out(replace(built_in("flexion"), effects=(LoadStep,)))
    ('load-step',)
    """
    return tuple(e.NAME for e in plant.effects if e.STAGE == "sensor" or e.EVENT)


def events(plant: ParameterSet) -> tuple[str, ...]:
    """Names of the plant's effects that happened once, in the recordings."""
    return tuple(e.NAME for e in plant.effects if e.EVENT)


def without(plant: ParameterSet, names: tuple[str, ...]) -> ParameterSet:
    """The plant without the effects of some names."""
    kept = {n: p for n, p in plant.parameters.items() if n.split(".")[0] not in names}
    effects = tuple(e for e in plant.effects if e.NAME not in names)
    return replace(plant, parameters=kept, effects=effects, correlation=pairs_of(plant.correlation, kept))
