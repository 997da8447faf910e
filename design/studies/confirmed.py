"""The recommended gains of a design, confirmed by samples and a search that had no part in their tuning."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from design.robustness.checks import broken_cases
from design.robustness.requirement import Requirement
from design.robustness.tuning.recommended import PLAIN, TWO_DOF, pays
from design.studies.decision import AGAIN, checked, of_check, seeds
from design.studies.designs import DesignEffort, tuned_designs
from design.studies.stages import Stages
from design.synthesis.structure import with_gains

Tell = Callable[[str, float], None]


def best_of(designs: Mapping[str, Any]) -> str:
    """Which PI is recommended of those that were tuned."""
    one, two = designs[PLAIN], designs[TWO_DOF]
    costs, guards = [one["cost"], two["cost"]], [d["guard"]["overshoot_percent"] for d in (one, two)]
    return TWO_DOF if pays((one["holds"], two["holds"]), costs, guards) else PLAIN


def confirmed(
    motion: str,
    required: Requirement,
    designs: dict[str, Any],
    asked: dict[str, Any],
    stages: Stages,
    effort: DesignEffort,
    seed: int,
    jobs: int | None,
    tell: Tell,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """What fresh samples and a search find of the recommended gains, and the designs.

    Where gains that held their tuning break a limit there, the PIs are tuned again from the cases that do,
    and checked with other seeds; a tuning that no longer holds changes nothing.
    """
    for again in range(AGAIN + 1):
        controller = with_gains(required.wrist, designs[best_of(designs)]["gains"])
        mine = {**asked, "gains": designs[best_of(designs)]["gains"]}
        check = partial(checked, required, controller, effort.samples, effort.runs, seed + again, jobs, tell)
        evidence = stages.done(of_check(motion, again), mine, check)
        broken = evidence["samples"]["broken"] + evidence["worst_case"]["broken"]
        if again == AGAIN or not broken or not designs[best_of(designs)]["holds"]:
            break
        cases = partial(
            broken_cases, required, controller, effort.samples, effort.runs, seeds(seed + again), jobs
        )
        fewer = replace(effort, alternatives=False)
        tune = partial(tuned_designs, required, fewer, seed, jobs, lambda s, h: tell(f"tune again: {s}", h))
        more = stages.done(f"tune-{motion}-again-{again + 1}", mine, lambda: tune(cases()))  # noqa: B023
        del more["relaxed"]
        if not more[best_of(more)]["holds"]:
            break
        designs = designs | more
    return evidence, designs
