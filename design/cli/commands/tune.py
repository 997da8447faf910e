"""``wrist tune``: gains of least worst cost that hold the requirement of the rig."""

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from design.cli.common import (
    Axis,
    AxisOption,
    JobsOption,
    JsonOption,
    OutOption,
    PlantOption,
    SchedulerOption,
    SeedOption,
    check_dead_time,
    following,
    numbers,
    parameter_set,
    say_left_out,
    seconds,
    write_json,
)
from design.cli.completion import costs
from design.cli.places import check_places
from design.cli.strict import given as in_line
from design.cli.strict import refuse
from design.cli.terminal.screen import console, progress

COST_TEXT = {
    "iae": "IAE {:.4g} deg s",
    "itae": "ITAE {:.4g} deg s²",
    "settling_time": "settling time {:.4g} s",
}

if TYPE_CHECKING:
    from design.robustness.requirement import Requirement
    from design.synthesis.answer import Answer
    from design.synthesis.requirements import Limits
    from plants.parameters.quantities import ParameterSet

NAME = "tune"
HELP = (
    "Tune the PI: least worst-case cost, subject to limits over the rig's whole uncertainty: every plant of "
    "the box, dead time, initial state, load, noise and sequence of references."
)
EXAMPLE = "Example: wrist tune --axis flexion --out build/tune"
NEXT = "wrist robust --gains Kp,Ki"
WHOLE = (
    "--two-dof", "--robust", "--rounds", "--dead-time", "--load", "--no-dead-time", "--no-load", "--no-noise",
    "--no-box",
)  # fmt: skip
"""Options of the whole requirement."""


