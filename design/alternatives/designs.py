"""Designs beside the tuned PI, made under its limits and on its scenarios, for a comparison.

A PI by convex-concave optimisation (`alternatives.convex_concave`), which asks for the largest integral gain,
a robust LQI (`alternatives.lqi_design`), which sees the pressure as well, and a PI with a feedforward by the
inverse (`alternatives.feedforward_design`).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from design.alternatives.convex_concave import ConvexConcave, convex_concave
from design.alternatives.feedforward_design import FeedforwardDesign, design_feedforward
from design.alternatives.lqi_design import RobustLQI, design_lqi
from design.synthesis import structure
from design.synthesis.convex import Unsolved
from design.synthesis.requirements import Problem
from plants.wrist import Wrist

CONVEX = "convex-concave PI"
LQI_NAME = "robust LQI"
FORWARD_PI, CASCADE_PI = structure.FORWARD_PI.name, structure.CASCADE_PI.name
ROBUST_MPC = "robust MPC"


@dataclass(frozen=True)
class RequirementDesign:
    """What ``wrist design`` tuned under the whole requirement of a rig, as the recommended PI.

    gains by name; cost: worst cost over its cases [deg s]; excess: the largest over a limit that was found,
    as a share of it, and the limit; cases: adverse cases of its tuning.
    """

    controller: Any
    gains: Mapping[str, float]
    cost: float
    excess: float
    limit: str | None
    cases: int

    @classmethod
    def of(cls, wrist: Wrist, record: Mapping[str, Any]) -> "RequirementDesign":
        """The design of a wrist that a design's JSON tells of."""
        return cls(
            structure.with_gains(wrist, record["gains"]), record["gains"], record["cost"],
            excess_of(record) or 0.0, record["worst_excess_of"], record["cases"],
        )  # fmt: skip

    @property
    def breaks(self) -> tuple[str, ...]:
        """The limit that is broken in some case of the requirement."""
        return () if self.excess <= 0.0 or self.limit is None else (self.limit,)


def excess_of(record: Mapping[str, Any]) -> float | None:
    """By what share a design breaks the limit that it breaks most; None where its record tells of none.

    A record that went through a file has null for what is infinite, as Ms of an unstable loop is.

    >>> excess_of({"worst_excess": 0.1}), excess_of({"worst_excess": None}), excess_of({})
    (0.1, inf, None)
    """
    if "worst_excess" not in record:
        return None
    found = record["worst_excess"]
    return float("inf") if found is None else float(found)


Design = ConvexConcave | RobustLQI | FeedforwardDesign | RequirementDesign
MAKERS: dict[str, Callable[[Problem], Design]] = {
    CONVEX: convex_concave,
    LQI_NAME: design_lqi,
    FORWARD_PI: design_feedforward,
}


def design_others(
    problem: Problem,
    progress: Callable[[str, float], None] | None = None,
    makers: Mapping[str, Callable[[Problem], Design]] = MAKERS,
) -> dict[str, Design | str]:
    """The other designs for a tuning problem, by name; of one that cannot be made, the reason.  `progress` is
    told which is being made, and the share that is done; makers: of each by name."""
    found: dict[str, Design | str] = {}
    for place, (name, design) in enumerate(makers.items()):
        if progress:
            progress(name, place / len(makers))
        try:
            found[name] = design(problem)
        except (Unsolved, ValueError) as error:
            found[name] = str(error)
    return found


def design_mpcs(wrist: Wrist) -> dict[str, Any]:
    """The MPCs of a comparison, by name, whose model is the wrist without its effects: linear and real-time
    iteration in the fast setting, and the latter in the one that is made for an unknown dead time.

    Their weights are those of `design.mpc.problem`: they are not tuned on a plant's scenarios.  Raises
    InputError where their solver is not installed.
    """
    from design.mpc.formulations.linear import linear_mpc
    from design.mpc.formulations.real_time import real_time_mpc
    from design.mpc.problem import nominal, robust

    bare = replace(wrist, effects=())
    return {
        "linear MPC": linear_mpc(nominal(bare)),
        "real-time MPC": real_time_mpc(nominal(bare)),
        ROBUST_MPC: real_time_mpc(robust(bare)),
    }


def design_record(design: Design | str) -> dict[str, Any]:
    """What a design rests on, for JSON: solver, what is active or guaranteed, cost and limits on the
    scenarios that it was made on, and which limits it breaks there."""
    if isinstance(design, str):
        return {"none": design}
    if isinstance(design, RequirementDesign):
        return {
            "worst_iae_deg_s": design.cost, "gains": dict(design.gains), "breaks": list(design.breaks),
            "cases": design.cases,
        }  # fmt: skip
    record: dict[str, Any] = {
        "worst_iae_deg_s" if design.problem.cost == "iae" else "worst_cost": float(design.at.cost[0]),
        "values": {n: float(v[0]) for n, v in design.at.values.items()},
        "breaks": list(design.breaks),
    }
    if isinstance(design, ConvexConcave):
        shaped = design.shaped
        return record | {
            "solver": shaped.solver, "iterations": shaped.iterations, "active": list(shaped.active),
            "Kp_before": shaped.Kp, "Ki_before": shaped.Ki, "share": design.share,
            "linear_limits": vars(design.shape),
        }  # fmt: skip
    if isinstance(design, FeedforwardDesign):
        c = design.controller
        return record | {"tried": design.tried, "speed": c.speed, "Kp": c.Kp, "Ki": c.Ki}
    feedback = design.choice.feedback
    return record | {
        "solver": feedback.solver, "weights": vars(design.choice.weights), "tried": design.tried,
        "guaranteed_decay_1_s": feedback.decay, "certificate_margin": feedback.margin,
        "worst_pole": design.pole,
    }  # fmt: skip
