"""Everything that can be said of a pair of gains: certificates, predictions, samples, the worst case.

The three kinds answer different questions and are kept apart; where they seem to contradict each
other, `disagreement` says how both can be true.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from design.controllers.pi import PI
from design.robustness.box import Box
from design.robustness.certificates.certificate import Certificate
from design.robustness.certificates.constant import robust_stability as constant
from design.robustness.certificates.continuous.virgin import time_on_virgin_curve
from design.robustness.certificates.reasons import OtherLaw
from design.robustness.certificates.rungs import certify_everything
from design.robustness.certificates.sampled.words import Word
from design.robustness.certificates.statements import (
    NotFound,
    of_ladder,
    of_step,
    of_tasks,
    of_virgin_curve,
)
from design.robustness.checks import Check, check
from design.robustness.loop_model import LoopModel
from design.robustness.predictions import limit_cycles as cycles
from design.robustness.predictions import margins
from design.robustness.predictions.limit_cycles import LimitCycle
from design.robustness.predictions.orbits import large_swings
from design.robustness.requirement import Requirement
from design.robustness.samples import monte_carlo as carlo
from design.robustness.samples.adversary import worst_case
from design.robustness.samples.conditions import Conditions
from design.robustness.samples.monte_carlo import Samples
from design.robustness.samples.statements import statement
from design.robustness.samples.statements import statements as of_samples
from design.robustness.samples.worst import Worst
from design.robustness.statement import Reason, Statement
from design.status import BY_PROOF, Status
from design.synthesis.requirements import Limits
from plants.effects.wrist.remainder import ColouredRemainder
from plants.errors import InputError
from plants.parameters.remainder import UncertaintyWeight
from plants.wrist import Wrist

Tell = Callable[[str, float], None]
DEAD_TIMES = (0.0, 0.050)
"""Dead times [s] that certificates are sought for: none, and what rigs of this kind show (assumed)."""

BUDGET = 20_000
"""Runs of the search for the worst case; twice as many where no limit is found to be broken."""


@dataclass(frozen=True)
class UnstableCentre(Reason):
    """The loop is unstable at the centre of the box; what the computation said, in a line."""

    said: str


@dataclass(frozen=True)
class Assessment:
    """What was found of a PI on the plants of a box.

    certificates, predictions, samples: statements of each kind; ladder: the certificates for loops
    that switch; word: an order of switching that makes the class of these loops grow, where one was found;
    margins: rows of every branch and rate; cycles: limit cycles; cases: the samples, steps from rest; worst:
    the worst scenario that was found; required: fresh samples of the whole requirement, the worst scenario's
    judge and the tuning's.
    """

    box: Box
    controller: PI
    limits: Limits
    conditions: Conditions
    certificates: tuple[Statement, ...]
    predictions: tuple[Statement, ...]
    samples: tuple[Statement, ...]
    ladder: tuple[Certificate, ...]
    word: Word | None
    margins: tuple[dict[str, Any], ...]
    cycles: tuple[LimitCycle, ...]
    cases: Samples
    worst: Worst
    required: Check

    @property
    def wrist(self) -> Wrist:
        """The nominal plant."""
        return self.box.wrist

    @property
    def weight(self) -> UncertaintyWeight | None:
        """Weight of the unmodelled dynamics that the residual shows; None where it shows none."""
        return self.box.leaving(ColouredRemainder.of(self.box.plant.remainder.get("angle_deg"))).weight

    @property
    def stable(self) -> bool:
        """Whether the linear loop is stable on every branch at every rate."""
        return all(row["stable"] for row in self.margins)

    @property
    def left_out(self) -> tuple[str, ...]:
        """Effects of the plant that certificates know nothing of."""
        return LoopModel.of(self.wrist, self.controller).left_out

    @property
    def other_law(self) -> str:
        """What the controller has that no certificate knows, in words; empty where nothing."""
        return LoopModel.of(self.wrist, self.controller).other_law

    @property
    def statements(self) -> tuple[Statement, ...]:
        """All statements, certificates first."""
        return (*self.certificates, *self.predictions, *self.samples)


def assess(
    box: Box,
    controller: PI,
    limits: Limits | None = None,
    conditions: Conditions | None = None,
    samples: int = 2000,
    seed: int = 0,
    jobs: int | None = None,
    scheduler: str | None = None,
    progress: Tell | None = None,
    budget: int = BUDGET,
) -> Assessment:
    """Assess a PI on the plants of a box, on steps of 15 deg.

    conditions: what samples and the worst case may have beside the box; budget: runs that the search for
    the worst case may take.  Raises InputError where the
    box holds no case that a command can hold, and as `design.cluster.each` does of a scheduler.
    """
    left = ColouredRemainder.of(box.plant.remainder.get("angle_deg"))
    conditions = conditions or Conditions()
    asked = Requirement(
        box.leaving(left), limits or Limits.of(box.plant.rig), conditions,
        duration=box.plant.rig.task.duration,
    )  # fmt: skip
    limits = asked.limits
    tell = progress or (lambda stage, share: None)
    wrist = box.wrist
    # First, since they may refuse the conditions or find no scheduler.
    cases = carlo.monte_carlo(
        box, controller, conditions, samples, seed, limits, jobs=jobs, scheduler=scheduler, progress=tell
    )
    tell("margins", 0.0)
    rows = margins.branch_margins(wrist, controller, weight=asked.box.weight)
    stable = all(row["stable"] for row in rows)
    tell("limit cycles", 0.0)
    found, swings = cycles.limit_cycles(wrist, controller), large_swings(wrist, controller)
    tell("certificates", 0.0)
    rungs, word = certify_everything(
        wrist, controller, DEAD_TIMES, asked.box, stable, lambda share: tell("certificates", share)
    )
    tell("constant parameters", 0.0)
    fixed = _constant(asked.box, controller)
    space = asked.space  # a plant with a dead time or a load step of its own keeps it
    worst = worst_case(
        asked.box, controller, limits=limits, dead_time=space.dead_time, load=space.load, seed=seed,
        jobs=jobs, progress=tell, budget=budget, kinds=space.kinds,
    )  # fmt: skip
    required = check(asked, controller, samples, seed, jobs, tell)
    tell("done", 1.0)
    left_out = LoopModel.of(wrist, controller).left_out
    proved = [s for s in fixed if s.status in BY_PROOF]
    predicted = [s for s in fixed if s.status is Status.PREDICTED]
    return Assessment(
        box, controller, limits, conditions,
        (
            *of_ladder(rungs, left_out), *of_tasks(rungs, wrist.rig.task.step, left_out),
            *of_step(rungs, wrist.rig.task.step), *_virgin(wrist, controller), *proved,
        ),
        (*margins.statements(rows, limits), *cycles.statements(found, swings), *predicted),
        (statement(required.violations, False, required.out_of_reach), *of_samples(cases)),
        tuple(rungs), word, tuple(rows), tuple(found), cases, worst, required,
    )  # fmt: skip


def _virgin(wrist: Wrist, controller: PI) -> list[Statement]:
    """The time on the virgin curve, for a step either way."""
    size = wrist.rig.task.step
    return [of_virgin_curve(time_on_virgin_curve(wrist, controller, step), step) for step in (size, -size)]


def _constant(box: Box, controller: PI) -> list[Statement]:
    """What holds of constant parameters; of a loop that is unstable at the centre, that it does not."""
    found: list[Statement] = []
    other = LoopModel.of(box.wrist, controller).other_law
    if other:
        why = NotFound(OtherLaw(other), None)
        return [
            Statement(Status.OPEN, constant.StableWhileConstant(False, t), None, None, why, "x the box")
            for t in DEAD_TIMES
        ]
    for dead_time in DEAD_TIMES:
        try:
            found += constant.statements(constant.robust_stability_everywhere(box, controller, dead_time))
        except InputError as unstable:
            claim = constant.StableWhileConstant(False, 0.0)
            found.append(Statement(Status.DISPROVED, claim, False, None, UnstableCentre(str(unstable))))
            break
    return found
