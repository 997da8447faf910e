"""An MPC in the loop: the plant advances by compiled code, a period at a time, the command held.

A QP cannot be part of a law that is compiled, so the loop of `design.loop` is cut at the periods; the
judge is the same, sample by sample (1 ms).  A dead time of transport is kept here, since the line of a
delay does not outlast a call of the compiled plant: it is the command that is late.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from design import metrics
from design.controllers.controller import Measured
from design.loop import Trajectory
from design.metrics import Metrics, Tally, Yardstick
from design.mpc.fallback import Info
from design.mpc.fallback import State as MPCState
from design.mpc.problem import Problem
from plants import tree
from plants import wrist as plant
from plants.delay import arriving
from plants.effects.dead_time import DeadTime, TubeDeadTime
from plants.effects.effect import Around
from plants.errors import InputError
from plants.simulate import run_lanes
from plants.wrist import SAMPLE_TIME, SampledWrist, State, Wrist

Array = NDArray[np.float64]


class PeriodicController(Protocol):
    """What the loop plays: `init` and `step`, once a period."""

    @property
    def problem(self) -> Problem:
        """Whose period it is."""
        ...

    def init(self, seen: Measured) -> MPCState:
        """State in which a wrist that is seen to rest is held."""
        ...

    def step(self, state: MPCState, seen: Measured) -> tuple[MPCState, float, Info]:
        """One period."""
        ...


class Played(NamedTuple):
    """State of plant and judge."""

    plant: State
    tally: Tally


class SampledPlayed(NamedTuple):
    """Coefficients of plant and judge."""

    plant: SampledWrist
    yardstick: Yardstick


@dataclass(frozen=True)
class Sensor:
    """Of the angle: standard deviation of its noise [deg], quantum [deg], seed of the noise."""

    noise: float = 0.0
    quantum: float = 0.0
    seed: int = 0


class Play(NamedTuple):
    """A run: metrics, last states of plant with judge and of the controller, signals of every sample
    where they were recorded, and how each period went."""

    metrics: Metrics
    last: Played
    controller: MPCState
    trajectory: Trajectory | None
    periods: list[Info]


def _step(s: Played, inputs: tuple[Any, ...], c: SampledPlayed) -> Played:
    """One sample: judge by the true angle, move.  inputs: command that reaches the valve and command
    that was given [V], index of the sample, time [s]."""
    arrives, given, index, time = inputs
    tally = metrics.update(s.tally, index, s.plant.angle, given, c.yardstick)
    return Played(plant.step(s.plant, arrives, c.plant, Around(time)), tally)


def without_delay(wrist: Wrist) -> tuple[Wrist, float]:
    """The wrist with the transport delay of its dead time taken out, and that delay [s]."""
    late = [e for e in wrist.effects if isinstance(e, DeadTime | TubeDeadTime)]
    if not late:
        return wrist, 0.0
    effects = tuple(replace(e, delay=0.0) if e in late else e for e in wrist.effects)
    return replace(wrist, effects=effects), float(late[0].delay)


def run(
    wrist: Wrist,
    controller: PeriodicController,
    reference: float,
    state: State | None = None,
    duration: float = 10.0,
    record: bool = False,
    sensor: Sensor | None = None,
    begin: float = 0.0,
    memory: MPCState | None = None,
) -> Play:
    """Step the reference [deg] at time 0 and play the loop for a duration [s], a whole number of periods.

    Metrics are those of `design.loop.run`, leaves of shape (1,), and so is the trajectory.  The loop
    starts from `state` (the wrist's rest where not given), of which the controller sees angle and pressure;
    `memory`: its state where it has been acting before.  Raises
    InputError for a duration that is no number of periods and for a wrist whose parameters are arrays.
    """
    substeps = controller.problem.substeps
    periods = round(duration / SAMPLE_TIME / substeps)
    if periods < 1 or abs(periods * substeps * SAMPLE_TIME - duration) > 1e-9:
        raise InputError(f"duration of {duration:g} s: give a multiple of {substeps * SAMPLE_TIME:g} s")
    if any(np.ndim(v) for v in wrist.values.values()):
        raise InputError("an MPC is played on one wrist at a time: give parameters that are numbers")
    prompt, delay = without_delay(wrist)
    at_rest = prompt.rest() if state is None else state
    c = SampledPlayed(prompt.sampled(), metrics.yardstick(at_rest.angle, reference))
    see = _sensor(sensor or Sensor())
    if memory is None:
        seen = see(float(plant.read(at_rest, c.plant, Around(begin))))
        memory = controller.init(Measured(0.0, seen, float(at_rest.pressure)))
    held, late = np.array([memory.command]), np.array([delay / SAMPLE_TIME])
    commands = np.full(periods * substeps, memory.command)
    loop, infos = Played(at_rest, metrics.begin(memory.command)), list[Info]()
    names = [n for n in tree.names(loop) if n.startswith("plant.")] if record else []
    pieces = []
    for k in range(periods):
        first, last = k * substeps, (k + 1) * substeps
        around = Around(begin + first * SAMPLE_TIME)
        seen = see(float(plant.read(loop.plant, c.plant, around)))
        measured = Measured(reference - seen, seen, float(loop.plant.pressure))
        memory, command, info = controller.step(memory, measured)
        infos.append(info)
        commands[first:] = command
        index = np.arange(first, last, dtype=float)
        signals = {
            "arrives": arriving(commands[:, None], held, late, index)[:, 0], "given": commands[first:last],
            "index": index, "time": begin + index * SAMPLE_TIME,
        }  # fmt: skip
        after, rows = run_lanes(
            _step, loop, c, substeps, signals, tuple(signals), int(record), tuple(names), jobs=1
        )
        loop = tree.like(loop, [float(x[0]) for x in tree.leaves(after)])
        pieces.append(rows[:, :-1] if k < periods - 1 else rows)
    judged = metrics.finish(tree.like(loop.tally, [np.array([x]) for x in loop.tally]), periods * substeps)
    return Play(
        judged, loop, memory, _trajectory(pieces, commands, loop, c, begin) if record else None, infos
    )


def _sensor(s: Sensor) -> Any:
    rng = np.random.default_rng(s.seed)

    def see(angle: float) -> float:
        noisy = angle + (s.noise * rng.standard_normal() if s.noise else 0.0)
        return float(np.round(noisy / s.quantum) * s.quantum) if s.quantum else noisy

    return see


def _trajectory(
    pieces: list[Array], commands: Array, like: Played, c: SampledPlayed, begin: float
) -> Trajectory:
    rows = np.concatenate(pieces, axis=1)
    time = np.asarray(np.arange(rows.shape[1]) * SAMPLE_TIME, float)
    went = tree.like(like.plant, rows)
    given = np.concatenate([commands, commands[-1:]])[:, None]
    seen = plant.read(went, c.plant, Around(begin + time[:, None]))
    return Trajectory(time, went.angle, went.memory.h, went.pressure, given, seen)
