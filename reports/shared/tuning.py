"""What a tuning answers, in words and for machines."""

from typing import Any

import numpy as np

from design.synthesis.answer import UNITS, Answer, OutOfReach, Refusal
from design.synthesis.requirements import COSTS, LIMIT_UNITS
from design.synthesis.tuning import Tuning

ONE_SIDED = (
    "; the rig bends to one side: run `wrist design` on its log, which counts the angle from the middle of "
    "its range"
)


def refused(no: Refusal) -> str:
    """Why the limits cannot be met, in one line.

    >>> refused(OutOfReach("0 to +15 deg from virgin, nominal plant", None, 0.1234))
    'no: the command range is 0.123 V too small to hold 0 to +15 deg from virgin, nominal plant'
    """
    if isinstance(no, OutOfReach):
        advice = ONE_SIDED if no.one_sided else ""
        if no.obstacle is not None:
            return f"no: {no.obstacle} keeps the wrist from holding {no.scenario}{advice}"
        return f"no: the command range is {no.volts:.3g} V too small to hold {no.scenario}{advice}"
    unit = "" if LIMIT_UNITS[no.limit] == "1" else f" {LIMIT_UNITS[no.limit]}"
    broken = f"{no.limit} is {no.value:.4g}{unit} against {no.bound:g} on {no.place}"
    if no.given:
        return f"no: the given gains, Kp {no.Kp:.4g}, Ki {no.Ki:.4g}, break a limit: {broken}"
    (low_p, high_p), (low_i, high_i) = no.Kp_range, no.Ki_range
    return (
        f"no: no gains in Kp {low_p:g} to {high_p:g}, Ki {low_i:g} to {high_i:g} meet every limit; nearest "
        f"are Kp {no.Kp:.4g}, Ki {no.Ki:.4g}, where {broken}"
    )


def gains_line(found: Tuning) -> str:
    """Gains of a tuning as the commands print them, with weight and filter where it has them."""
    own = found.settings
    more = f", b = {own['b']:.3g}, Tf = {own['Tf']:.3g} s" if own else ""
    return f"Kp = {found.Kp:.4g} kPa/deg, Ki = {found.Ki:.4g} kPa/(deg s){more}"


def tuning_record(found: Answer, axis: str) -> dict[str, Any]:
    """A tuning as dictionaries, lists, numbers and text, for JSON.

    `metrics` are of the nominal step from rest, `worst_case` over all scenarios.
    """
    t = found.tuning
    problem, at = t.problem, t.at
    worst = int(at.cost_at[0])
    on_map = np.where(t.map.feasible, t.map.cost, np.inf)
    return {
        "axis": axis,
        "Kp": t.Kp,
        "Ki": t.Ki,
        **t.settings,
        "units": UNITS,
        "feasible": found.refusal is None,
        "refusal": None if found.refusal is None else refused(found.refusal),
        "cost": problem.cost,
        "metrics": {
            **found.nominal,
            "Ms": float(at.values["Ms"][0]),
            "delay_margin_s": float(at.values["delay_margin_s"][0]),
        },
        "worst_case": {
            "scenario": problem.place("cost", worst),
            COSTS[problem.cost]: float(at.cost[0]),
            "each_metric_over_all_scenarios": found.everywhere,
        },
        "limits": {
            n: {
                "limit": limit,
                "value": float(at.values[n][0]),
                "on": problem.place(n, int(at.values_at[n][0])),
            }
            for n, limit in problem.limits.named.items()
        },
        "active_constraint": t.active,
        "optimality": {
            "map_points": [t.region.points, t.region.points],
            "map_Kp": list(t.region.Kp),
            "map_Ki": list(t.region.Ki),
            "map_resolution": list(t.region.resolution),
            "map_feasible": int(t.map.feasible.sum()),
            "map_best_cost": float(on_map.min()),
            "local_searches": [vars(s) for s in t.searches],
            "spread_of_best_searches": t.spread,
            "on_edge_of_region": t.on_edge,
        },
        "scenarios": len(problem.scenarios),
        **({"cases": len(problem.adverse), "guard": dict(problem.guard)} if problem.guard else {}),
        **({"given": True, "cases": len(problem.adverse)} if t.given else {}),
        "set_aside": [s.name for s in problem.set_aside],
    }
