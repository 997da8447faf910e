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
from plants.simulation.disturbance import at_rest, burdened
from plants.simulation.periodic import Periodic
from plants.simulation.reference_profile import ReferenceProfile
from plants.wrist import Start, State, Wrist

Number = Any
Array = NDArray[np.float64]

SMALLEST = 1.0 / 3.0
"""What is judged relative to a step is so to one of at least this share of the task's: a reference that is
changed just as the wrist passes it would make any overshoot a large share of a tiny step."""


@dataclass(frozen=True)
class Sequence:
    """A wrist at rest at an angle [deg], having come there by `start`, and what it is asked then.

    references [deg], each held for so many seconds of `holds`, of which the last is the time for
    which the last step is judged; dead_time [s]: beside the wrist's own; load [deg]: constant shift
    of the static angle, there from before the run; plant: in words which wrist it is.  With a load
    the virgin wrist starts where the load puts it.  Raises ValueError for references without times.
    """

    start: Start
    angle: float
    references: tuple[float, ...]
    holds: tuple[float, ...]
    wrist: Wrist
    dead_time: float = 0.0
    load: float = 0.0
    plant: str = "nominal"

    def __post_init__(self) -> None:
        if not self.references or len(self.references) != len(self.holds):
            raise ValueError("a sequence needs references, and as many times to hold them")

    @property
    def name(self) -> str:
        """In words, such as ``0, +15 (0.8 s), -10 deg from line2, nominal plant, 40 ms of dead time``."""
        steps = [f"{self.angle:+.3g}".replace("+0", "0")]
        steps += [f"{r:+.3g} ({h:.3g} s)" for r, h in zip(self.references, self.holds, strict=True)]
        steps[-1] = f"{self.references[-1]:+.3g} deg"
        more = f", {1000 * self.dead_time:.3g} ms of dead time" if self.dead_time else ""
        more += f", load {self.load:+.3g} deg" if self.load else ""
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
        others are put on its footing: overshoot and steady error in percent of the step, of one of
        `SMALLEST` at least; total variation of the command of a larger step as if scaled down to it (a
        smaller one must travel for the play of the loop all the same, and is not scaled up); IAE and
        ITAE per degree of a step of `SMALLEST` at least, times that step.
        """
        smallest = SMALLEST * self.step
        m, size = self.metrics, np.maximum(self.size, smallest)
        return {
            "overshoot_percent": np.nan_to_num(m.overshoot_percent * np.minimum(self.size / smallest, 1.0)),
            "steady_error_percent": 100.0 * m.steady_state_error_deg / size,
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
) -> Batch:
    """Sequences as lanes: wrist with lanes or floats, a start for each lane, angles [deg] (lanes,),
    references [deg] and holds [s] (k, lanes); dead time [s] and load [deg] None where there is none."""
    given = list(starts)
    loaded = burdened(wrist, dead_time, load)
    angle = np.broadcast_to(np.asarray(angle, float), (len(given),))
    found: list[Any] = [np.empty(len(given)) for _ in tree.leaves(loaded.rest())]
    for start in dict.fromkeys(given):
        here = np.array([g == start for g in given])
        state = at_rest(wrist, start, np.where(here, angle, 0.0), dead_time, load)
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
    dead_time, load = (np.array([getattr(s, n) for s in given], float) for n in ("dead_time", "load"))
    return batch(
        wrist, [s.start for s in given], np.array([s.angle for s in given], float), references, holds,
        dead_time if dead_time.any() else None, load if load.any() else None,
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
) -> PlayedSequence:
    """Run sequences in the closed loop, all at once, one a lane; gains may be arrays of lanes.

    The controller holds the start.  The last step is judged by the true angle, from where it begins.

    >>> from plants import Wrist
    >>> from design.controllers.pi import PI
    >>> one = Sequence("virgin", 0.0, (15.0,), (10.0,), Wrist.flexion())
    >>> two = Sequence("virgin", 0.0, (15.0, 0.0), (0.5, 10.0), Wrist.flexion())
    >>> played = play([one, two], PI(1.2, 2.2))
    >>> played.metrics.settling_time_s.round(2).tolist(), played.start.round(2).tolist()
    ([5.59, inf], [0.0, 1.71])
    """
    b = sequences if isinstance(sequences, Batch) else stack(sequences)
    judge = metrics.of_step_under_way(b.switches[-1], b.judged, b.wrist.rig.sample_time)
    profile = ReferenceProfile(tuple(b.references), tuple(b.switches[1:]))
    samples = int(np.max(b.switches[-1] + b.judged))
    if isinstance(controller, Periodic):  # to the end of the last period, which is judged no further
        samples += -samples % int(controller.problem.substeps)
    duration = samples * b.wrist.rig.sample_time
    done = runner.play(
        runner.Lanes(b.wrist, b.state, profile, judge, duration), controller, record=record, jobs=jobs
    )
    start = done.last.judge.step.start
    played = PlayedSequence(
        done.metrics, start, np.abs(b.references[-1] - start), b.wrist.rig.task.step,
        trajectory=done.trajectory,
    )  # fmt: skip
    if done.trajectory is None:
        return played
    asked = profile.at(np.arange(len(done.trajectory.time))[:, None]).reference
    reference = np.broadcast_to(np.asarray(asked, float), done.trajectory.angle.shape)
    return replace(played, reference=reference)
