"""``wrist check``: a log of the rig under its exported controller, held against its design."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from design.cli.common import JobsOption, JsonOption, OutOption, SeedOption, command_line, shown, write_json
from design.cli.completion import files
from design.cli.design_folder import motions, plant_file, recommended
from design.cli.places import check_places
from design.cli.terminal.screen import console, progress

if TYPE_CHECKING:
    from plants.measured.campaigns.recording import Recording
    from plants.parameters.quantities import ParameterSet

NAME = "check"
HELP = (
    "Compare a log of the closed loop with its design: whether it is inside the envelope of the samples, "
    "which "
    "metric departs first, and whether the plant has changed since the trace. Exit code 1 if the log is "
    "outside."
)
EXAMPLE = "Example: wrist check plants/measured/examples/flexion/task.csv --design build/design"
NEXT = "wrist trace CAMPAIGN, where it is changed or broken"


def command(
    log: Annotated[
        Path,
        typer.Argument(
            help="Recording of the closed loop, with reference_deg and angle_deg.", autocompletion=files
        ),
    ],
    design: Annotated[
        Path, typer.Option("--design", help="Folder that `wrist design` wrote.", autocompletion=files)
    ],
    motion: Annotated[
        str | None, typer.Option(help="Motion of the log, where the design has several.")
    ] = None,
    samples: Annotated[int, typer.Option(help="Samples of the envelope.", min=50, max=5000)] = 200,
    seed: SeedOption = 0,
    json: JsonOption = None,
    out: OutOption = None,
    jobs: JobsOption = None,
) -> None:
    from design.studies.check.check import check_log
    from reports.check.page import write_check
    from reports.check.record import check_record
    from reports.check.words import title
    from reports.shared.html import Made

    check_places({"--json": json}, out)
    plant = _plant(design, motion)
    recording = _recording(log, plant)
    controller = recommended(design, plant)
    with progress("check"):
        found = check_log(recording, plant, controller, samples, seed, jobs)
    said = console(json)
    if out is not None:
        made = Made.now(command=command_line(), seed=seed, sets={plant.axis: plant})
        said.print(f"page in {write_check(out, found, made)}", soft_wrap=True)
    write_json(json, check_record(found))
    said.print(title(found), soft_wrap=True)
    if not found.kept:
        raise typer.Exit(1)


def _recording(log: Path, plant: "ParameterSet") -> "Recording":
    """The recording of a log, as the rig of a plant counts.  Raises InputError as ``from_table``, and for a
    log without a campaign whose columns have names of their own."""
    from plants.errors import InputError
    from plants.measured.campaigns.draft import importing
    from plants.measured.campaigns.read_table import from_table, required
    from plants.measured.formats.columns import parse_columns
    from plants.measured.formats.tables import read_table

    columns, table = _columns(log), read_table(log)
    lacks = [name for name in required("wrist") if name not in table.columns]
    if columns is None and lacks:
        command = importing(shlex.quote(str(log)), plant.axis)
        raise InputError(
            f"{log}: no column {lacks[0]!r}; it needs converting: {command}, then check the log in NEW"
        )
    return from_table(table, parse_columns(columns, str(log)), rig=plant.rig)


def _columns(log: Path) -> Any:
    """The ``[columns]`` of the campaign that a log lies in; None where it lies in none."""
    from plants.measured.campaigns.campaign import FILE
    from plants.toml import read_toml

    declared = log.parent / FILE
    return read_toml(declared, "campaign", FILE).get("columns") if declared.exists() else None


def _plant(folder: Path, motion: str | None) -> "ParameterSet":
    """The plant of a motion of a design."""
    from plants.errors import InputError
    from plants.parameters.files import load

    known = motions(folder)
    if motion is None and len(known) > 1:
        raise InputError(f"--motion: {folder} has {', '.join(known)}; say which one the log is of")
    chosen = known[0] if motion is None else motion
    if chosen not in known:
        raise InputError(f"--motion: {folder} has no {chosen!r}; it has {', '.join(known)}")
    return shown(load(plant_file(folder, chosen)))
