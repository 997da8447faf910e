"""Tuning against the worst case: tune, search for the worst case of the gains, add it, tune again.

The loop that systune runs over uncertain parameters (Apkarian, Dao and Noll, Parametric robust
structured control design, 2014, arXiv:1405.4202), here with memory, references, dead time and
load beside the parameters.  It ends where no worse case is found, which is no proof that there is none.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from design.evaluation.sequence import Sequence
from design.robustness.box import Box
from design.robustness.samples.adversary import worst_case
from design.robustness.samples.worst import Worst
from design.synthesis.answer import Refusal, refusal
from design.synthesis.requirements import COSTS, Problem, controller, evaluate, rollouts
from design.synthesis.tuning import Region, Tuning
from design.synthesis.tuning import tune as plain_tune

WORSE = 0.10
"""A worst case that breaks no limit is added where its cost is above the worst of the set by this share."""

SLACK = 0.02
"""An excess of this share of a limit is not chased any further: gains lie on their limit, and the next
search finds a case that is worse by a hair."""

Ended = Literal["no worse case found", "rounds used up", "no gains hold the grown set"]


@dataclass(frozen=True)
class Round:
    """One round: the tuning on the set so far, the worst cases that were found of its gains (in excess
    over the limits, then in cost), and the scenarios that were added to the set."""

    tuning: Tuning
    cases: tuple[Worst, ...]
    added: tuple[Sequence, ...]

    @property
    def worst(self) -> Worst:
        """The worst case: that of the largest excess, or of the highest cost where no limit is broken."""
        return self.cases[0]


@dataclass(frozen=True)
class Price:
    """What gains do on the plain tuning set: cost of the nominal step from rest and of the worst
    scenario, in the problem's cost; settling time [s] and overshoot [%] of that nominal step."""

    nominal_cost: float
    worst_cost: float
    settling_time_s: float
    overshoot_percent: float


@dataclass(frozen=True)
class RobustTuning:
    """What was found: the rounds, why it ended, and what it costs: the first gains and the last ones
    on the plain tuning set."""

    rounds: tuple[Round, ...]
    ended: Ended
    before: Price
    after: Price

    @property
    def final(self) -> Tuning:
        """The last tuning, on the set grown so far; its gains are the result."""
        return self.rounds[-1].tuning

    @property
    def refusal(self) -> Refusal | None:
        """Why no gains hold the limits on the grown set, or None where they do."""
        return refusal(self.final)

    @property
    def holds(self) -> bool:
        """Whether the gains hold the grown set and no worse case was found."""
        return self.ended == "no worse case found" and self.refusal is None


def tune_robustly(
    problem: Problem,
    box: Box,
    region: Region | None = None,
    starts: int = 5,
    seed: int = 0,
    dead_time: float = 0.0,
    load: float = 0.0,
    rounds: int = 15,
    progress: Callable[[str, float], None] | None = None,
    tune: Callable[..., Tuning] = plain_tune,
    budget: int = 20_000,
) -> RobustTuning:
    """Gains of least worst cost on a set that grows by the worst case of each round's gains.

    A round tunes on the problem's scenarios and the worst cases found before, and searches `box`, dead
    time [s] and load [deg] (see `adversary.worst_case`) for the largest excess and for the highest cost,
    with `budget` runs each.  What breaks a limit by more than `SLACK` of it, or costs more by `WORSE` than
    the worst of the set, is added, with its runners-up that break a limit.  Ends where nothing is, after
    `rounds`, or where no gains in the region hold the grown set: then the last tuning is the nearest.
    `tune` stands in for `design.synthesis.tuning.tune`, with its arguments.
    """
    tell = progress or (lambda stage, share: None)
    grown, done = problem, list[Round]()
    ended: Ended = "rounds used up"
    for number in range(1, max(rounds, 1) + 1):

        def said(stage: str, share: float, at: int = number) -> None:
            tell(f"round {at}: {stage}", share)

        found = tune(grown, region, starts, seed, said)
        cases = search(found, box, dead_time, load, seed + number, budget, said)
        worse = [s for c in cases if is_worse(c, found) for s in (c.sequence, *c.others)]
        if refusal(found) is not None:
            ended = "no gains hold the grown set"
        elif not worse:
            ended = "no worse case found"
        added = tuple(worse) if ended == "rounds used up" and number < rounds else ()
        done.append(Round(found, cases, added))
        if not added:
            break
        grown = replace(grown, adverse=(*grown.adverse, *added))
    first, last = done[0].tuning, done[-1].tuning
    return RobustTuning(tuple(done), ended, price(problem, first), price(problem, last))


def search(
    found: Tuning,
    box: Box,
    dead_time: float,
    load: float,
    seed: int,
    budget: int,
    progress: Callable[[str, float], None] | None = None,
) -> tuple[Worst, ...]:
    """The worst cases of a tuning's gains: of the largest excess where a limit is broken, and of the
    highest cost; dead_time [s] and load [deg] bound what they may have on top."""
    problem = found.problem
    look = partial(
        worst_case, box, controller(problem, found.Kp, found.Ki), limits=problem.limits, dead_time=dead_time,
        load=load, seed=seed, jobs=problem.jobs, progress=progress, budget=budget, duration=problem.duration,
    )  # fmt: skip
    first = look(objective="excess")
    return (first,) if first.objective == "cost" else (first, look(objective="cost"))


def is_worse(worst: Worst, found: Tuning) -> bool:
    """Whether a worst case breaks a limit, or costs much more than the worst of the set tuned on."""
    cost = worst.values[COSTS[found.problem.cost]]
    return worst.excess > SLACK or cost > (1.0 + WORSE) * float(found.at.cost[0])


def price(problem: Problem, found: Tuning) -> Price:
    """What a tuning's gains do on the plain set."""
    plain = replace(problem, adverse=())
    Kp, Ki = np.array([found.Kp]), np.array([found.Ki])
    judged = rollouts(plain, Kp, Ki)
    names = [(s.plant, s.start) for s in plain.scenarios]
    step = names.index(("nominal", "virgin")) if ("nominal", "virgin") in names else 0
    return Price(
        float(getattr(judged, COSTS[plain.cost])[0, step]),
        float(evaluate(plain, Kp, Ki).cost[0]),
        float(judged.settling_time_s[0, step]),
        float(judged.overshoot_percent[0, step]),
    )
