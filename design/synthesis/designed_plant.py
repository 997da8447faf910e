"""What of a traced plant a controller is designed for.

An effect of the sensor is the same under any gains.  An event of the recordings, such as a load that was
picked up, is no property of the rig: at its moment every run of the design would have it, and no gains keep
the overshoot of a step small that has a load step within it.  Loads of the size that the rig states are cases
of the requirement.
"""

from dataclasses import replace

from plants.parameters.correlation import pairs_of
from plants.parameters.quantities import ParameterSet


def designed(plant: ParameterSet) -> ParameterSet:
    """The plant without what a design leaves out."""
    return without(plant, left_out(plant))


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
