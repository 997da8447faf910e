"""Test vectors of a plant: 10,000 commands, and what the simulator of this project answered."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from design.export.plant.part import PlantPart
from plants.simulation.open_loop import open_loop
from plants.wrist import Wrist

Array = NDArray[np.float64]

STEPS = 10_000
BEGIN = 0.25
"""Time at which the vector starts [s]: not 0, so that a target that forgets it is seen."""

HELD = 400
"""Samples for which a command is held among the jumps."""


class PlantVector(NamedTuple):
    """Time of the start [s]; inputs, shape (steps, inputs), and what Python shows after each sample of angle
    and pressure, shape (steps, 2)."""

    begin: float
    given: Array
    shown: Array


def plant_vector(part: PlantPart, wrist: Wrist, steps: int = STEPS, seed: int = 0) -> PlantVector:
    """Jumps, a chirp, ramps, and small steps over the whole range of the command; where the other motion
    matters, it moves too."""
    draw = np.random.default_rng(seed)
    low, high = wrist.rig.command_range
    command = low + (high - low) * shares(steps, draw)
    first, last = wrist.rig.pressure_range
    phase = np.arange(steps) * (2.0 * np.pi / 3700.0)
    other = wrist.rig.rest_pressure + 0.3 * (last - first) * np.sin(phase + 0.5)
    response = open_loop(
        wrist, command, every=1, other_pressure=other if 1 in part.columns else None, begin=BEGIN
    )
    given = np.column_stack([command, other])[:, list(part.columns)]
    return PlantVector(BEGIN, given, np.column_stack([response.angle, response.pressure])[1:])


def shares(steps: int, draw: np.random.Generator) -> Array:
    """Of the range of the command, a share for each step, a quarter of the steps of each kind."""
    k = np.arange(steps)
    jumps = np.repeat(draw.uniform(0.0, 1.0, steps // HELD + 1), HELD)[:steps]
    jumps[: min(HELD, steps)] = 0.5
    chirp = 0.5 + 0.45 * np.sin(2.0 * np.pi * (0.0002 + 4e-8 * k) * k)
    ramps = np.abs((k / 1500.0) % 2.0 - 1.0)
    small = 0.5 + np.clip(np.cumsum(draw.normal(0.0, 0.01, steps)), -0.4, 0.4)
    part = np.minimum(k * 4 // steps, 3)
    return np.asarray(np.select([part == 0, part == 1, part == 2], [jumps, chirp, ramps], small), float)


def plant_csv(part: PlantPart, found: PlantVector) -> str:
    """The vector as a table, numbers as exact as they are."""
    names = [f.member for f in part.inputs] + [f"expected_{f.member}" for f in part.outputs]

    def lines() -> Iterator[str]:
        for row in np.column_stack([found.given, found.shown]).tolist():
            yield ",".join(map(repr, row))

    return ",".join(names) + "\n" + "\n".join(lines()) + "\n"
