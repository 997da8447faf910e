"""The envelope: what the samples of a design do under the reference that a log has, and whether the log is
one of them.

A Monte Carlo test (Dwass, Modified randomization tests for nonparametric hypotheses, Annals of Mathematical
Statistics 28, 1957, doi 10.1214/aoms/1177707045): the score of a run is how far the oddest of its figures
lies from the samples' median, to its worse side, in units of their spread.  A rig that is one of the samples'
kind scores above all n of them with probability 1 / (n + 1), however many figures there are.

A real rig is none of them where its model is known to leave something: by how much that moves each figure, to
first order, is then the least spread, and three times that the least score that departs.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from design.evaluation.cases import as_lanes
from design.evaluation.runner import Lanes, play
from design.evaluation.scaled import SMALLEST
from design.robustness.requirement import Requirement
from design.robustness.samples.draws import CASES, NOISE, generator
from design.studies.check.stairs import BAND, FINEST, UNITS, Stair, figures
from plants.kernel import pytrees
from plants.measured.campaigns.begin import Begin, first_begin
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.stage import begun
from plants.simulation.sensor import HOLD, sensor
from plants.wrist import Start, State

Array = NDArray[np.float64]
AT_ONCE = 32
"""Samples run together: the signals of all are kept until they are thinned to the log's rows."""

SMALLER = ("overshoot", "rise time", "settling time", "IAE")
"""Figures of which less than was predicted breaks no promise."""

SIGMAS = 3.0
"""Times its own size by which what a model is known to leave may move a figure."""

MOVED: tuple[Start, ...] = ("line1", "line2", "inside")
"""Memories of a wrist that has moved before the log began."""


@dataclass(frozen=True)
class FigureCheck:
    """A figure of a stair: its value in the log, the samples' least, median and largest, how far the value
    lies from the median, to its worse side, in units of their spread, and whether no sample lies as far."""

    stair: int
    name: str
    unit: str
    value: float
    low: float
    middle: float
    high: float
    score: float
    departs: bool


@dataclass(frozen=True)
class SampledEnvelope:
    """Samples under a logged reference: least and largest reading [deg] at each row, (n,), figures in the
    order in which they are known, score of the log and the largest of the samples'."""

    low: Array
    high: Array
    figures: tuple[FigureCheck, ...]
    score: float
    largest: float
    samples: int

    @property
    def inside(self) -> bool:
        """Whether the log is within what the samples do."""
        return self.score <= self.largest

    @property
    def first(self) -> FigureCheck | None:
        """The figure that departs first, None where none does."""
        return next((f for f in self.figures if f.departs), None)


def envelope(
    playback: Playback, stairs: tuple[Stair, ...], required: Requirement, controller: object, samples: int,
    seed: int, noise: float, error: float = 0.0, jobs: int | None = None,
) -> SampledEnvelope:  # fmt: skip
    """Run samples of a requirement's plants, dead times and loads under a log's reference; noise [deg]: of
    the sensor; error [deg]: rms that the plant is known to leave of the angle, by which no figure is told."""
    log, step = playback.recording, required.wrist.rig.task.step
    angle, command = _played(playback, required, controller, samples, seed, noise, jobs)
    theirs = figures(stairs, log.time, angle, command, step)
    assert log.angle is not None
    own = figures(stairs, log.time, log.angle[:, None], log.command[:, None], step)
    hidden = _moved_by(error, stairs, log, theirs, step)
    scores = {
        key: _scores(np.append(theirs[key], own[key]), max(FINEST[key[1]], hidden[key]), key[1] in SMALLER)
        for key in own
    }
    of_all = np.max(list(scores.values()), axis=0)
    largest = max(float(of_all[:-1].max()), SIGMAS if error > 0.0 else 0.0)
    found = tuple(
        FigureCheck(
            i, name, UNITS[name], float(own[i, name][0]), float(theirs[i, name].min()),
            float(np.median(theirs[i, name])), float(theirs[i, name].max()), float(scores[i, name][-1]),
            bool(scores[i, name][-1] > largest),
        )
        for i, name in sorted(own, key=lambda k: (k[0], list(UNITS).index(k[1])))
    )  # fmt: skip
    return SampledEnvelope(
        angle.min(axis=1), angle.max(axis=1), found, float(of_all[-1]), largest, angle.shape[1]
    )


