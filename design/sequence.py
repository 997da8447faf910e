"""A closed-loop run over a sequence of references, of which the last step is judged.

A step that comes before the one before it has settled meets a wrist that still moves and an
integrator that is still on its way: a state that no start from rest has.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from design import metrics
from design.burden import at_rest, burdened
from design.controllers import pi
from design.controllers.pi import PI, PIState, SampledPI
from design.loop import Trajectory, holding
from design.metrics import Metrics, Tally, Yardstick
from design.tasks import STEP
from plants import tree
from plants import wrist as plant
from plants.effects.effect import Around
from plants.simulate import run_lanes
from plants.wrist import SAMPLE_TIME, SampledWrist, Start, State, Wrist

Number = Any
Array = NDArray[np.float64]

SMALLEST = 5.0
"""What is judged relative to the step is so to one of at least this size [deg]: a reference that is
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
class Played:
    """What became of sequences: metrics of the last step, leaves (lanes,); start [deg] (lanes,), the
    true angle where that began; reference [deg] (samples, lanes) and trajectory where recorded."""

    metrics: Metrics
    start: Array
    size: Array
    reference: Array | None = None
    trajectory: Trajectory | None = None

    @property
    def values(self) -> dict[str, Array]:
        """What limits and cost are held against, by name, each (lanes,).

        A step of 15 deg (`design.tasks.STEP`) is what the limits and the tuning set are made for, so
        others are put on its footing: overshoot and steady error in percent of the step, of one of
        `SMALLEST` at least; travel of the command of a larger step as if scaled down to 15 deg (a
        smaller one must travel for the play of the loop all the same, and is not scaled up); IAE and
        ITAE per degree of a step of `SMALLEST` at least, times 15 deg.
        """
        m, size = self.metrics, np.maximum(self.size, SMALLEST)
        return {
            "overshoot_percent": np.nan_to_num(m.overshoot_percent * np.minimum(self.size / SMALLEST, 1.0)),
            "steady_error_percent": 100.0 * m.steady_state_error_deg / size,
            "total_variation_V": m.total_variation_V * np.minimum(STEP / size, 1.0),
            "iae_deg_s": m.iae_deg_s * STEP / size,
            "itae_deg_s2": m.itae_deg_s2 * STEP / size,
            "settling_time_s": m.settling_time_s,
        }


class Course(NamedTuple):
    """What a lane is asked: references [deg], samples at which each begins, samples for which the last
    is judged, sample time [s]."""

    references: tuple[Number, ...]
    switches: tuple[Number, ...]
    judged: Number
    dt: Number


class Run(NamedTuple):
    """State of plant, controller and judge; start [deg] and 1 / step of the step that is judged."""

    plant: State
    controller: PIState
    tally: Tally
    start: Number
    per_step: Number


class SampledRun(NamedTuple):
    """Coefficients of plant and controller, and the course."""

    plant: SampledWrist
    controller: SampledPI
    course: Course


def step(s: Run, inputs: tuple[Number, ...], c: SampledRun) -> Run:
    """One sample, as `design.loop.step`, with the reference of the lane's own course; the judge begins
    anew where the last reference does.  `inputs`: index of the sample, and its time [s] where needed."""
    around, course = Around(*inputs[1:]), c.course
    reference = course.references[0]
    for later, switch in zip(course.references[1:], course.switches[1:], strict=True):
        reference = np.where(inputs[0] >= switch, later, reference)
    seen = plant.read(s.plant, c.plant, around)
    controller, command = pi.step(s.controller, reference - seen, c.controller)

    last, sample, angle = course.references[-1], inputs[0] - course.switches[-1], s.plant.angle
    begins, over = sample == 0.0, sample >= course.judged
    start = np.where(begins, angle, s.start)
    per_step = np.where(begins, 1.0 / (last - angle), s.per_step)
    before = _select(begins, metrics.begin(s.tally.command), s.tally)
    tally = metrics.update(before, sample, angle, command, Yardstick(last, start, per_step, course.dt))
    # Lanes end at samples of their own: from there on the sums stand still.
    tally = _select(over, before, tally)._replace(command=command)
    return Run(plant.step(s.plant, command, c.plant, around), controller, tally, start, per_step)


