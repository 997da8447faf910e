"""What a tuning answers: gains and their evidence, or no, with the limit and the scenario."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from design.controllers.reference_model import reachable
from design.evaluation.cases import hindrance
from design.synthesis.evaluate import adverse_values, out_of_range, simulated
from design.synthesis.judged import nearest_limit
from design.synthesis.requirements import COSTS, Problem
from design.synthesis.tuning import Tuning
from plants.wrist import Wrist

UNITS = {"Kp": "kPa/deg", "Ki": "kPa/(deg s)"}
"""Units of the gains."""

NOMINAL = ("settling_time_s", "overshoot_percent", "iae_deg_s", "itae_deg_s2", "total_variation_V")
"""Metrics that an answer tells of the nominal step, and at their worst over all scenarios."""


@dataclass(frozen=True)
class OutOfReach:
    """No gains help: the scenario, by name, whose reference no command holds, since an `obstacle` stands in
    the way (in words), or, where that is None, since the command range is `volts` [V] too small; one_sided:
    whether the step would be in reach either way from the middle of the range, where zero is not."""

    scenario: str
    obstacle: str | None
    volts: float
    one_sided: bool = False


@dataclass(frozen=True)
class LimitBroken:
    """No gains of a region (ranges of Kp [kPa/deg] and Ki [kPa/(deg s)]) meet every limit: at the nearest,
    Kp and Ki, the value of `limit` is beyond its bound in a place, by name; given: the same of gains that
    were given, and not searched for."""

    Kp_range: tuple[float, float]
    Ki_range: tuple[float, float]
    Kp: float
    Ki: float
    limit: str
    value: float
    bound: float
    place: str
    given: bool = False


Refusal = OutOfReach | LimitBroken
"""Why the limits cannot be met."""


@dataclass(frozen=True)
class Answer:
    """A tuning with what its gains do: metrics of the nominal step from rest, and the worst of each over all
    scenarios, both by name; refusal: None where every limit is held."""

    tuning: Tuning
    nominal: Mapping[str, float]
    everywhere: Mapping[str, float]
    refusal: Refusal | None


def answer(found: Tuning) -> Answer:
    """The answer of a tuning, whose gains are run once more on all scenarios."""
    problem = found.problem
    judged = simulated(problem, found.controller, 1)
    plain = next(
        i
        for i, s in enumerate(problem.scenarios)
        if (s.task.start, s.plant) == ("virgin", "nominal") and s.task.reference > 0
    )
    values = {n: getattr(judged, n)[0] for n in NOMINAL}
    return Answer(
        found,
        {n: float(v[plain]) for n, v in values.items()},
        _everywhere(found, values),
        refusal(found),
    )


def _everywhere(found: Tuning, values: Mapping[str, np.ndarray]) -> dict[str, float]:
    """The worst of metrics over the scenarios and the adverse cases, IAE and ITAE of the task's steps
    alone."""
    worst = {n: float(np.max(v)) for n, v in values.items()}
    if found.problem.adverse:
        of_task = np.array([s.of_task for s in found.problem.adverse])
        for name, v in adverse_values(found.problem, found.controller, 1).items():
            counted = np.where(of_task, v[0], 0.0) if name in COSTS.values() else v[0]
            worst[name] = max(worst.get(name, 0.0), float(np.max(counted)))
    return {n: worst[n] for n in values}


def out_of_reach(problem: Problem) -> OutOfReach | None:
    """The scenario of a problem that no gains can do; None where there is none."""
    lack = out_of_range(problem)
    if lack is None:
        return None
    scenario, volts = lack
    return OutOfReach(scenario.name, hindrance(scenario), float(volts), bends_to_one_side(scenario.wrist))


def bends_to_one_side(wrist: Wrist) -> bool:
    """Whether a wrist reaches two steps of its task whatever its memory, but not one either way from zero."""
    (low, high), step = reachable(wrist), wrist.rig.task.step
    return min(-low, high) < step and 2.0 * step <= high - low


def refusal(found: Tuning) -> Refusal | None:
    """Why the limits cannot be met, or None where they are."""
    beyond = out_of_reach(found.problem)
    if beyond is not None or found.feasible:
        return beyond
    name = nearest_limit(found.at, 0)
    assert name is not None
    return LimitBroken(
        found.region.Kp, found.region.Ki, found.Kp, found.Ki, name, float(found.at.values[name][0]),
        found.problem.held_to[name], found.problem.place(name, int(found.at.values_at[name][0])), found.given,
    )  # fmt: skip