def command(
    axis: AxisOption = Axis.flexion,
    plant: PlantOption = None,
    cost: Annotated[
        str, typer.Option(help="What is minimised: iae, itae or settling_time.", autocompletion=costs)
    ] = "iae",
    two_dof: Annotated[
        bool,
        typer.Option("--two-dof", help="Tune a reference weight b and a filter Tf of the angle, too."),
    ] = False,
    nominal: Annotated[
        bool,
        typer.Option(
            "--nominal", help="Only the nominal plant from rest, without the delay margin; not robust."
        ),
    ] = False,
    plain: Annotated[
        bool,
        typer.Option(
            "--plain",
            help="Only steps from every initial state on the plant and its corners: no dead time, no search.",
        ),
    ] = False,
    no_dead_time: Annotated[
        bool, typer.Option("--no-dead-time", help="No dead time but the plant's own.")
    ] = False,
    no_load: Annotated[bool, typer.Option("--no-load", help="No load.")] = False,
    no_noise: Annotated[
        bool, typer.Option("--no-noise", help="No sensor noise and no quantisation.")
    ] = False,
    no_box: Annotated[
        bool, typer.Option("--no-box", help="No uncertainty of the plant's parameters.")
    ] = False,
    overshoot: Annotated[
        float | None,
        typer.Option(help="Limit on the simulated overshoot [%]; by default the rig's.", min=0.0),
    ] = None,
    ms: Annotated[
        float | None, typer.Option(help="Limit on the sensitivity peak Ms on every branch.", min=1.0)
    ] = None,
    delay_margin: Annotated[float | None, typer.Option(help="Least delay margin [s].", min=0.0)] = None,
    variation: Annotated[
        float | None, typer.Option(help="Limit on the total variation of the command in a step.", min=0.0)
    ] = None,
    steady_error: Annotated[
        float | None,
        typer.Option(help="Limit on the error at the end of the run [% of the step].", min=0.0),
    ] = None,
    corners: Annotated[
        str | None, typer.Option(help="Relative deviations of loop width, slopes and lag at the corners.")
    ] = None,
    points: Annotated[int, typer.Option(help="Points of the map in each gain.", min=5, max=400)] = 40,
    starts: Annotated[
        int, typer.Option(help="Local searches; 3 under the whole requirement.", min=1, max=100)
    ] = 5,
    robust: Annotated[bool, typer.Option("--robust", help="The default now.", hidden=True)] = False,
    rounds: Annotated[
        int, typer.Option(help="Maximum number of rounds of tuning and search.", min=1, max=50)
    ] = 15,
    dead_time: Annotated[
        float | None,
        typer.Option(help="Longest dead time [s], the plant's own included; by default the rig's.", min=0.0),
    ] = None,
    load: Annotated[
        float | None,
        typer.Option(
            help="Load, as a shift of the static angle of either sign [deg]; by default the rig's.", min=0.0
        ),
    ] = None,
    seed: SeedOption = 0,
    json: JsonOption = None,
    out: OutOption = None,
    jobs: JobsOption = None,
    scheduler: SchedulerOption = None,
) -> None:
    from design.evaluation.scenarios import Spread
    from design.synthesis.answer import answer
    from design.synthesis.designed_plant import designed
    from design.synthesis.requirements import COSTS, Limits, default_problem
    from design.synthesis.tuning import Region, tune
    from plants.errors import InputError
    from plants.wrist import Wrist
    from reports.shared.tuning import tuning_record

    check_places({"--json": json}, out)
    if nominal or plain:
        refuse(WHOLE, "belongs to the whole requirement, and not to --nominal or --plain")
    else:
        refuse(("--scheduler",), "belongs to --plain and --nominal")
    if nominal:
        refuse(("--delay-margin",), "--nominal asks for no delay margin")
        refuse(("--corners",), "--nominal asks for the nominal plant alone")
    if no_dead_time:
        refuse(("--dead-time",), "--no-dead-time asks for none")
    if no_load:
        refuse(("--load",), "--no-load asks for none")
    if cost not in COSTS:
        raise InputError(f"--cost: unknown cost {cost!r}; one of {', '.join(COSTS)}")
    whole = parameter_set(axis, plant)
    chosen = designed(whole)
    spread = (
        Spread.of(chosen.rig) if corners is None else Spread(*numbers(corners, "--corners", "0.2,0.1,0.2"))
    )
    if max(vars(spread).values()) >= 1.0:
        raise InputError(f"--corners: {corners!r} must be shares below 1")
    given = {
        "overshoot_percent": overshoot, "Ms": ms, "delay_margin_s": delay_margin,
        "total_variation_V": variation, "steady_error_percent": steady_error,
    }  # fmt: skip
    limits = replace(Limits.of(chosen.rig), **{n: v for n, v in given.items() if v is not None})
    limits = replace(limits, delay_margin_s=None) if nominal else limits
    region = Region.of(Wrist.of(chosen), points)
    said = console(json)
    say_left_out(said, whole)
    record: dict[str, Any] = {}
    if nominal or plain:
        problem = default_problem(Wrist.of(chosen), limits, cost, nominal, jobs, spread)
        with progress("tune") as tell:
            found = tune(problem, region, starts, seed, tell, scheduler)
    else:
        from design.robustness.tuning.robust_tuning import tune_robustly
        from design.synthesis.structure import TWO_DOF_PI
        from reports.robustness import tuning as robust_words

        asked = _requirement(
            chosen, limits, spread, cost, 0.0 if no_dead_time else dead_time, 0.0 if no_load else load,
            no_noise, no_box,
        )  # fmt: skip
        with progress("tune") as tell:
            grown = tune_robustly(
                asked, region, starts if in_line("--starts") else 3, seed, rounds, jobs, tell
            )
            if two_dof and grown.ended != "out of reach":
                grown = tune_robustly(
                    asked, region, 1, seed, rounds, jobs, tell, TWO_DOF_PI, base=grown.final
                )
        found = grown.final
        for line in robust_words.lines(grown):
            said.print(line)
        record = {"robust": robust_words.record(grown)}
    answered = answer(found)
    for line in lines(answered):
        said.print(line)
    if out is not None:
        from plants.files import file_name
        from reports.shared.figures.gain_map import gain_map
        from reports.shared.figures.style import save

        path = out / f"tune-{file_name(chosen.axis)}.png"
        save(gain_map(found), path)
        said.print(f"map of the gains in {path}", soft_wrap=True)
    if answered.refusal is None:
        more = ["--plant", plant] if plant else ["--axis", chosen.axis]
        own = [v for v in (found.gains["b"], found.gains["Tf"]) if two_dof]
        gains = ",".join(f"{v:.4g}" for v in (found.Kp, found.Ki, *own))
        following(said, "wrist", "robust", "--gains", gains, *more)
    write_json(json, tuning_record(answered, chosen.axis) | record)
    if answered.refusal is not None or (record and not record["robust"]["holds"]):
        raise typer.Exit(1)