def _select(condition: Number, yes: Tally, no: Tally) -> Tally:
    return Tally(*(np.where(condition, a, b) for a, b in zip(yes, no, strict=True)))


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
    ends = np.round(np.cumsum(np.asarray(holds, float), axis=0) / SAMPLE_TIME)
    switches = np.vstack([np.zeros_like(ends[:1]), ends[:-1]])
    judged = np.maximum(np.round(np.asarray(holds, float)[-1] / SAMPLE_TIME), 1.0)
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
    wrist = Wrist.from_values(
        {n: np.array([v[n] for v in values], float) for n in values[0]}, given[0].wrist.forms
    )
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

    wrist = Wrist.from_values({k: again(v) for k, v in b.wrist.values.items()}, b.wrist.forms)
    state = tree.like(b.state, [again(x) for x in tree.leaves(b.state)])
    return Batch(
        wrist, state, np.tile(b.references, (1, n)), np.tile(b.switches, (1, n)), np.tile(b.judged, n)
    )


def play(
    sequences: Batch | Iterable[Sequence], controller: PI, record: bool = False, jobs: int | None = None
) -> Played:
    """Run sequences in the closed loop, all at once, one a lane; gains may be arrays of lanes.

    The controller holds the start.  The last step is judged by the true angle, from where it begins.

    >>> from plants import Wrist
    >>> one = Sequence("virgin", 0.0, (15.0,), (10.0,), Wrist.flexion())
    >>> two = Sequence("virgin", 0.0, (15.0, 0.0), (0.5, 10.0), Wrist.flexion())
    >>> played = play([one, two], PI(1.2, 2.2))
    >>> played.metrics.settling_time_s.round(2).tolist(), played.start.round(2).tolist()
    ([5.59, inf], [0.0, 1.71])
    """
    b = sequences if isinstance(sequences, Batch) else stack(sequences)
    held = holding(b.wrist, controller, b.state)
    command = (controller.rest_pressure + held.integral) / controller.gain
    course = Course(tuple(b.references), tuple(b.switches), b.judged, SAMPLE_TIME)
    first = Run(b.state, held, metrics.begin(command), b.state.angle, 0.0)
    c = SampledRun(b.wrist.sampled(), controller.sampled(), course)
    samples = int(np.max(b.switches[-1] + b.judged))
    signals = tuple(n for n in tree.names(first) if n.startswith("plant.")) + ("tally.command",)
    times = {"time": np.arange(samples) * SAMPLE_TIME} if b.wrist.effects else {}
    last, rows = run_lanes(
        step, first, c, samples, times, inputs=("sample", *times), every=int(record),
        record=signals if record else (), jobs=jobs,
    )  # fmt: skip
    lengths: Any = b.judged  # finish takes one for each lane as well
    played = Played(metrics.finish(last.tally, lengths), last.start, np.abs(b.references[-1] - last.start))
    if not record:
        return played
    # The command of a row is given after its measurement: it stands in the row after.
    given = np.concatenate([rows[-1, 1:], rows[-1, -1:]])
    time = np.asarray(np.arange(rows.shape[1]) * SAMPLE_TIME, float)
    went = tree.like(b.state, rows[:-1])
    seen = plant.read(went, c.plant, Around(time[:, None]))
    reference = np.broadcast_to(b.references[0], given.shape)
    for later, switch in zip(b.references[1:], b.switches[1:], strict=True):
        reference = np.where(np.arange(len(time))[:, None] >= switch, later, reference)
    trajectory = Trajectory(time, went.angle, went.memory.h, went.pressure, given, seen)
    return replace(played, reference=reference, trajectory=trajectory)
