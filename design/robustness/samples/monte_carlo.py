"""How often a tuned loop breaks its requirements: independent simulated cases, drawn from a box.

Shares of cases come with the exact 95 % interval of Clopper & Pearson (The use of confidence or
fiducial limits illustrated in the case of the binomial, Biometrika 26, 1934, doi
10.1093/biomet/26.4.404), which holds since the cases are independent.  Both are about the
distribution that was drawn from, uniform over the box, and no more is known than that.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.cluster import each
from design.controllers.controller import Controller
from design.evaluation.metrics import Metrics
from design.evaluation.runner import play, step_from
from design.robustness.box import Box
from design.robustness.samples.conditions import Conditions
from design.robustness.samples.draws import CHUNK, Draw, Flags, SamplingTask, draw, noise, remarks
from design.synthesis.requirements import LIMIT_UNITS, Limits
from plants.errors import InputError
from plants.kernel.batches import default_jobs
from plants.simulation.sensor import HOLD, sensor

Array = NDArray[np.float64]
QUANTILES = (0.05, 0.5, 0.95, 0.99)
LONGEST = 100.0
"""Duration [s] of a run; the noise of a chunk of longer ones would fill the memory."""


@dataclass(frozen=True)
class Violations:
    """How many of `trials` independent cases broke a requirement, in words, and the exact 95 % interval
    of the probability, from low to high."""

    requirement: str
    words: str
    limit: float | None
    unit: str
    count: int
    trials: int
    low: float
    high: float

    @property
    def probability(self) -> float:
        """Share of the cases, not a number where there were none."""
        return self.count / self.trials if self.trials else float("nan")


@dataclass(frozen=True)
class Samples:
    """Cases that were run, arrays of shape (n,) in the order of their numbers.

    metrics: of the true angle; drawn: values by name, those of the box by its intervals' names;
    start: index into `plants.wrist.STARTS`; reference, step [deg]: step is from where the wrist was;
    out_of_reach: cases whose reference no command can hold, which are in `metrics` but neither in
    `quantiles` (by metric, at `QUANTILES`) nor in `violations`; beyond: how many these are;
    remarks: conditions that were not drawn.
    """

    task: SamplingTask
    limits: Limits
    metrics: Metrics
    drawn: Mapping[str, Array]
    start: NDArray[np.intp]
    reference: Array
    step: Array
    out_of_reach: Flags
    quantiles: Mapping[str, tuple[float, ...]]
    violations: tuple[Violations, ...]
    beyond: Violations
    remarks: tuple[str, ...]

    def __len__(self) -> int:
        return int(self.reference.size)


def monte_carlo(
    box: Box,
    controller: Controller,
    conditions: Conditions | None = None,
    samples: int = 2000,
    seed: int = 0,
    limits: Limits | None = None,
    reference: float | None = None,
    duration: float | None = None,
    jobs: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Samples:
    """Run `samples` independent cases of a box under a controller, each a step of +-reference [deg], the
    rig's where not given.

    Case i depends on `seed` and i alone: the first cases of a longer run are those of a shorter one, and
    the results are the same to the bit for any number of threads `jobs` and for a Dask cluster at
    the address `scheduler`, whatever its workers.  duration [s] of each run, likewise.  Raises InputError for
    numbers that make no sense, and as `design.cluster.each` does.

    >>> from design.controllers.pi import PI
    >>> from plants.parameters.files import built_in
    >>> from design.robustness.box import box_of
    >>> found = monte_carlo(box_of(built_in("flexion")), PI(5.0, 9.0), samples=200)
    >>> len(found), [v.requirement for v in found.violations]
    (200, ['overshoot_percent', 'settles', 'steady_error_percent', 'total_variation_V'])
    """
    asked = box.plant.rig.task
    reference = asked.step if reference is None else float(reference)
    duration = asked.duration if duration is None else float(duration)
    task = SamplingTask(box, controller, conditions or Conditions(), seed, reference, duration)
    _refuse(task, samples)
    pieces = [(k, min(CHUNK, samples - k * CHUNK)) for k in range(-(-samples // CHUNK))]
    tell = progress or (lambda stage, share: None)
    parts = each(
        partial(run_chunk, task), pieces, scheduler, lambda share: tell("samples", share),
        jobs or default_jobs(),
    )  # fmt: skip
    return _gathered(task, limits or Limits.of(box.plant.rig), parts)


Part = tuple[list[Array], dict[str, Array], NDArray[np.intp], Array, Array, Flags]


def run_chunk(task: SamplingTask, piece: tuple[int, int]) -> Part:
    """Metrics and draws of the first cases of a chunk; `piece` is its number and how many, in one thread."""
    cases = draw(task, *piece)
    judged, _ = _rollouts(task, cases, piece)
    step = np.abs(cases.reference - cases.state.angle)
    metrics = [np.asarray(getattr(judged, f.name), float) for f in fields(Metrics)]
    return metrics, cases.values, cases.start, cases.reference, step, cases.out_of_reach


def _rollouts(
    task: SamplingTask, cases: Draw, piece: tuple[int, int], every: int = 0, record: tuple[str, ...] = ()
) -> tuple[Metrics, Array]:
    """Metrics of cases, and the signals named in `record` after every `every` samples."""
    seen_by = sensor(task.conditions.noise, task.conditions.quantum)
    lanes = step_from(cases.wrist, cases.state, cases.reference, task.duration)
    played = play(
        replace(lanes, sensor=seen_by, noise=noise(task, *piece)), task.controller, signals=record,
        every=every, jobs=1,
    )  # fmt: skip
    return played.metrics, played.rows


def _refuse(task: SamplingTask, samples: int) -> None:
    """Raises InputError for a task that cannot be run."""
    if samples < 1 or task.seed < 0:
        raise InputError(
            f"monte carlo: {samples} samples, seed {task.seed}; give at least 1, and a seed >= 0"
        )
    if not (task.reference > 0.0 and np.isfinite(task.reference) and 0.0 < task.duration <= LONGEST):
        raise InputError(
            f"monte carlo: the step must be positive, the duration above 0 and at most {LONGEST:g} s"
        )
    if task.conditions.load > 0.5 * task.reference:
        raise InputError(
            f"monte carlo: a load of {task.conditions.load:g} deg is more than half of the step of "
            f"{task.reference:g} deg; give a smaller load"
        )


def _gathered(task: SamplingTask, limits: Limits, parts: list[Part]) -> Samples:
    leaves, drawn, start, reference, step, out = zip(*parts, strict=True)
    metrics = Metrics(*(np.concatenate(x) for x in zip(*leaves, strict=True)))
    values = {n: np.concatenate([d[n] for d in drawn]) for n in drawn[0]}
    beyond, steps = np.concatenate(out), np.concatenate(step)
    kept = metrics[~beyond]
    return Samples(
        task, limits, metrics, values, np.concatenate(start), np.concatenate(reference), steps, beyond,
        {f.name: quantiles(getattr(kept, f.name)) for f in fields(Metrics)},
        tuple(_violations(kept, steps[~beyond], limits, task.duration, task.box.plant.rig.task.band)),
        counted("reach", "reference, or start, beyond what any command holds", None, "", beyond),
        remarks(task),
    )  # fmt: skip


def quantiles(values: Array) -> tuple[float, ...]:
    """Values at `QUANTILES`, each one of the samples, so that infinite ones stay apart from the others;
    not a number where there are no samples."""
    if values.size == 0:
        return (float("nan"),) * len(QUANTILES)
    return tuple(float(q) for q in np.quantile(values, QUANTILES, method="inverted_cdf"))


def _violations(m: Metrics, step: Array, limits: Limits, duration: float, band: float) -> list[Violations]:
    """Requirements that a simulated run can break: the limits in force, and that it settles at all."""
    error = 100.0 * m.steady_state_error_deg / step
    values = {
        "overshoot_percent": ("overshoot above {} of the step", m.overshoot_percent),
        "steady_error_percent": ("error at the end above {} of the step", error),
        "total_variation_V": ("total variation of the command above {}", m.total_variation_V),
    }
    found = {}
    for name, (words, value) in values.items():
        limit = limits.named.get(name)
        if limit is not None:
            unit = LIMIT_UNITS[name]
            # What is not a number has broken its limit too.
            found[name] = counted(name, words.format(f"{limit:g} {unit}"), limit, unit, ~(value <= limit))
    words = f"not settled within {100 * band:g} % of the step after {duration:g} s"
    found["settles"] = counted("settles", words, None, "", ~np.isfinite(m.settling_time_s))
    order = ("overshoot_percent", "settles", "steady_error_percent", "total_variation_V")
    return [found[n] for n in order if n in found]


def counted(requirement: str, words: str, limit: float | None, unit: str, broken: Flags) -> Violations:
    """Number of cases that broke a requirement, with the exact interval of its probability."""
    count, trials = int(np.count_nonzero(broken)), int(np.size(broken))
    return Violations(requirement, words, limit, unit, count, trials, *interval(count, trials))


def interval(count: int, trials: int, confidence: float = 0.95) -> tuple[float, float]:
    """Clopper and Pearson's interval of a probability of which `count` of `trials` were seen; (0, 1)
    where there were no trials.

    >>> [round(x, 4) for x in interval(4, 20)]
    [0.0573, 0.4366]
    """
    from scipy.special import betaincinv  # scipy.stats.binomtest finds the same, but takes far longer

    tail = 0.5 * (1.0 - confidence)
    low = betaincinv(count, trials - count + 1, tail) if count > 0 else 0.0
    high = betaincinv(count + 1, trials - count, 1.0 - tail) if count < trials else 1.0
    return float(low), float(high)


@dataclass(frozen=True)
class Envelopes:
    """Bands of the true angle over time, shape (rows,): time [s] and 5, 50 and 95 % [deg], counted in the
    direction of each case's step; of so many cases."""

    time: Array
    low: Array
    middle: Array
    high: Array
    cases: int


