"""Commands judged: the exact simulator runs them, `design.metrics` says what they were worth."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design import metrics
from design.metrics import Metrics, Tally, Yardstick
from plants import wrist as plant
from plants.effects.effect import Around
from plants.errors import InputError
from plants.simulate import run_lanes
from plants.wrist import SAMPLE_TIME, SampledWrist, State, Wrist

Array = NDArray[np.float64]
DURATION = 10.0
"""How long a task lasts [s], as in `design.loop.run`."""


class Judged(NamedTuple):
    """A wrist, and the tally of its angle."""

    plant: State
    tally: Tally


class SampledJudged(NamedTuple):
    """Coefficients of the wrist and of the judge."""

    plant: SampledWrist
    yardstick: Yardstick


def step(s: Judged, inputs: tuple[Any, ...], c: SampledJudged) -> Judged:
    """One sample: judge the true angle and the command, then move; as `design.loop.step` without a
    controller.  `inputs`: index of the sample, command [V], and the time [s] of a wrist with effects."""
    sample, command, *time = inputs
    tally = metrics.update(s.tally, sample, s.plant.angle, command, c.yardstick)
    return Judged(plant.step(s.plant, command, c.plant, Around(*time)), tally)


@dataclass(frozen=True)
class Replay:
    """What commands do to a wrist: commands [V] (samples,), and before each of them the pressure [kPa],
    static angle [deg] and angle of the joint [deg], (samples,); and how that is judged."""

    commands: Array
    pressure: Array
    static_angle: Array
    angle: Array
    metrics: Metrics

    @property
    def time(self) -> Array:
        """Time of each sample [s]."""
        return np.asarray(np.arange(len(self.commands)) * SAMPLE_TIME, float)


def signals(wrist: Wrist, commands: Array, begin: float) -> dict[str, Array]:
    """The signals that `step` needs: the command, and for a wrist with effects the time [s]."""
    if not wrist.effects:
        return {"command": commands}
    return {"command": commands, "time": np.asarray(begin + np.arange(len(commands)) * SAMPLE_TIME, float)}


def replay(wrist: Wrist, commands: Any, reference: float, state: State, begin: float = 0.0) -> Replay:
    """Run commands [V], one per sample of 1 ms, from a state, and judge the step to a reference [deg].

    Commands that end before 10 s are held at their last value until then.  begin [s]: time of the
    start, for effects that depend on it.  Raises InputError for a command that is not finite, or none.

    >>> from plants import Wrist
    >>> wrist = Wrist.flexion()
    >>> held = replay(wrist, [4.0], 15.0, wrist.rest())   # full throttle all along goes too far
    >>> float(held.metrics.settling_time_s), round(float(held.angle[256]), 1)
    (inf, 14.8)
    """
    samples = round(DURATION / SAMPLE_TIME)
    v = np.asarray(commands, float)
    if v.ndim != 1 or not 0 < len(v) <= samples or not np.isfinite(v).all():
        raise InputError(f"commands: need 1 to {samples} finite numbers of volts, one per sample of 1 ms")
    v = np.concatenate([v, np.full(samples - len(v), v[-1])])
    given = signals(wrist, v, begin)
    c = SampledJudged(wrist.sampled(), metrics.yardstick(state.angle, reference))
    last, rows = run_lanes(
        step, Judged(state, metrics.begin(v[0])), c, samples, given, inputs=("sample", *given), every=1,
        record=("plant.pressure", "plant.memory.h", "plant.angle"), jobs=1,
    )  # fmt: skip
    P, h, y = rows[:, :-1, 0]
    return Replay(v, P, h, y, metrics.finish(last.tally, samples)[0])
