"""Checks of a controller under a requirement: fresh samples, and a search for the worst case.

Both judge what tuning judges, by the limits alone, no guard counted.  Samples see the sensor's noise and
resolution, and are independent: shares of them come with the exact interval of Clopper and Pearson.  A search
that finds nothing is no proof that there is nothing.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from design.evaluation.cases import Case
from design.robustness.requirement import Requirement
from design.robustness.samples.draws import CASES, CHUNK, generator
from design.robustness.samples.hunt import Hunted, hunt
from design.robustness.samples.monte_carlo import Violations, counted, interval
from design.robustness.samples.worst import excesses
from design.synthesis.requirements import COSTS

BATCH = 8
"""How many of the worst cases that are found at once are added to a set."""

Array = NDArray[np.float64]
Tell = Callable[[str, float], None]


@dataclass(frozen=True)
class Check:
    """Fresh samples: places that could be held (size, n), values by name and largest excess (n,) of each; how
    many were out of reach; the largest cost of a step of the task, and its slowest settling [s]."""

    places: Array
    values: dict[str, Array]
    excess: Array
    out_of_reach: int
    worst_cost: float
    worst_settling_s: float

    @property
    def total(self) -> int:
        """Samples that count."""
        return int(self.excess.size)

    @property
    def broken(self) -> int:
        """Samples that break a limit."""
        return int(np.count_nonzero(~(self.excess <= 0.0)))

    @property
    def violations(self) -> Violations:
        """The same as samples of one requirement are told."""
        words = "a limit broken in a step, a return, a sequence or under a load"
        return counted("requirement", words, None, "", ~(self.excess <= 0.0))

    @property
    def upper_bound(self) -> float:
        """Exact upper bound, at 95 % two-sided, of the probability that one breaks a limit."""
        return interval(self.broken, self.total)[1]


@dataclass(frozen=True)
class WorstFound:
    """What a search found: the worst case, what limits are held against in it, its largest excess as a
    share of the limit and of which; runs; how many of them broke a limit; the largest cost of a step of the
    task that a second search found, and where."""

    case: Case
    values: dict[str, float]
    excess: float
    excess_of: str
    runs: int
    broken: int
    worst_cost: float
    dearest: Case | None


def check(
    requirement: Requirement, controller: Any, samples: int, seed: int, jobs: int | None = None,
    progress: Tell | None = None,
) -> Check:  # fmt: skip
    """Run fresh samples of a requirement, drawn uniformly over its cases: sample i depends on the seed and
    on i alone."""
    tell = progress or (lambda stage, share: None)
    space, places, values = requirement.space, list[Array](), list[dict[str, Array]]()
    beyond = 0
    for piece in range(-(-samples // CHUNK)):
        tell("fresh samples", piece * CHUNK / samples)
        count = min(CHUNK, samples - piece * CHUNK)
        x = generator(seed + 1, piece, CASES).random((space.size, CHUNK))[:, :count]
        ok = space.reachable(x)
        beyond += int(np.count_nonzero(~ok))
        places.append(x[:, ok])
        values.append(requirement.run(x[:, ok], controller, (seed + 1, piece), jobs))
    x = np.hstack(places)
    joined = {n: np.concatenate([v[n] for v in values]) for n in values[0]}
    task = space.of_task(x)
    cost, settling = joined[COSTS[requirement.cost]][task], joined["settling_time_s"][task]
    return Check(
        x, joined, requirement.excess(joined), beyond, float(cost.max(initial=0.0)),
        float(settling.max(initial=0.0)),
    )  # fmt: skip


def worst_of(
    requirement: Requirement,
    controller: Any,
    budget: int,
    seed: int,
    known: Array | None = None,
    jobs: int | None = None,
    guard: dict[str, float] | None = None,
    cost: bool = False,
) -> Hunted:
    """The places of largest excess that a search of about `budget` runs found; or of largest cost."""
    space = requirement.space

    def height(x: Array) -> Array:
        values = requirement.run(x, controller, jobs=jobs)
        high = requirement.excess(values, guard)
        if cost:
            high = np.where(space.of_task(x), values[COSTS[requirement.cost]], -np.inf)
        return np.where(space.reachable(x), high, -np.inf)

    given = np.empty((space.size, 0)) if known is None else known
    return hunt(height, given, budget, seed, len(space.box.intervals), space.kind)


def worst_cases(
    requirement: Requirement, found: Hunted, above: float, count: int = BATCH
) -> tuple[Case, ...]:
    """The worst places of a search that lie above a height, as cases."""
    return tuple(
        requirement.space.case(found.places[:, i])[0] for i in found.worst(count) if found.heights[i] > above
    )


def broken_cases(
    requirement: Requirement, controller: Any, samples: int, budget: int, seeds: tuple[int, int],
    jobs: int | None = None,
) -> tuple[Case, ...]:  # fmt: skip
    """The worst cases that break a limit of those that `check` and `worst_found` meet with seeds of their
    own."""
    fresh = check(requirement, controller, samples, seeds[0], jobs)
    hunted = worst_of(requirement, controller, budget - budget // 10, seeds[1], jobs=jobs)
    both = (Hunted(fresh.places, fresh.excess), hunted)
    return tuple(c for found in both for c in worst_cases(requirement, found, 0.0))


def worst_found(
    requirement: Requirement, controller: Any, budget: int, seed: int, jobs: int | None = None,
    progress: Tell | None = None,
) -> WorstFound:  # fmt: skip
    """Search for the worst case of a controller: for the largest excess in most of the budget, for the
    largest cost of a step of the task in the rest."""
    tell = progress or (lambda stage, share: None)
    tell("worst case", 0.0)
    hunted = worst_of(requirement, controller, budget - budget // 10, seed, jobs=jobs)
    tell("dearest case", 0.9)
    dear = worst_of(requirement, controller, budget // 10, seed, jobs=jobs, cost=True)
    (i,) = hunted.worst(1)
    place = hunted.places[:, [i]]
    values = requirement.run(place, controller, jobs=jobs)
    beyond = {n: float(v[0]) for n, v in excesses(values, requirement.limits).items()}
    name = max(beyond, key=lambda n: beyond[n])
    (j,) = dear.worst(1)
    found = np.isfinite(dear.heights[j])
    return WorstFound(
        requirement.space.case(place[:, 0])[0], {n: float(v[0]) for n, v in values.items()},
        beyond[name], name, hunted.heights.size + dear.heights.size,
        int(np.count_nonzero(hunted.heights > 0.0)), float(dear.heights[j]) if found else float("inf"),
        requirement.space.case(dear.places[:, j])[0] if found else None,
    )  # fmt: skip
