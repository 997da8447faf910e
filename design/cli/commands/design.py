"""``wrist design``: from campaigns to recommended controllers, in one command."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from design.cli.common import (
    JobsOption,
    JsonOption,
    SeedOption,
    command_line,
    following,
    shown,
    write_json,
)
from design.cli.completion import files
from design.cli.places import check_places
from design.cli.terminal.screen import console, progress

if TYPE_CHECKING:
    from design.studies.design_study import MotionDesign
    from plants.measured.campaigns.campaign import Campaign
    from plants.parameters.quantities import ParameterSet

NAME = "design"
HELP = (
    "Design for measured rigs, complete: fit, trace, tune under the whole requirement, check on fresh "
    "samples, "
    "search for the worst case, prove stability, state the cost of each guarantee, export C; one page, one "
    "JSON. Resumes after Ctrl-C."
)
EXAMPLE = "Example: wrist design plants/measured/examples/flexion --out build/design"
NEXT = "make -C OUT/c-MOTION check"


def command(
    campaigns: Annotated[
        list[Path],
        typer.Argument(
            help="Folders with campaign.toml and the recordings, one a motion.", autocompletion=files
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            "--out", help="Folder for page, plants, gains, C and finished stages.", autocompletion=files
        ),
    ] = Path("build/design"),
    plant: Annotated[
        list[Path] | None,
        typer.Option(help="Parameter set that a motion's fit starts from.", autocompletion=files),
    ] = None,
    no_dead_time: Annotated[
        bool, typer.Option("--no-dead-time", help="No dead time in addition to the plant's own.")
    ] = False,
    no_load: Annotated[bool, typer.Option("--no-load", help="No load.")] = False,
    no_noise: Annotated[bool, typer.Option("--no-noise", help="No sensor noise.")] = False,
    no_remainder: Annotated[
        bool, typer.Option("--no-remainder", help="Ignore the unexplained residual of the plant.")
    ] = False,
    nominal: Annotated[
        bool, typer.Option("--nominal", help="No uncertainty of the plant's parameters.")
    ] = False,
    samples: Annotated[int, typer.Option(help="Fresh samples.", min=100)] = 20_000,
    budget: Annotated[int, typer.Option(help="Runs of the worst-case search.", min=1000)] = 50_000,
    points: Annotated[int, typer.Option(help="Points of the map in each gain.", min=5, max=400)] = 40,
    mpc: Annotated[
        bool,
        typer.Option("--mpc", help="Also tune an MPC under the requirement; a quarter of an hour a motion."),
    ] = False,
    no_alternatives: Annotated[
        bool,
        typer.Option(
            "--no-alternatives", help="Only PI controllers: no feedforward, cascade or LQI; half the time."
        ),
    ] = False,
    seed: SeedOption = 0,
    json: JsonOption = None,
    jobs: JobsOption = None,
) -> None:
    from design.alternatives.designs import ROBUST_MPC
    from design.studies.design_study import Taken, design_study
    from design.studies.designs import DesignEffort
    from reports.design.page import write_design
    from reports.design.record import design_record
    from reports.design.words import last_line, motion_lines
    from reports.shared.html import Made

    check_places({"--json": json}, out)
    said = console(json)
    given = _campaigns(campaigns, plant or [])
    taken = Taken(no_dead_time, no_load, no_noise, nominal, no_remainder)
    effort = DesignEffort(samples, budget, points, mpc=mpc, alternatives=not no_alternatives)
    out.mkdir(parents=True, exist_ok=True)
    with progress("design") as tell:
        study = design_study(given, out, effort, taken, seed, jobs, tell)
    shown(study.motions[0].plant)  # a rig that was guessed from its log has the log's units
    for motion in study.motions:
        _write_gains(out, motion)
        _export(out, motion)
        for line in motion_lines(motion):
            said.print(line)
    made = Made.now(
        command=command_line(), seed=seed, sets={m.motion: m.plant for m in study.motions},
        data={data.name: data.checksum for data, _ in given.values()},
    )  # fmt: skip
    with progress("page"):
        page = write_design(out, study, made)
    said.print(f"page in {page}", soft_wrap=True)
    write_json(json, design_record(study))
    said.print(last_line(study), soft_wrap=True)
    for motion in study.motions:
        following(said, "make", "-C", out / f"c-{motion.motion}", "check")
        if ROBUST_MPC in motion.designs:
            following(said, *_exporting(out, motion.motion))
    if not study.holds:
        raise typer.Exit(1)


def _campaigns(folders: list[Path], files_: list[Path]) -> "dict[str, tuple[Campaign, ParameterSet | None]]":
    """Campaigns by motion, each with the set that its fit starts from; all are read before any is fitted."""
    from plants.errors import InputError
    from plants.measured.campaigns.campaign import load_campaign
    from plants.parameters.files import load

    sets = {s.axis: s for s in (load(path) for path in files_)}
    found: dict[str, tuple[Campaign, ParameterSet | None]] = {}
    for folder in folders:
        data = load_campaign(folder, next((s.rig for s in sets.values()), None))
        if data.stage == "regulator":
            raise InputError(f"{folder}: has no angle; a design needs a campaign of the whole wrist")
        if data.axis in found:
            raise InputError(f"{folder}: {data.axis!r} was given before; give one campaign a motion")
        found[data.axis] = (data, sets.get(data.axis))
    first = next((start for _, start in found.values() if start is not None), None)
    if first is not None:
        shown(first)
    return found


def _write_gains(out: Path, motion: "MotionDesign") -> None:
    """The recommended gains as gains-MOTION.toml, and of an MPC that was tuned mpc-MOTION.toml, in place of
    those of a run before."""
    from design.alternatives.designs import ROBUST_MPC
    from design.tuner.gains_file import write, write_mpc

    path = (out / f"gains-{motion.motion}.toml").absolute()
    plant = f"plant-{motion.motion}.toml"
    about: dict[str, object] = {"plant": plant, "holds": motion.holds}
    if not motion.holds:
        about["limits_broken"] = list(motion.limits_broken)
    write(path, motion.gains, about, (path,), motion.plant.rig)
    mpc = motion.designs.get(ROBUST_MPC)
    if mpc is not None:
        about = {"plant": plant, "holds": mpc["holds"]}
        write_mpc(path.with_name(f"mpc-{motion.motion}.toml"), mpc["gains"], about, motion.plant.rig)


def _exporting(out: Path, motion: str) -> tuple[str | Path, ...]:
    """The command that exports the MPC that was tuned."""
    gains, plant = out / f"mpc-{motion}.toml", out / f"plant-{motion}.toml"
    words = ("wrist", "export", "mpc-real-time-robust", "--gains", gains, "--plant", plant)
    return (*words, "--out", out / f"c-mpc-{motion}")


def _export(out: Path, motion: "MotionDesign") -> None:
    """The recommended controller as C in c-MOTION, or the nearest, which is called so."""

    from design.controllers.measurement.plausible import SensorLimits
    from design.controllers.pi_two_dof import TwoDofPI
    from design.export.catalogue import STANDS_STILL, identifier, noted
    from design.export.formats.folder import write
    from design.export.parts_of import of_controller
    from plants.wrist import Wrist
    from reports.shared.names import broken_gains

    wrist, controller = Wrist.of(motion.plant), motion.controller
    kind = "pi_two_dof" if isinstance(controller, TwoDofPI) else "pi"
    what = f"{motion.recommended} controller with anti-windup"
    title = (
        f"{what}, recommended for {motion.motion}"
        if motion.holds
        else f"{what} for {motion.motion}, {broken_gains(motion.limits_broken)}; see design.html"
    )
    part = of_controller(
        identifier(f"{motion.motion}_{kind}"),
        title,
        controller,
        SensorLimits.of(wrist),
        wrist.rig.sample_time,
    )
    write(noted(part, wrist, STANDS_STILL), wrist, out / f"c-{motion.motion}")
