"""Which PI is recommended under a requirement: the plain one, or a two-degree-of-freedom one that pays."""

from collections.abc import Callable
from dataclasses import dataclass

from design.evaluation.cases import Case
from design.robustness.requirement import Requirement
from design.robustness.tuning.robust_tuning import RobustTuning, tune_robustly
from design.synthesis.structure import PLAIN_PI, TWO_DOF_PI
from design.synthesis.tuning import Region, Tuning

Tell = Callable[[str, float], None]

PLAIN, TWO_DOF = PLAIN_PI.name, TWO_DOF_PI.name
PAYS = 0.05
"""A second degree of freedom is recommended where it lowers the worst cost by this share."""


@dataclass(frozen=True)
class Candidates:
    """Both tunings under one requirement; two_dof: None where the task is out of the plant's reach."""

    plain: RobustTuning[Tuning]
    two_dof: RobustTuning[Tuning] | None

    @property
    def best(self) -> RobustTuning[Tuning]:
        """The one that is recommended."""
        if self.two_dof is None:
            return self.plain
        both = (self.plain, self.two_dof)
        costs = [float(t.final.at.cost[0]) for t in both]
        guards = [t.guard["overshoot_percent"] for t in both]
        return self.two_dof if pays((self.plain.holds, self.two_dof.holds), costs, guards) else self.plain


def pays(holds: tuple[bool, bool], costs: list[float], guards: list[float]) -> bool:
    """Whether the second of two tunings is recommended, that holds the requirement or not, at a cost, tuned
    below the limits by a guard: where both hold it, one with a thinner guard is not preferred for its cost.

    >>> same = [0.1, 0.1]
    >>> pays((True, True), [10.0, 9.0], same), pays((True, True), [10.0, 9.9], same)
    (True, False)
    >>> pays((False, True), [10.0, 12.0], same), pays((True, True), [10.0, 9.0], [0.1, 0.025])
    (True, False)
    """
    if all(holds):
        if guards[0] != guards[1]:
            return guards[1] > guards[0]
        return costs[1] < (1.0 - PAYS) * costs[0]
    return holds[1]


def tune_candidates(
    requirement: Requirement,
    region: Region | None = None,
    seed: int = 0,
    rounds: int = 15,
    jobs: int | None = None,
    progress: Tell | None = None,
    cases: tuple[Case, ...] = (),
) -> Candidates:
    """Tune a PI under a requirement, and from its gains and cases on one with two degrees of freedom;
    arguments as of `tune_robustly`."""
    tell = progress or (lambda stage, share: None)
    plain = tune_robustly(
        requirement, region, 0, seed, rounds, jobs, lambda s, h: tell(f"{PLAIN}: {s}", 0.6 * h), cases=cases
    )
    if plain.ended == "out of reach":
        return Candidates(plain, None)
    two_dof = tune_robustly(
        requirement, region, 0, seed, rounds, jobs, lambda s, h: tell(f"{TWO_DOF}: {s}", 0.6 + 0.4 * h),
        TWO_DOF_PI, base=plain.final,
    )  # fmt: skip
    return Candidates(plain, two_dof)
