"""A robust tuning, in words and for machines."""

from typing import Any

from design.robustness.robust_tuning import RobustTuning
from design.robustness.samples.worst import Worst
from design.synthesis.answer import refusal
from design.synthesis.requirements import LIMIT_UNITS
from reports.shared.tuning import refused


def lines(found: RobustTuning) -> list[str]:
    """What people read of a robust tuning."""
    said = []
    for number, r in enumerate(found.rounds, 1):
        said.append(
            f"round {number}: Kp = {r.tuning.Kp:.4g} kPa/deg, Ki = {r.tuning.Ki:.4g} kPa/(deg s) on "
            f"{len(r.tuning.problem.scenarios)} scenarios and {len(r.tuning.problem.adverse)} worst cases; "
            + "; ".join(f"{_words(c)}: {c.sequence.name}" for c in r.cases)
        )
    used = sum(c.evaluations for r in found.rounds for c in r.cases)
    said.append(f"ended after {len(found.rounds)} rounds and {used} runs of search: {found.ended}")
    if found.refusal is not None:
        said.append(refused(found.refusal))
    a, b, cost = found.before, found.after, found.final.problem.cost
    said.append(
        f"price on the plain set, before and after: {cost} of the nominal step {a.nominal_cost:.4g} and "
        f"{b.nominal_cost:.4g}, of the worst scenario {a.worst_cost:.4g} and {b.worst_cost:.4g}; the nominal "
        f"step settles in {a.settling_time_s:.3g} and {b.settling_time_s:.3g} s"
    )
    return said


def _words(worst: Worst) -> str:
    """What a worst case does, in words."""
    broken = [f"{n} {worst.values[n]:.4g} {LIMIT_UNITS[n]}" for n in worst.violated]
    words = f"breaks {', '.join(broken)}" if broken else "breaks no limit"
    if worst.objective == "cost":
        return f"the dearest case found has an IAE of {worst.cost_per_deg:.4g} s per degree and {words}"
    return f"the worst case found {words}"


def record(found: RobustTuning) -> dict[str, Any]:
    """A robust tuning as dictionaries, lists, numbers and text, for JSON."""
    return {
        "Kp": found.final.Kp,
        "Ki": found.final.Ki,
        "holds": found.holds,
        "ended": found.ended,
        "refusal": None if found.refusal is None else refused(found.refusal),
        "rounds": [
            {
                "Kp": r.tuning.Kp,
                "Ki": r.tuning.Ki,
                "feasible": refusal(r.tuning) is None,
                "worst_cases_in_the_set": [s.name for s in r.tuning.problem.adverse],
                "worst_cost_of_the_set": float(r.tuning.at.cost[0]),
                "worst_cost_on": r.tuning.problem.place("cost", int(r.tuning.at.cost_at[0])),
                "worst_cases": [c.record for c in r.cases],
                "added": [s.name for s in r.added],
            }
            for r in found.rounds
        ],
        "price": {"cost": found.final.problem.cost, "before": vars(found.before), "after": vars(found.after)},
    }
