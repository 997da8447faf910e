"""``wrist plan``: the recording to make next."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from design.cli.common import (
    CampaignArgument,
    JsonOption,
    SeedOption,
    StartOption,
    given_set,
    rig_of,
    write_json,
)
from design.cli.completion import files
from design.cli.places import check_places
from design.cli.terminal.screen import console, progress

if TYPE_CHECKING:
    from plants.measured.trace.plan import PlannedRecording

NAME = "plan"
HELP = (
    "Trace a campaign and write the command of the most informative next recording: it distinguishes "
    "effects that fit equally well, or else reduces the standard errors; with a picture."
)
EXAMPLE = "Example: wrist plan plants/measured/examples/deviation --out build/plan.csv"
NEXT = "wrist trace CAMPAIGN, with the recording added"


def command(
    campaign: CampaignArgument,
    out: Annotated[
        Path,
        typer.Option(
            "--out", help="CSV file for time and command; a picture beside it.", autocompletion=files
        ),
    ] = Path("plan.csv"),
    duration: Annotated[float, typer.Option(help="Length of the recording [s].", min=10.0, max=600.0)] = 60.0,
    plant: StartOption = None,
    tried: Annotated[int, typer.Option(help="Random commands to try.", min=4, max=1000)] = 24,
    seed: SeedOption = 0,
    json: JsonOption = None,
) -> None:
    from plants.files import write_atomically
    from plants.measured.campaigns.campaign import load_campaign
    from plants.measured.trace.plan import plan, rival, rivals_of
    from plants.measured.trace.trace import trace_campaign
    from reports.shared.figures.style import save
    from reports.trace.plan import draw_plan, plan_lines, plan_record, plan_table

    check_places({"--out": out, "--json": json})
    data = load_campaign(campaign, rig_of(plant))
    with progress(f"plan {data.name}") as tell:
        trace = trace_campaign(data, given_set(plant), seed, tell)
        own = [rival(s.model, s.model, s.name, s.name) for s in trace.stages]
        found: PlannedRecording = plan(rivals_of(trace), own, duration, seed, tried)
    write_atomically(out, plan_table(found))
    picture = out.with_suffix(".png")
    save(draw_plan(found), picture)
    said = console(json)
    for line in plan_lines(found):
        said.print(line, soft_wrap=True)
    said.print(f"command in {out}, picture in {picture}", soft_wrap=True)
    write_json(json, plan_record(found, data.axis))
