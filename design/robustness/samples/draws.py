"""Cases drawn from a box: plants, starting memories, signs of the step, conditions, noise.

What sample i is depends on the seed and on i alone: samples are drawn in chunks of `CHUNK`, each
chunk from a place of its own in the counter of a Philox generator (Salmon et al., Parallel random
numbers: as easy as 1, 2, 3, SC 2011, doi 10.1145/2063384.2063405), whoever draws it and when.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Controller
from design.robustness.box import Box
from design.robustness.samples.conditions import Conditions, beside, left_out
from plants.dynamics import settled
from plants.effects.effect import Around, Effect
from plants.equilibrium import at_rest, holding_command, searched
from plants.kernel import pytrees as tree
from plants.simulation.disturbance import burdened
from plants.simulation.sensor import HOLD
from plants.wrist import STARTS, Start, State, Wrist

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

CHUNK = 1024
"""Samples that are drawn and run together: large enough that drawing costs little, and fixed, since
what a sample is depends on it.  A multiple of `plants.kernel.templates.LANES`."""

CASES, NOISE = 0, 1  # streams of a chunk
LINES: tuple[Start, Start] = ("line1", "line2")
FIRST = 4  # rows of a draw before those of the box: memory, sign, dead time, load


@dataclass(frozen=True)
class SamplingTask:
    """What is sampled: a controller on the plants of a box under conditions, stepped by +-reference [deg] and
    run for a duration [s]."""

    box: Box
    controller: Controller
    conditions: Conditions
    seed: int
    reference: float
    duration: float


@dataclass(frozen=True)
class Draw:
    """Cases that were drawn, arrays of shape (n,).

    wrist, state: their lanes, at rest at the start; reference [deg]; start: index into `STARTS`;
    values: what was drawn, by name; out_of_reach: no command in the range holds the reference, or the
    start.
    """

    wrist: Wrist
    state: State
    reference: Array
    start: NDArray[np.intp]
    values: dict[str, Array]
    out_of_reach: Flags


def generator(seed: int, chunk: int, stream: int) -> np.random.Generator:
    """The numbers of a chunk: the upper half of the counter says which, the lower half counts them."""
    return np.random.Generator(np.random.Philox(key=seed, counter=[0, 0, chunk, stream]))


def draw(task: SamplingTask, chunk: int, count: int = CHUNK) -> Draw:
    """The first `count` cases of a chunk: independent, uniform over the box, over the four starting
    memories and both signs of the step, and over the conditions."""
    box, conditions = task.box, beside(task.box.wrist, task.conditions)
    u = generator(task.seed, chunk, CASES).random((FIRST + len(box.intervals), CHUNK))[:, :count]
    start = (len(STARTS) * u[0]).astype(np.intp)
    reference = np.where(u[1] < 0.5, -task.reference, task.reference)
    dead_time, load = conditions.dead_time * u[2], conditions.load * (2.0 * u[3] - 1.0)
    plant = box.at(u[FIRST:])
    late, loaded = conditions.dead_time > 0.0, conditions.load > 0.0
    wrist = burdened(plant, dead_time if late else None, load if loaded else None)
    values = box.coordinates(u[FIRST:])
    values |= {"dead_time": dead_time} if late else {}
    values |= {"load": load} if loaded else {}
    state = _chosen(start, [_rest(plant, wrist, s, np.zeros(count), load) for s in STARTS])
    held = [_pressure(plant, line, reference, load)[0] for line in LINES]
    arrival = np.where(reference > state.angle, *held)
    out = _beyond(task.controller, wrist, arrival) | _beyond(task.controller, wrist, state.pressure)
    if plant.effects:
        out |= kept_from(wrist, arrival, reference)
        out |= (start > 0) & (start < 3) & kept_from(wrist, state.pressure, np.zeros(count))
    return Draw(wrist, state, reference, start, values, out)


def noise(task: SamplingTask, chunk: int, count: int = CHUNK) -> Array | None:
    """Noise of a chunk's sensors, of standard deviation 1, shape (rows, count), a row for every `HOLD`
    samples; None where the conditions have none.  Row by row, so that a longer run begins like a shorter."""
    if task.conditions.noise == 0.0:
        return None
    rows = -(-round(task.duration / task.box.plant.rig.sample_time) // HOLD)
    return generator(task.seed, chunk, NOISE).standard_normal((rows, CHUNK))[:, :count]


def remarks(task: SamplingTask) -> tuple[str, ...]:
    """Conditions that are not drawn, in words, and why."""
    return left_out(task.box.wrist, task.conditions)


def _rest(plant: Wrist, wrist: Wrist, start: Start, angle: Array, load: Array) -> State:
    """Rest at an angle [deg] under a load [deg]: the loop is where load and effects take it to that
    angle; a virgin wrist, which never moved, lets the load sag.

    `plants.equilibrium` lets effects come to rest at the loop's angle; what acts after the load, such as
    creep, rests at the loaded one.
    """
    pressure, h = _pressure(plant, start, angle, load)
    after = [_acts_after_load(c) for c in wrist.sampled().effects] if wrist.effects else []
    effects = tuple(
        e.rest(wrist, pressure, h + load if late else h) for e, late in zip(wrist.effects, after, strict=True)
    )
    state = State(pressure, plant.hysteresis.resting(start, h, pressure), angle, effects)
    if start == "virgin" and wrist.effects:
        state = settled(state, wrist.sampled(), Around())
    return state


def _pressure(plant: Wrist, start: Start, angle: Array, load: Array) -> tuple[Array, Array]:
    """Pressure [kPa] and angle of the loop [deg] of a rest at an angle [deg] under a load [deg]."""
    if not plant.effects:
        h = angle if start == "virgin" else angle - load
        return np.asarray(at_rest(plant, start, h).pressure, float), h
    late = [_acts_after_load(c) for c in plant.sampled().effects]
    before = replace(plant, effects=tuple(e for e, x in zip(plant.effects, late, strict=True) if not x))
    h = at_rest(plant, start, angle).memory.h
    h = h if start == "virgin" else h - load
    return np.asarray(at_rest(before, start, h).pressure, float), h


def _acts_after_load(coefficients: Any) -> bool:
    """Whether an effect acts on the loop's angle or on the joint, not on what drives the loop."""
    return any(hasattr(coefficients, port) for port in ("static", "joint", "friction", "stop"))


