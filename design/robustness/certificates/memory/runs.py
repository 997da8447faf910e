"""The tasks of the rig, run sample by sample on the plant as it is, with clipping: finitely many runs."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from design.controllers.pi import PI
from design.evaluation.tasks import Task
from plants.dynamics import step as move
from plants.hysteresis import STARTS, Start
from plants.simulation.closed_loop import holding
from plants.simulation.sensor import Measured
from plants.wrist import State, Wrist

Array = NDArray[np.float64]

ENDS: tuple[Start, Start] = ("line2", "line1")
"""Starts between which every other memory lies."""

MEMORIES = 9
"""Memories between the two lines from which each step is run as well, the ends included."""


@dataclass(frozen=True)
class Runs:
    """Signals at every sample, (samples, lanes): pressure and command (times the regulator's gain) [kPa],
    static angle, angle and reference [deg], whether the virgin curve was left; low and high [kPa] of the
    command, rest [kPa] (lanes,) what was sent before; begins (lanes,): the sample from which the last
    reference holds; names of the lanes."""

    pressure: Array
    static: Array
    angle: Array
    reference: Array
    command: Array
    left_virgin: NDArray[np.bool_]
    low: float
    high: float
    rest: Array
    begins: NDArray[np.intp]
    names: tuple[str, ...]

    @property
    def clipped(self) -> NDArray[np.bool_]:
        """Whether the command stands at an end of its range, (samples, lanes)."""
        found: NDArray[np.bool_] = (self.command <= self.low) | (self.command >= self.high)
        return found


def run(wrist: Wrist, controller: PI, tasks: Sequence[Task], samples: int, dt: float) -> Runs:
    """The tasks, and their steps from `MEMORIES` memories between the lines too, behind so many samples of
    dead time in all; dt [s]: sample time; effects of the plant are left out.  A controller with a weight of
    the reference is a PI once the reference holds, so that the functions for a PI are about it.

    Each lane begins at rest, its last command everywhere in the tube.
    """
    plain = replace(wrist, effects=())
    state, profiles, names = _starts(plain, tasks)
    lanes, length = len(names), max(round(t.duration / dt) for t in tasks)
    asked = np.zeros((length, lanes))
    for lane, task in enumerate(profiles):
        for reference, moment, _ in task.stages:
            asked[round(moment / dt) :, lane] = reference
    held = holding(plain, controller, state)
    coefficients, law = plain.sampled(dt), controller.sampled(dt)
    before = np.asarray(controller.command(held), float)
    pressure, static, angle, given = (np.empty((length, lanes)) for _ in range(4))
    left = np.empty((length, lanes), bool)
    for k in range(length):
        pressure[k], static[k], angle[k] = state.pressure, state.memory.h, state.angle
        left[k] = getattr(state.memory, "virgin", 0.0) == 0.0
        held, given[k] = law.act(held, Measured(asked[k] - state.angle, state.angle, state.pressure))
        state = move(state, given[k - samples] if k >= samples else before, coefficients)
    gain = float(wrist.regulator.gain)
    begins = np.array([round(t.stages[-1][1] / dt) for t in profiles])
    return Runs(
        pressure, static, angle, asked, gain * given, left, gain * float(controller.low),
        gain * float(controller.high), gain * before, begins, tuple(names),
    )  # fmt: skip


def _starts(wrist: Wrist, tasks: Sequence[Task]) -> tuple[State, list[Task], list[str]]:
    """The state that each lane begins in, its task and its name."""
    found = [(wrist.rest(t.start, t.angle), t, t.name) for t in tasks]
    inside = [t for t in tasks if t.start == STARTS[-1] and len(t.references) == 1]
    for task in inside:
        low, high = (float(wrist.rest(start, task.angle).pressure) for start in ENDS)
        base = wrist.rest(task.start, task.angle)
        for pressure in np.linspace(low, high, MEMORIES):
            memory = wrist.hysteresis.recalled(base.memory.h, float(pressure))
            lane = base._replace(pressure=float(pressure), memory=memory)
            found.append((lane, task, f"{task.name} at {pressure:.4g} {wrist.rig.units.pressure}"))
    states = [s for s, _, _ in found]
    memory = type(states[0].memory)(
        *(np.array(x, float) for x in zip(*(s.memory for s in states), strict=True))
    )
    pressure, angle = (np.array([float(getattr(s, n)) for s in states]) for n in ("pressure", "angle"))
    return State(pressure, memory, angle), [t for _, t, _ in found], [n for _, _, n in found]
