"""A closed-loop run over a sequence of references, of which the last step is judged.

A step that comes before the one before it has settled meets a wrist that still moves and an
integrator that is still on its way: a state that no start from rest has.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.controllers.controller import Controller
from design.evaluation import metrics, runner
from design.evaluation.metrics import Metrics
from plants.kernel import pytrees as tree
from plants.simulation.closed_loop import Trajectory
from plants.simulation.disturbance import BEFORE, at_rest, burdened
from plants.simulation.periodic import Periodic
from plants.simulation.reference_profile import ReferenceProfile
from plants.simulation.sensor import PERFECT, Sensor
from plants.wrist import Start, State, Wrist

Number = Any
Array = NDArray[np.float64]

CALM = (3.0, 5.0)
"""How long [s] the reference before the last is held, shortest and longest, where the last step is to begin
calmly.  A step that begins in full motion overshoots by what the wrist has of it, under any gains: 150 % of a
step of 5 deg were found where it might begin after 0.3 s.  What is left after 3 s is the slow end of the
motion, and memory."""

SMALLEST = 1.0 / 3.0
"""What is judged relative to a step is so to one of at least this share of the task's: a reference that is
changed just as the wrist passes it would make any overshoot a large share of a tiny step."""


@dataclass(frozen=True)
class Sequence:
    """A wrist at rest at an angle [deg], having come there by `start`, and what it is asked then.

    references [deg], each held for so many seconds of `holds`, of which the last is the time for
    which the last step is judged; dead_time [s]: beside the wrist's own; load [deg]: constant shift
    of the static angle, there from load_at [s] on, before the run where that is negative; plant: in words
    which wrist it is.  With a load the virgin wrist starts where the load puts it.  Raises ValueError for
    references without times.
    """

    start: Start
    angle: float
    references: tuple[float, ...]
    holds: tuple[float, ...]
    wrist: Wrist
    dead_time: float = 0.0
    load: float = 0.0
    plant: str = "nominal"
    load_at: float = BEFORE

    def __post_init__(self) -> None:
        if not self.references or len(self.references) != len(self.holds):
            raise ValueError("a sequence needs references, and as many times to hold them")

    @property
    def of_task(self) -> bool:
        """Whether the step that is judged is the task's: of its size, between 0 and that, begun calmly and
        not a mere load."""
        before = (self.angle, *self.references)[-2]
        ends = {abs(before), abs(self.references[-1])}
        calm = len(self.references) == 1 or self.holds[-2] >= CALM[0]
        return ends == {0.0, self.wrist.rig.task.step} and calm and self.load_at < 0.0

    @property
    def name(self) -> str:
        """In words, such as ``0, +15 (0.8 s), -10 deg from line2, nominal plant, 40 ms of dead time``."""
        steps = [f"{self.angle:+.3g}".replace("+0", "0")]
        steps += [f"{r:+.3g} ({h:.3g} s)" for r, h in zip(self.references, self.holds, strict=True)]
        steps[-1] = f"{self.references[-1]:+.3g} deg"
        more = f", {1000 * self.dead_time:.3g} ms of dead time" if self.dead_time else ""
        more += f", load {self.load:+.3g} deg" if self.load else ""
        more += f" after {self.load_at:.3g} s" if self.load and self.load_at >= 0.0 else ""
        return f"{', '.join(steps)} from {self.start}, {self.plant} plant{more}"


@dataclass(frozen=True)
class Batch:
    """Sequences as lanes: wrist with dead time and load as effects, its state at rest, references
    [deg] and samples at which each begins (k, lanes), samples for which the last is judged (lanes,)."""

    wrist: Wrist
    state: State
    references: Array
    switches: Array
    judged: Array


@dataclass(frozen=True)
class PlayedSequence:
    """What became of sequences: metrics of the last step, leaves (lanes,); start [deg] (lanes,), the
    true angle where that began; size [deg] of that step, and of the task's;
    reference [deg] (samples, lanes) and trajectory where recorded."""

    metrics: Metrics
    start: Array
    size: Array
    step: float
    reference: Array | None = None
    trajectory: Trajectory | None = None

    @property
    def values(self) -> dict[str, Array]:
        """What limits and cost are held against, by name, each (lanes,).

        A step of the rig's task is what the limits and the tuning set are made for, so
        others are scaled to it: overshoot in percent of the step, of one of `SMALLEST` at least;
        steady error in percent of the task's step, since how exactly an angle is held is a matter of
        degrees; total variation of the command of a larger step as if scaled
        down to it (a smaller one must travel for the play of the loop all the same, and is not scaled up);
        IAE and ITAE per degree of a step of `SMALLEST` at least, times that step.
        """
        smallest = SMALLEST * self.step
        m, size = self.metrics, np.maximum(self.size, smallest)
        return {
            "overshoot_percent": np.nan_to_num(m.overshoot_percent * np.minimum(self.size / smallest, 1.0)),
            "steady_error_percent": 100.0 * m.steady_state_error_deg / self.step,
            "total_variation_V": m.total_variation_V * np.minimum(self.step / size, 1.0),
            "iae_deg_s": m.iae_deg_s * self.step / size,
            "itae_deg_s2": m.itae_deg_s2 * self.step / size,
            "settling_time_s": m.settling_time_s,
        }


def batch(
    wrist: Wrist,
    starts: Iterable[Start],
    angle: Number,
    references: Array,
    holds: Array,
    dead_time: Number | None = None,
    load: Number | None = None,
    load_at: Number = BEFORE,
) -> Batch:
    """Sequences as lanes: wrist with lanes or floats, a start for each lane, angles [deg] (lanes,),
    references [deg] and holds [s] (k, lanes); dead time [s] and load [deg], there from load_at [s] on, None
    where there is none."""
    given = list(starts)
    loaded = burdened(wrist, dead_time, load, load_at)
    angle = np.broadcast_to(np.asarray(angle, float), (len(given),))
    found: list[Any] = [np.empty(len(given)) for _ in tree.leaves(loaded.rest())]
    for start in dict.fromkeys(given):
        here = np.array([g == start for g in given])
        state = at_rest(wrist, start, np.where(here, angle, 0.0), dead_time, load, load_at)
        for into, leaf in zip(found, tree.leaves(state), strict=True):
            into[here] = np.broadcast_to(leaf, here.shape)[here]
    ends = np.round(np.cumsum(np.asarray(holds, float), axis=0) / wrist.rig.sample_time)
    switches = np.vstack([np.zeros_like(ends[:1]), ends[:-1]])
    judged = np.maximum(np.round(np.asarray(holds, float)[-1] / wrist.rig.sample_time), 1.0)
    return Batch(loaded, tree.like(loaded.rest(), found), np.asarray(references, float), switches, judged)


def stack(sequences: Iterable[Sequence]) -> Batch:
    """Sequences, of wrists with the same effects, as lanes.

    One that is shorter than others gets its first reference once more, held for no time.  Dead time
    and load are effects of all where one has them.
    """
    given = list(sequences)
    longest = max(len(s.references) for s in given)
    pad = [longest - len(s.references) for s in given]
    references = np.array([(s.references[0],) * n + s.references for s, n in zip(given, pad, strict=True)]).T
    holds = np.array([(0.0,) * n + s.holds for s, n in zip(given, pad, strict=True)]).T
    values = [s.wrist.values for s in given]
    wrist = given[0].wrist.made_of({n: np.array([v[n] for v in values], float) for n in values[0]})
    names = ("dead_time", "load", "load_at")
    dead_time, load, load_at = (np.array([getattr(s, n) for s in given], float) for n in names)
    return batch(
        wrist, [s.start for s in given], np.array([s.angle for s in given], float), references, holds,
        dead_time if dead_time.any() else None, load if load.any() else None, load_at,
    )  # fmt: skip


def repeated(b: Batch, n: int) -> Batch:
    """The lanes of a batch n times over, one copy after the other."""
    lanes = b.judged.size

    def again(x: Number) -> Number:
        return np.tile(np.broadcast_to(x, (lanes,)), n)

    wrist = b.wrist.made_of({k: again(v) for k, v in b.wrist.values.items()})
    state = tree.like(b.state, [again(x) for x in tree.leaves(b.state)])
    return Batch(
        wrist, state, np.tile(b.references, (1, n)), np.tile(b.switches, (1, n)), np.tile(b.judged, n)
    )


def play(
    sequences: Batch | Iterable[Sequence],
    controller: Controller | Periodic,
    record: bool = False,
    jobs: int | None = None,
    sensor: Sensor = PERFECT,
    noise: Array | None = None,
    task_band: bool = False,
) -> PlayedSequence:
    """Run sequences in the closed loop, all at once, one a lane; gains may be arrays of lanes.

    The controller holds the start.  The last step is judged by the true angle, from where it begins;
    task_band: it settles in the band of the task's step instead of its own.  sensor, noise: as
    `design.evaluation.runner.Lanes`.

    >>> from plants import Wrist
    >>> from design.controllers.pi import PI
    >>> one = Sequence("virgin", 0.0, (15.0,), (10.0,), Wrist.flexion())
    >>> two = Sequence("virgin", 0.0, (15.0, 0.0), (0.5, 10.0), Wrist.flexion())
    >>> played = play([one, two], PI(1.2, 2.2))
    >>> played.metrics.settling_time_s.round(2).tolist(), played.start.round(2).tolist()
    ([5.59, inf], [0.0, 1.71])
    """
    b = sequences if isinstance(sequences, Batch) else stack(sequences)
    step = b.wrist.rig.task.step
    judge = metrics.of_step_under_way(b.switches[-1], b.judged, b.wrist.rig, step if task_band else None)
    profile = ReferenceProfile(tuple(b.references), tuple(b.switches[1:]))
    samples = int(np.max(b.switches[-1] + b.judged))
    if isinstance(controller, Periodic):  # to the end of the last period, which is judged no further
        samples += -samples % int(controller.problem.substeps)
    duration = samples * b.wrist.rig.sample_time
    lasts = np.broadcast_to(b.switches[-1] + b.judged, (b.judged.size,)).astype(np.intp)
    done = runner.play(
        runner.Lanes(b.wrist, b.state, profile, judge, duration, sensor, noise, lasts=lasts), controller,
        record=record, jobs=jobs,
    )  # fmt: skip
    start = done.last.judge.step.start
    played = PlayedSequence(
        done.metrics, start, np.abs(b.references[-1] - start), step,
        trajectory=done.trajectory,
    )  # fmt: skip
    if done.trajectory is None:
        return played
    asked = profile.at(np.arange(len(done.trajectory.time))[:, None]).reference
    reference = np.broadcast_to(np.asarray(asked, float), done.trajectory.angle.shape)
    return replace(played, reference=reference)
