"""Tuning under the whole requirement: tune, look for worse cases, add them, tune again, until none is found.

The loop that systune runs over uncertain parameters (Apkarian, Dao and Noll, Parametric robust structured
control design, 2014, arXiv:1405.4202), here with memory, references, dead time and loads beside the
parameters. Cases come from a pool that is the same for every seed, then from a search for the worst
(`samples.hunt`), then from fresh samples.  It ends where neither finds a case that breaks a limit, which is
no proof that there is none.

The overshoot jumps where a branch is reached or just not: gains that lie on their limit break it by another
integrator, another seed, or noise.  So gains are tuned below the limits by a `GUARD`, or by a `THIN` one
where that leaves none, and judged by the limits.  Gains are rounded before anything judges them
(`gain_search`).

The sensor's noise, which samples have, joins the cases of the tuning only where it breaks a limit that gains
hold without it: runs without it are faster, and tell more of a difference between gains.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Generic, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from design.evaluation.cases import Case
from design.margins import margins
from design.robustness.checks import Check, check, worst_cases, worst_of
from design.robustness.requirement import Requirement
from design.robustness.samples.hunt import Hunted
from design.robustness.tuning.case_pool import POOL, harshest, pool_of
from design.robustness.tuning.gain_search import solved, with_evidence
from design.robustness.tuning.nearest_gains import nearest
from design.robustness.tuning.tuned_controller import TunedController
from design.robustness.tuning.worse_branches import on_all_branches
from design.synthesis.answer import out_of_reach
from design.synthesis.evaluate import evaluate
from design.synthesis.requirements import COSTS, Problem
from design.synthesis.structure import PLAIN_PI, Structure
from design.synthesis.tuning import Region, Tuning
from plants.simulation.sensor import PERFECT

Array = NDArray[np.float64]
Tell = Callable[[str, float], None]

GUARD: Mapping[str, float] = {
    "overshoot_percent": 0.10, "steady_error_percent": 0.10, "total_variation_V": 0.10, "Ms": 0.003,
    "Mt": 0.003,
}  # fmt: skip
"""Shares of the limits that gains are tuned below them by.  For the overshoot half a percentage point of
five: it jumps, noise of the sensor moves it, and no set of cases holds the very worst; for the margins what
the grid of frequencies leaves."""

THIN: Mapping[str, float] = {n: 0.25 * share for n, share in GUARD.items()}
"""The guard of a second try, where no gains in the region meet the limits with the first, and the nearest
miss them by no more than that guard holds back: some plants hold the limits, and not a tenth less.  Who shows
such gains says so."""

SLACK = 0.85
"""A case that leaves this share of the guard unused is not chased any further; the less is let go, the less
gains hang on the seed of the search."""

DEARER = 0.02
"""A case of the task is added where it costs more than the worst of the set by this share."""


@dataclass(frozen=True)
class RoundEffort:
    """Cases of the pool, runs of a round's search for the worst case, none where 0, and fresh samples that
    must find nothing."""

    pool: int = POOL
    search: int = 12_000
    fresh: int = 2000


USUAL = RoundEffort()
"""Where a run takes microseconds."""


Ended = Literal[
    "no worse case found", "rounds used up", "no gains hold the grown set", "out of reach",
    "noise breaks a limit",
]  # fmt: skip


T = TypeVar("T", bound=TunedController)


@dataclass(frozen=True)
class Round(Generic[T]):
    """One round: the tuning on the set so far, the largest excess over the limits, guard not counted, that
    was found of its gains, by whom, in how many runs, and the cases that were added to the set."""

    tuning: T
    excess: float
    by: Literal["pool", "search", "samples"]
    runs: int
    added: tuple[Case, ...]


@dataclass(frozen=True)
class RobustTuning(Generic[T]):
    """What was found: the rounds, why it ended, the fresh samples of the last gains (None where no gains were
    found)."""

    requirement: Requirement
    rounds: tuple[Round[T], ...]
    ended: Ended
    fresh: Check | None

    @property
    def final(self) -> T:
        """The last tuning, on the set grown so far; its gains are the result."""
        return self.rounds[-1].tuning

    @property
    def guard(self) -> dict[str, float]:
        """Shares of the limits that the last gains were tuned below them by."""
        return dict(self.final.problem.guard)

    @property
    def holds(self) -> bool:
        """Whether the gains hold the grown set and no worse case was found."""
        return self.ended == "no worse case found" and self.final.feasible


def tune_robustly(
    requirement: Requirement,
    region: Region | None = None,
    starts: int = 5,
    seed: int = 0,
    rounds: int = 15,
    jobs: int | None = None,
    progress: Tell | None = None,
    structure: Structure = PLAIN_PI,
    base: Tuning | None = None,
    cases: tuple[Case, ...] = (),
) -> RobustTuning[Tuning]:
    """Gains of least worst cost that hold a requirement, as far as pool, search and fresh samples can tell.

    region: that of the plant where not given; structure: of the controller; base: a tuning, such as of the
    PI, whose gains and cases to begin with; cases: to begin with besides;
    starts: local searches of the last set, which show whether other valleys are as low, beside a map of the
    region; neither where 0; seed: of searches and samples.  Ends where no worse case is found, after
    `rounds`, where samples break a limit of the same gains over and over, or where no gains in the region
    hold the grown set: then the last tuning is the nearest.
    """
    tell, region = progress or (lambda stage, share: None), region or Region.of(requirement.wrist)
    problem = requirement.problem(dict(GUARD), jobs)
    problem = replace(problem, adverse=(*(() if base is None else base.problem.adverse), *cases))
    if out_of_reach(problem) is not None:
        at = evaluate(replace(problem, screened=False), region.grid[0][:1], region.grid[1][:1])
        nothing = Tuning(problem, region, at, at, ())
        return RobustTuning(requirement, (Round(nothing, 0.0, "pool", 0, ()),), "out of reach", None)
    first = None if base is None else base.at

    def on_few(problem: Problem, known: Tuning | None) -> Tuning:
        at = solved(problem, region, first if known is None else known.at, structure)
        return Tuning(problem, region, at, at, ())

    def design(problem: Problem, known: Tuning | None) -> Tuning:
        return on_all_branches(
            requirement, on_few, lambda c, of: margins(of, getattr(c, "pi", c)), problem, known
        )

    grown = grow(requirement, problem, design, seed, rounds, jobs, tell)
    tell("map", 0.9)
    if not grown.final.feasible and structure is PLAIN_PI:
        last = grown.rounds[-1]
        grown = replace(grown, rounds=(*grown.rounds[:-1], replace(last, tuning=nearest(last.tuning))))
    if starts > 0:
        last = grown.rounds[-1]
        shown = replace(last, tuning=with_evidence(last.tuning, starts))
        grown = replace(grown, rounds=(*grown.rounds[:-1], shown))
    tell("done", 1.0)
    return grown


def grow(
    requirement: Requirement,
    problem: Problem,
    design: Callable[[Problem, T | None], T],
    seed: int = 0,
    rounds: int = 15,
    jobs: int | None = None,
    progress: Tell | None = None,
    effort: RoundEffort = USUAL,
) -> RobustTuning[T]:
    """Design on a problem, look for worse cases of the requirement, add them, design again, until none is
    found, for any kind of controller; where gains just miss the grown set, once more with a thin guard.

    design: the gains of least cost on a problem, from those of the round before; the problem of its result is
    what cases are added to.
    """
    tell = progress or (lambda stage, share: None)
    pool = pool_of(requirement, effort.pool)
    whole = pool.shape[1]
    done: list[Round[T]] = []
    found: T | None = None
    fresh: Check | None = None
    ended: Ended = "rounds used up"
    for number in range(max(rounds, 1)):
        share = 1.0 - 0.8**number
        tell(f"round {number + 1}: gains", share)
        found = design(problem, found)
        if not found.feasible:
            done.append(Round(found, 0.0, "pool", 0, ()))
            if found.problem.guard == GUARD and found.at.worst_excess[0] <= max(GUARD.values()):
                problem = replace(found.problem, guard=dict(THIN))
                continue
            ended = "no gains hold the grown set"
            break

        def said(stage: str, at: int = number, share: float = share) -> None:
            tell(f"round {at + 1}: {stage}", share)

        said("pool")
        values = requirement.run(pool, found.controller, jobs=jobs)
        worse, fresh = _worse(requirement, found, (pool, values), effort, seed + number, jobs, said)
        done.append(worse)
        if pool.shape[1] == whole:  # what is mild under the boldest gains is milder under any later
            pool = pool[:, harshest(requirement, pool, values, effort.pool)]
        if not worse.added:
            ended = "no worse case found"
            break
        problem = replace(found.problem, adverse=(*found.problem.adverse, *worse.added))
        if _noise_alone(done):
            if problem.sensor != PERFECT:
                ended = "noise breaks a limit"
                break
            problem = replace(problem, sensor=requirement.sensor)
    return RobustTuning(requirement, tuple(done), ended, fresh)


def _noise_alone(done: list[Round[T]]) -> bool:
    """Whether samples broke a limit of the same gains twice: the cases that were added after the first time
    hold without the noise that samples have, so that no further round will tell more."""
    last = done[-2:]
    return (
        len(last) == 2
        and all(r.by == "samples" for r in last)
        and last[0].tuning.gains == last[1].tuning.gains
    )


def _worse(
    requirement: Requirement,
    found: T,
    at_places: tuple[Array, dict[str, Array]],
    effort: RoundEffort,
    seed: int,
    jobs: int | None,
    tell: Callable[[str], None],
) -> tuple[Round[T], Check | None]:
    """What breaks a limit of gains, its guard half counted, or costs more than the set: of the pool, whose
    places and values are given, else of a search, else of fresh samples; the round, and the samples where
    they were asked."""
    (pool, values), controller = at_places, found.controller
    half = {n: SLACK * v for n, v in found.problem.guard.items()}
    at_pool = Hunted(pool, requirement.excess(values, half))
    added = worst_cases(requirement, at_pool, 0.0)
    cost = np.where(requirement.space.of_task(pool), values[COSTS[requirement.cost]], 0.0)
    dear = Hunted(pool, cost / float(found.at.cost[0]) - 1.0 - DEARER)
    added += worst_cases(requirement, dear, 0.0, 2)
    worst = float(requirement.excess(values).max())
    if added:
        return Round(found, worst, "pool", pool.shape[1], added), None
    if effort.search > 0:
        tell("search for the worst case")
        of = requirement.space.kind(pool)
        begin = np.hstack([
            pool[:, of == k][:, Hunted(pool[:, of == k], at_pool.heights[of == k]).worst(4)] for k in
            np.unique(of)
        ])  # fmt: skip
        hunted = worst_of(requirement, controller, effort.search, seed, begin, jobs, guard=half)
        added = worst_cases(requirement, hunted, 0.0)
        found_worst = requirement.run(hunted.places[:, hunted.worst(1)], controller, jobs=jobs)
        worst = max(worst, float(requirement.excess(found_worst).max()))
        if added:
            return Round(found, worst, "search", hunted.heights.size, added), None
    tell("fresh samples")
    fresh = check(requirement, controller, effort.fresh, seed, jobs)
    beyond, worst = Hunted(fresh.places, fresh.excess), max(worst, float(fresh.excess.max(initial=-1.0)))
    return Round(found, worst, "samples", effort.fresh, worst_cases(requirement, beyond, 0.0)), fresh
