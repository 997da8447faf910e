"""``wrist tune``: gains of least worst cost under hard limits."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from design.cli.common import (
    Axis,
    AxisOption,
    JobsOption,
    JsonOption,
    OutOption,
    PlantOption,
    SeedOption,
    console,
    parameter_set,
    progress,
    seconds,
    write_json,
)

COST_TEXT = {
    "iae": "IAE {:.4g} deg s",
    "itae": "ITAE {:.4g} deg s²",
    "settling_time": "settling time {:.4g} s",
}

if TYPE_CHECKING:
    from design.tuning import Tuning
    from plants.wrist import Wrist

NAME = "tune"
HELP = "Tune the PI: least worst cost over starting memories and corners of the plant, under hard limits."
EXAMPLE = "Example: wrist tune --axis flexion --out build/tune"


def command(
    axis: AxisOption = Axis.flexion,
    plant: PlantOption = None,
    cost: Annotated[str, typer.Option(help="What is minimised: iae, itae or settling_time.")] = "iae",
    nominal: Annotated[
        bool,
        typer.Option(
            "--nominal", help="Only the nominal plant from rest, without the delay margin: fast on paper."
        ),
    ] = False,
    overshoot: Annotated[float, typer.Option(help="Limit on the simulated overshoot [%].", min=0.0)] = 5.0,
    ms: Annotated[
        float, typer.Option(help="Limit on the peak of the sensitivity on every branch.", min=1.0)
    ] = 2.0,
    delay_margin: Annotated[float, typer.Option(help="Least delay margin [s].", min=0.0)] = 0.060,
    variation: Annotated[
        float, typer.Option(help="Limit on the travel of the command in a step [V].", min=0.0)
    ] = 16.0,
    points: Annotated[int, typer.Option(help="Points of the map in each gain.", min=5, max=400)] = 40,
    starts: Annotated[int, typer.Option(help="Local searches.", min=1, max=100)] = 5,
    seed: SeedOption = 0,
    json: JsonOption = None,
    out: OutOption = None,
    jobs: JobsOption = None,
) -> None:
    from design.requirements import COSTS, Limits
    from design.tuning import Region, tune
    from plants.errors import InputError
    from plants.wrist import Wrist

    if cost not in COSTS:
        raise InputError(f"--cost: unknown cost {cost!r}; one of {', '.join(COSTS)}")
    chosen = parameter_set(axis, plant)
    limits = Limits(overshoot, ms, None if nominal else delay_margin, variation)
    problem = tuning_problem(Wrist.from_values(chosen.values), limits, cost, nominal, jobs)
    with progress("tune") as tell:
        found = tune(problem, Region(points=points), starts, seed, tell)
    said = console(json)
    for line in lines(found):
        said.print(line)
    if out is not None:
        from reports.figures import gain_map
        from reports.style import save

        path = out / f"tune-{chosen.axis}.png"
        save(gain_map(found), path)
        said.print(f"map of the gains in {path}")
    write_json(json, record(found, chosen.axis))
    if refusal(found) is not None:
        raise typer.Exit(1)


def tuning_problem(
    wrist: "Wrist", limits: Any = None, cost: str = "iae", nominal: bool = False, jobs: int | None = None
) -> Any:
    """The problem that ``wrist tune`` solves: all scenarios, or the step from rest of the nominal plant."""
    from design.requirements import Problem
    from design.tasks import tuning_scenarios

    scenarios = tuning_scenarios(wrist)
    if nominal:
        scenarios = [s for s in scenarios if (s.plant, s.start) == ("nominal", "virgin")]
    return Problem.of(wrist, scenarios, limits, cost, jobs=jobs)


def refusal(found: "Tuning") -> str | None:
    """Why the limits cannot be met, in one line, or None where they are."""
    from design.requirements import LIMIT_UNITS, out_of_range
    from design.tuning import nearest_limit

    lack = out_of_range(found.problem)
    if lack is not None:
        scenario, volts = lack
        return f"no: the command range is {volts:.3g} V too small to hold {scenario.name}"
    if found.feasible:
        return None
    name = nearest_limit(found.at, 0)
    assert name is not None
    place = found.problem.place(name, int(found.at.values_at[name][0]))
    return (
        f"no: no gains hold every limit; nearest are Kp {found.Kp:.4g}, Ki {found.Ki:.4g}, where {name} is "
        f"{found.at.values[name][0]:.4g} {LIMIT_UNITS[name]} against {found.problem.limits.named[name]:g} "
        f"on {place}"
    )


def lines(found: "Tuning") -> list[str]:
    """What people read of a tuning."""
    no = refusal(found)
    if no is not None:
        return [no]
    problem, at, region = found.problem, found.at, found.region
    metrics = record(found, "")["metrics"]
    apart = " and ".join(f"{100 * (r - 1):.0f} %" for r in region.resolution)
    said = [
        f"Kp = {found.Kp:.4g} kPa/deg, Ki = {found.Ki:.4g} kPa/(deg s)",
        f"worst {COST_TEXT[problem.cost].format(at.cost[0])} over {len(problem.scenarios)} scenarios, on "
        f"{problem.scenarios[int(at.cost_at[0])].name}",
        f"nominal step of +15 deg: settles in {seconds(metrics['settling_time_s'], problem.duration)}, "
        f"overshoot {metrics['overshoot_percent']:.2g} %, IAE {metrics['iae_deg_s']:.4g} deg s",
        f"worst overshoot {at.values['overshoot_percent'][0]:.3g} %, Ms {at.values['Ms'][0]:.3g}, "
        f"delay margin {1000 * at.values['delay_margin_s'][0]:.0f} ms, "
        f"travel of the command {at.values['total_variation_V'][0]:.3g} V",
        "active limit: "
        + (
            f"{found.active}, on {problem.place(found.active, int(at.values_at[found.active][0]))}"
            if found.active
            else "none; the optimum lies inside all limits"
        ),
        f"map of {region.points} x {region.points} gains, neighbours {apart} apart (Kp and Ki), "
        f"{found.map.feasible.sum()} within the limits; {sum(s.feasible for s in found.searches)} of "
        f"{len(found.searches)} local searches ended within the limits, none below the result",
    ]
    if problem.set_aside:
        said.append(
            f"{len(problem.set_aside)} scenarios set aside, since no command can hold them, such as "
            f"{problem.set_aside[0].name}"
        )
    if found.on_edge:
        said.append("the optimum lies on the edge of the searched gains, so it may go on outside")
    return said


def record(found: "Tuning", axis: str) -> dict[str, Any]:
    """A tuning for JSON; `metrics` are of the nominal step from rest, `worst_case` over all scenarios."""
    import numpy as np

    from design.requirements import COSTS, rollouts

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
        "units": {"Kp": "kPa/deg", "Ki": "kPa/(deg s)"},
        "feasible": refusal(found) is None,
        "refusal": refusal(found),
        "cost": problem.cost,
        "metrics": {
            **{n: float(getattr(judged, n)[0, plain]) for n in names},
            "Ms": float(at.values["Ms"][0]),
            "delay_margin_s": float(at.values["delay_margin_s"][0]),
        },
        "worst_case": {
            "scenario": problem.scenarios[worst].name,
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
