"""``wrist import``: a campaign from the logs of any recorder."""

import re
from pathlib import Path
from typing import Annotated

import typer

from design.cli.common import JsonOption, write_json
from design.cli.completion import files
from design.cli.places import check_places
from design.cli.terminal.screen import console

NAME = "import"
HELP = "Make a campaign from logs: MDF4, TDMS, MCAP, ROS bags, HDF5, MATLAB, Parquet and any kind of CSV."
EXAMPLE = 'Example: wrist import log.mf4 --map "angle=theta [rad]" --out my-rig'
NEXT = "wrist fit DIR"


def command(
    logs: Annotated[
        list[Path],
        typer.Argument(help="Logs of one rig; the folder of a ROS 2 bag is one.", autocompletion=files),
    ],
    out: Annotated[Path, typer.Option(help="New folder for the campaign.", autocompletion=files)],
    map_: Annotated[
        list[str] | None,
        typer.Option(
            "--map",
            help="command, pressure, angle or reference = channel, and its unit if the log does not say: "
            '"pressure=AI0 [bar]". What is not given is guessed.',
        ),
    ] = None,
    axis: Annotated[str, typer.Option(help="Name of the motion in campaign.toml.")] = "motion",
    sample_time: Annotated[
        float | None, typer.Option(help="Seconds between two rows, for logs without a time.", min=1e-6)
    ] = None,
    json: JsonOption = None,
) -> None:
    from plants.measured.importing.channels import listed
    from plants.measured.importing.importing import import_logs, write_campaign

    check_places({"--json": json}, out)
    made = import_logs(logs, dict(map(mapping, map_ or [])), sample_time)
    written = write_campaign(made, axis, out)
    said = console(json)
    for log in made.logs:
        said.print(f"{log.path}:", markup=False, soft_wrap=True)
        for c in listed(log.channels):
            line = (
                f"  {c['name']}  {c['unit'] or '-'}  {c['low']:.5g} to {c['high']:.5g}  {c['rate_Hz']:.4g} Hz"
            )
            said.print(line, markup=False, soft_wrap=True)
        for note in log.notes:
            said.print(f"  {note}", markup=False, soft_wrap=True)
    for role, found in made.roles.items():
        line = f"{role}: {found.channel} [{found.unit}], {found.why}"
        said.print(line, markup=False, soft_wrap=True)
    if made.unused:
        said.print(made.unused_words, markup=False, soft_wrap=True)
    said.print(f"{len(made.runs)} runs; {made.chosen.why}", markup=False, soft_wrap=True)
    said.print(f"read {written[-1]}, correct it, then: wrist fit {out}", markup=False, soft_wrap=True)
    write_json(
        json,
        {
            "logs": [
                {"file": str(x.path), "channels": listed(x.channels), "notes": x.notes} for x in made.logs
            ],
            "roles": {r: f._asdict() for r, f in made.roles.items()},
            "sample_time_s": made.step,
            "runs": [
                {"name": r.name, "ends": r.ends, **x._asdict()}
                for r, x in zip(made.runs, made.excitation, strict=True)
            ],
            "fit": [made.runs[i].name for i in made.chosen.fit],
            "validate": [made.runs[i].name for i in made.chosen.validate],
        },
    )


def mapping(text: str) -> tuple[str, tuple[str, str]]:
    """Role, channel and unit of an option.

    >>> mapping("pressure=AI0 [bar]"), mapping("command=u")
    (('pressure', ('AI0', 'bar')), ('command', ('u', '')))
    """
    from plants.errors import InputError
    from plants.measured.importing.roles import ROLES

    role, equals, rest = text.partition("=")
    found = re.fullmatch(r"\s*(.*?)\s*(?:\[([^\[\]]+)\])?\s*", rest)
    role = role.strip()
    if not equals or role not in ROLES or found is None or not found[1]:
        raise InputError(
            f"--map: {text!r} is not ROLE=CHANNEL or 'ROLE=CHANNEL [UNIT]'; roles are {', '.join(ROLES)}"
        )
    return role, (found[1], found[2] or "")
