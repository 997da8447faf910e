"""What a tuning answers: gains and their evidence, or no, with the limit and the scenario."""

from typing import Any

import numpy as np

from design.requirements import COSTS, LIMIT_UNITS, out_of_range, rollouts
from design.tasks import hindrance
from design.tuning import Tuning, nearest_limit

UNITS = {"Kp": "kPa/deg", "Ki": "kPa/(deg s)"}
"""Units of the gains."""


def refusal(found: Tuning) -> str | None:
    """Why the limits cannot be met, in one line, or None where they are."""
    lack = out_of_range(found.problem)
    if lack is not None:
        scenario, volts = lack
        words = hindrance(scenario)
        if words is not None:
            return f"no: {words} keeps the wrist from holding {scenario.name}"
        return f"no: the command range is {volts:.3g} V too small to hold {scenario.name}"
    if found.feasible:
        return None
    name = nearest_limit(found.at, 0)
    assert name is not None
    place = found.problem.place(name, int(found.at.values_at[name][0]))
    value, limit = found.at.values[name][0], found.problem.limits.named[name]
    unit = "" if LIMIT_UNITS[name] == "1" else f" {LIMIT_UNITS[name]}"
    (low_p, high_p), (low_i, high_i) = found.region.Kp, found.region.Ki
    return (
        f"no: no gains in Kp {low_p:g} to {high_p:g}, Ki {low_i:g} to {high_i:g} hold every limit; nearest "
        f"are Kp {found.Kp:.4g}, Ki {found.Ki:.4g}, where {name} is {value:.4g}{unit} against {limit:g} "
        f"on {place}"
    )


def tuning_record(found: Tuning, axis: str) -> dict[str, Any]:
    """A tuning as dictionaries, lists, numbers and text, for JSON.

    `metrics` are of the nominal step from rest, `worst_case` over all scenarios.
    """
    problem, at = found.problem, found.at
    judged = rollouts(problem, at.Kp, at.Ki)
    plain = next(
        i
        for i, s in enumerate(problem.scenarios)
        if (s.start, s.plant) == ("virgin", "nominal") and s.reference > 0
    )
    names = ("settling_time_s", "overshoot_percent", "iae_deg_s", "itae_deg_s2", "total_variation_V")
    worst = int(at.cost_at[0])
    everywhere = {n: float(getattr(judged, n)[0].max()) for n in names}
    on_map = np.where(found.map.feasible, found.map.cost, np.inf)
    return {
        "axis": axis,
        "Kp": found.Kp,
        "Ki": found.Ki,
        "units": UNITS,
        "feasible": refusal(found) is None,
        "refusal": refusal(found),
        "cost": problem.cost,
        "metrics": {
            **{n: float(getattr(judged, n)[0, plain]) for n in names},
            "Ms": float(at.values["Ms"][0]),
            "delay_margin_s": float(at.values["delay_margin_s"][0]),
        },
        "worst_case": {
            "scenario": problem.place("cost", worst),
            COSTS[problem.cost]: float(at.cost[0]),
            "each_metric_over_all_scenarios": everywhere,
        },
        "limits": {
            n: {
                "limit": limit,
                "value": float(at.values[n][0]),
                "on": problem.place(n, int(at.values_at[n][0])),
            }
            for n, limit in problem.limits.named.items()
        },
        "active_constraint": found.active,
        "optimality": {
            "map_points": [found.region.points, found.region.points],
            "map_Kp": list(found.region.Kp),
            "map_Ki": list(found.region.Ki),
            "map_resolution": list(found.region.resolution),
            "map_feasible": int(found.map.feasible.sum()),
            "map_best_cost": float(on_map.min()),
            "local_searches": [vars(s) for s in found.searches],
            "spread_of_best_searches": found.spread,
            "on_edge_of_region": found.on_edge,
        },
        "scenarios": len(problem.scenarios),
        "set_aside": [s.name for s in problem.set_aside],
    }
