"""Commands judged: the exact simulator runs them, `design.evaluation.metrics` says what they were worth."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.evaluation import metrics
from design.evaluation.metrics import Metrics
from plants.errors import InputError
from plants.simulation.closed_loop import ClosedLoop, SampledClosedLoop, advance, clock
from plants.simulation.reference_profile import ReferenceProfile
from plants.wrist import SAMPLE_TIME, State, Wrist

Array = NDArray[np.float64]
DURATION = 10.0
"""How long a task lasts [s], as in `design.evaluation.steps.run`."""


@dataclass(frozen=True)
class CommandReplay:
    """What commands do to a wrist: commands [V] (samples,), and before each of them the pressure [kPa],
    static angle [deg] and angle of the joint [deg], (samples,); and how that is judged."""

    commands: Array
    pressure: Array
    static_angle: Array
    angle: Array
    metrics: Metrics
    dt: float = SAMPLE_TIME

    @property
    def time(self) -> Array:
        """Time of each sample [s]."""
        return np.asarray(np.arange(len(self.commands)) * self.dt, float)


def replay(wrist: Wrist, commands: Any, reference: float, state: State, begin: float = 0.0) -> CommandReplay:
    """Run commands [V], one per sample of 1 ms, from a state, and judge the step to a reference [deg].

    Commands that end before 10 s are held at their last value until then.  begin [s]: time of the
    start, for effects that depend on it.  Raises InputError for a command that is not finite, or none.

    >>> from plants import Wrist
    >>> wrist = Wrist.flexion()
    >>> held = replay(wrist, [4.0], 15.0, wrist.rest())   # full throttle all along goes too far
    >>> float(held.metrics.settling_time_s), round(float(held.angle[256]), 1)
    (inf, 14.8)
    """
    samples = round(DURATION / wrist.rig.sample_time)
    v = np.asarray(commands, float)
    if v.ndim != 1 or not 0 < len(v) <= samples or not np.isfinite(v).all():
        raise InputError(f"commands: need 1 to {samples} finite numbers of volts, one per sample of 1 ms")
    v = np.concatenate([v, np.full(samples - len(v), v[-1])])
    judge, c = metrics.of_step(state.angle, reference, wrist.rig), wrist.sampled()
    first = ClosedLoop(state, judge=judge.begin(v[0]))
    last, rows = advance(
        first, SampledClosedLoop(c, (), ReferenceProfile((reference,)), judge), samples,
        {"command": v, **clock(wrist, samples, begin)}, every=1,
        record=("plant.pressure", "plant.memory.h", "plant.angle"), jobs=1,
    )  # fmt: skip
    P, h, y = rows[:, :-1, 0]
    return CommandReplay(v, P, h, y, judge.finish(last.judge, samples)[0], wrist.rig.sample_time)
