"""A tuning under the whole requirement, in words and for machines."""

from typing import Any

from design.robustness.requirement import Requirement, requirement_record
from design.robustness.tuning.robust_tuning import RobustTuning
from design.synthesis.answer import refusal
from design.synthesis.tuning import Tuning
from reports.shared.tuning import refused


def lines(found: RobustTuning[Tuning]) -> list[str]:
    """Lines of a robust tuning for people, besides the gains."""
    said = [requirement_words(found.requirement)]
    for number, r in enumerate(found.rounds, 1):
        if r.runs:
            said.append(
                f"round {number}: Kp = {r.tuning.Kp:.4g} kPa/deg, Ki = {r.tuning.Ki:.4g} kPa/(deg s) on "
                f"{len(r.tuning.problem.adverse)} cases; {_excess_words(r.excess)} in {r.runs} runs of the "
                f"{r.by}, {len(r.added)} cases added"
            )
    said.append(f"ended after {len(found.rounds)} rounds: {found.ended}")
    if found.fresh is not None and found.holds:
        said.append(
            f"{found.fresh.broken} of {found.fresh.total} fresh samples break a limit (below "
            f"{100 * found.fresh.upper_bound:.2g} % at 95 % confidence)"
        )
        said.append(
            f"tuned to {100 * (1 - found.guard['overshoot_percent']):.3g} % of the overshoot limit, since "
            "overshoot changes abruptly between cases; the verdict uses the limit itself"
        )
    return said


def requirement_words(asked: Requirement) -> str:
    """The requirement on the gains, in a line."""
    c, rig = asked.conditions, asked.box.plant.rig
    late = (
        f"dead time of 0 to {1000 * asked.space.dead_time:.3g} ms"
        if asked.space.dead_time
        else "no dead time"
    )
    if any(e.NAME == "dead-time" for e in asked.wrist.effects):
        late = "the identified dead time"
    unit, left = rig.units.angle, asked.box.remainder
    count = len(asked.box.leaving(None).intervals)
    met = (
        ""
        if left is None
        else f"the unexplained residual of the plant model (up to {left.peak:.3g} {unit}), "
    )
    return (
        f"required on {count} uncertain parameters, {late}, {met}load up to "
        f"{asked.space.load:g} {unit}, noise {c.noise:g} {unit}, resolution {c.quantum:g} {unit}: "
        f"{', '.join(asked.space.kinds)} cases"
    )


def _excess_words(excess: float) -> str:
    if excess > 0.0:
        return f"a limit is exceeded by {100 * excess:.2g} %"
    return f"the nearest limit is {100 * -excess:.2g} % away"


def record(found: RobustTuning[Tuning]) -> dict[str, Any]:
    """A robust tuning as dictionaries, lists, numbers and text, for JSON."""
    fresh, no = found.fresh, refusal(found.final)
    return {
        "Kp": found.final.Kp,
        "Ki": found.final.Ki,
        "holds": found.holds,
        "ended": found.ended,
        "refusal": None if no is None else refused(no),
        "requirement": requirement_record(found.requirement),
        "guard": found.guard,
        "samples": None
        if fresh is None
        else {"broken": fresh.broken, "total": fresh.total, "upper_bound": fresh.upper_bound},
        "rounds": [
            {
                "Kp": r.tuning.Kp,
                "Ki": r.tuning.Ki,
                "b": r.tuning.gains["b"],
                "Tf": r.tuning.gains["Tf"],
                "feasible": refusal(r.tuning) is None,
                "cases_in_the_set": [s.name for s in r.tuning.problem.adverse],
                "worst_cost_of_the_set": float(r.tuning.at.cost[0]),
                "worst_cost_on": r.tuning.problem.place("cost", int(r.tuning.at.cost_at[0])),
                "worst_excess": r.excess,
                "found_by": r.by,
                "runs": r.runs,
                "added": [s.name for s in r.added],
            }
            for r in found.rounds
        ],
    }