def _requirement(
    plant: "ParameterSet",
    limits: "Limits",
    spread: Any,
    cost: str,
    dead_time: float | None,
    load: float | None,
    no_noise: bool,
    no_box: bool,
) -> "Requirement":
    """The requirement of the rig, as changed by the options."""
    from design.robustness.box import Box
    from design.robustness.requirement import requirement
    from design.robustness.samples.conditions import Conditions

    check_dead_time(plant, dead_time)
    own = Conditions.of(plant.rig)
    conditions = Conditions(
        own.dead_time if dead_time is None else dead_time,
        own.load if load is None else load,
        *((0.0, 0.0) if no_noise else (own.noise, own.quantum)),
    )
    found = requirement(plant, limits, conditions, spread, cost=cost)
    return replace(found, box=Box(plant, ()).leaving(found.box.remainder)) if no_box else found


def lines(answered: "Answer") -> list[str]:
    """What people read of a tuning."""
    from design.evaluation.scenarios import HEADROOM
    from reports.shared.tuning import gains_line, refused

    if answered.refusal is not None:
        return [refused(answered.refusal)]
    found, metrics = answered.tuning, answered.nominal
    problem, at, region = found.problem, found.at, found.region
    near = sum(s.feasible and s.cost <= 1.01 * float(at.cost[0]) for s in found.searches)
    apart = " and ".join(f"{100 * (r - 1):.0f} %" for r in region.resolution)
    cases = f" and {len(problem.adverse)} cases of the requirement" if problem.adverse else ""
    said = [
        gains_line(found),
        f"worst {COST_TEXT[problem.cost].format(at.cost[0])} over {len(problem.scenarios)} scenarios"
        f"{cases}, on {problem.place('cost', int(at.cost_at[0]))}",
        f"nominal step of {problem.wrist.rig.task.step:+g} deg: settles in "
        f"{seconds(metrics['settling_time_s'], problem.lanes.duration)}, "
        f"overshoot {metrics['overshoot_percent']:.2g} %, IAE {metrics['iae_deg_s']:.4g} deg s",
        f"worst overshoot {at.values['overshoot_percent'][0]:.3g} %, Ms {at.values['Ms'][0]:.3g}, "
        f"delay margin {1000 * at.values['delay_margin_s'][0]:.0f} ms, "
        f"total variation of the command {at.values['total_variation_V'][0]:.3g} V",
        "active limit: "
        + (
            f"{found.active}, on {problem.place(found.active, int(at.values_at[found.active][0]))}"
            if found.active
            else "none; the optimum lies inside all limits"
        ),
        f"map of {region.points} x {region.points} gains in steps of {apart} (Kp and Ki), "
        f"{found.map.feasible.sum()} within the limits; {near} of {len(found.searches)} local searches ended "
        "within 1 % of the result" + (", the others at higher costs" if near < len(found.searches) else ""),
    ]
    if problem.set_aside:
        said.append(
            f"{len(problem.set_aside)} scenarios set aside, since the command that holds them lies within "
            f"{HEADROOM:g} V of the end of the range or beyond, such as {problem.set_aside[0].name}"
        )
    if found.on_edge:
        said.append("the optimum lies on the edge of the searched gains, so it may go on outside")
    return said