def _moved_by(
    error: float, stairs: tuple[Stair, ...], log: Recording, theirs: dict[tuple[int, str], Array], step: float
) -> dict[tuple[int, str], float]:
    """By how much an error of the model, rms [deg], moves each figure of each stair, to first order: the
    angle by as much while the loop has not settled, the command by what holds it, and times by what the angle
    takes for it, which comes to its reference as with one time constant, of which a rise takes ln 10."""
    assert log.angle is not None
    per_degree = float(np.ptp(log.command)) / max(float(np.ptp(log.angle)), SMALLEST * step)
    found: dict[tuple[int, str], float] = {}
    for i, s in enumerate(stairs):
        size = max(abs(s.reference - float(log.angle[max(s.first - 1, 0)])), SMALLEST * step)
        rise, settled = (float(np.median(theirs[i, n])) for n in ("rise time", "settling time"))
        lag = rise / np.log(10.0)
        found |= {
            (i, "overshoot"): 100.0 * error / size,
            (i, "rise time"): lag * error / (0.1 * size),
            (i, "settling time"): lag * error / (BAND * step),
            (i, "IAE"): error * max(rise, settled),
            (i, "error at the end"): error * min(max(rise, settled) / (s.ends - s.begins), 1.0),
            (i, "command at the end"): error * per_degree,
        }
    return found


def _scores(values: Array, finest: float, smaller: bool) -> Array:
    """How far each value lies from the median, in units of the spread on its side, or of what is told; of a
    figure that is the better the smaller it is, how far above."""
    low, middle, high = np.quantile(values, (0.05, 0.5, 0.95))
    off = np.maximum(values - middle, 0.0) if smaller else values - middle
    spread = np.where(off > 0.0, max(high - middle, finest), max(middle - low, finest))
    return np.asarray(np.abs(off) / spread, float)


def _played(
    playback: Playback, required: Requirement, controller: object, samples: int, seed: int, noise: float,
    jobs: int | None,
) -> tuple[Array, Array]:  # fmt: skip
    """Readings of the angle [deg] and commands [V] of samples at the log's rows, (rows, samples)."""
    log, space, wrist = playback.recording, required.space, required.wrist
    assert log.reference is not None
    assert log.angle is not None
    count = int(playback.rows[-1]) + 1
    asked = np.append(log.reference[_rows_of(playback)], log.reference[-1])
    started = first_begin(log, float(wrist.hysteresis.rest_pressure), wrist.rig)
    calm = started.virgin
    begin = 0.0 if calm else float(np.median(log.angle[:3]))
    found = []
    for piece in range(-(-samples // AT_ONCE)):
        lanes = min(AT_ONCE, samples - piece * AT_ONCE)
        u = generator(seed, piece, CASES).random((3 + len(space.box.intervals), AT_ONCE))[:, :lanes]
        starts: list[Start] = ["virgin" if calm else MOVED[int(len(MOVED) * share)] for share in u[0]]
        one = np.full((1, lanes), asked[0])
        run = as_lanes(
            space.box.at(u[3:]), starts, begin, one, np.full((1, lanes), count * playback.dt),
            space.dead_time * u[1] if space.dead_time > 0.0 else None,
            space.load * (2.0 * u[2] - 1.0) if space.load > 0.0 else None,
        )  # fmt: skip
        if calm and not started.at_zero:
            run = replace(run, state=_as_logged(run, started))
        shown = generator(seed, piece, NOISE).standard_normal((-(-count // HOLD) + 1, AT_ONCE))[:, :lanes]
        run = replace(run, sensor=sensor(noise), noise=shown, begin=float(log.time[0]), logged=asked)
        went = play(run, controller, record=True, jobs=jobs).trajectory  # type: ignore[arg-type]
        assert went is not None
        seen = noise * np.repeat(shown, HOLD, axis=0)[:count]
        found.append(((went.measured[:count] + seen)[playback.rows], went.command[playback.rows]))
    angle, command = (np.hstack(parts) for parts in zip(*found, strict=True))
    return angle, command


def _as_logged(run: Lanes, begin: Begin) -> State:
    """The state of each lane where a log begins on the initial curve, of a rig that rests elsewhere than at
    an angle of 0."""
    found = begun(run.wrist, begin)
    assert found is not None
    leaves = [np.broadcast_to(np.asarray(x, float), (run.count,)).copy() for x in pytrees.leaves(found)]
    state: State = pytrees.like(run.state, leaves)
    return state


def _rows_of(playback: Playback) -> NDArray[np.intp]:
    """The row whose reference holds at each sample, from as long ahead of the row as it is known to hold."""
    ahead = playback.recording.ahead
    begins = playback.rows - (0.0 if ahead is None else np.rint(ahead / playback.dt))
    return np.searchsorted(begins, np.arange(playback.rows[-1]), side="right") - 1