def envelopes(samples: Samples, count: int = 200) -> Envelopes | None:
    """Bands of the first `count` cases within reach among the first chunk, run again with recording, a
    row every 10 ms; None where none is within reach."""
    piece = (0, min(CHUNK, len(samples)))
    kept = np.flatnonzero(~samples.out_of_reach[: piece[1]])[:count]
    if kept.size == 0:
        return None
    piece = (0, int(kept[-1]) + 1)
    cases = draw(samples.task, *piece)
    _, rows = _rollouts(samples.task, cases, piece, HOLD, ("plant.angle",))
    angle = (rows[0] * np.sign(cases.reference))[:, kept]
    low, middle, high = np.quantile(angle, (0.05, 0.5, 0.95), axis=1)
    time = np.asarray(np.arange(len(angle)) * (HOLD * samples.task.box.plant.rig.sample_time), float)
    return Envelopes(time, low, middle, high, int(kept.size))


def samples_record(samples: Samples) -> dict[str, Any]:
    """What was sampled and the quantiles of each metric, for JSON; what is not finite becomes null."""
    table = {
        name: {f"{q:g}": x if np.isfinite(x) else None for q, x in zip(QUANTILES, row, strict=True)}
        for name, row in samples.quantiles.items()
    }
    return {
        "samples": len(samples), "seed": samples.task.seed, "out_of_reach": samples.beyond.count,
        "conditions": samples.task.conditions.by_name, "left_out": list(samples.remarks), "quantiles": table,
    }  # fmt: skip