def _chosen(start: NDArray[np.intp], rests: list[State]) -> State:
    """The lanes of the rest that each lane starts from."""
    leaves = zip(*(tree.leaves(rest) for rest in rests), strict=True)
    state: State = tree.like(
        rests[0], [np.choose(start, [np.broadcast_to(x, start.shape) for x in leaf]) for leaf in leaves]
    )
    return state


def _beyond(controller: Controller, wrist: Wrist, pressure: Array) -> Flags:
    """Where the command that holds a pressure [kPa] is outside the controller's range."""
    command = holding_command(wrist, pressure)
    ends = zip(("low", "high"), wrist.rig.command_range, strict=True)
    low, high = (getattr(controller, n, end) for n, end in ends)
    return np.asarray((command < low) | (command > high), np.bool_)


def kept_from(wrist: Wrist, pressure: Array, angle: Array) -> Flags:
    """Where an effect keeps the wrist from an angle [deg] that needs a pressure [kPa], lane by lane."""
    lowest, highest, _ = searched(wrist)
    out = ~((pressure > lowest) & (pressure < highest))
    for effect in wrist.effects:
        if type(effect).obstacle is Effect.obstacle:
            continue
        lanes = {n: np.broadcast_to(v, out.shape) for n, v in vars(effect).items()}
        for i in range(out.size):
            alone = type(effect)(**{n: float(v[i]) for n, v in lanes.items()})
            out[i] |= alone.obstacle(float(pressure[i]), float(angle[i])) is not None
    return np.asarray(out, np.bool_)
