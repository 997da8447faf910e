"""``wrist fit``: parameters from a measured campaign."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from design.cli.common import (
    CampaignArgument,
    JsonOption,
    OutOption,
    SeedOption,
    StartOption,
    console,
    progress,
    starting_set,
    write_json,
)

if TYPE_CHECKING:
    from plants.measured.fit import Fit

NAME = "fit"
HELP = "Fit the wrist to a measured campaign, and report the error on recordings that took no part."
EXAMPLE = "Example: wrist fit plants/measured/examples/flexion --save build/fitted.toml"


def command(
    campaign: CampaignArgument,
    plant: StartOption = None,
    save: Annotated[
        Path | None, typer.Option(help="Write the fitted set as TOML, for the other commands.")
    ] = None,
    starts: Annotated[int, typer.Option(help="Starting points of each stage.", min=1)] = 6,
    seed: SeedOption = 0,
    json: JsonOption = None,
    out: OutOption = None,
) -> None:
    from plants.measured.campaign import load_campaign
    from plants.measured.fit import fit_campaign
    from plants.quantities import dump
    from reports.records import fit_record

    data = load_campaign(campaign)
    with progress(f"fit {data.name}") as tell:
        fitted = fit_campaign(data, starting_set(data, plant), starts, seed, tell)
    said = console(json)
    for part in tables(fitted):
        said.print(part)
    if save is not None:
        dump(fitted.fitted, save)
        said.print(f"fitted set in {save}")
    if out is not None:
        from reports.fitted import draw_fit
        from reports.style import save as save_figure

        path = out / f"fit-{data.name}.png"
        save_figure(draw_fit(fitted), path)
        said.print(f"picture in {path}")
    write_json(json, fit_record(fitted))


def tables(fit: "Fit") -> list[Any]:
    """What people read of a fit: parameters, errors, how the search went."""
    from rich.table import Table

    from plants.quantities import Fitted

    first = Table(box=None, pad_edge=False)
    for heading in ("name", "before", "fitted", "s.e.", "unit"):
        first.add_column(heading, justify="left" if heading in ("name", "unit") else "right")
    for name, p in fit.fitted.parameters.items():
        if not isinstance(p.provenance, Fitted):
            continue
        error = "-" if p.provenance.std_error is None else f"{p.provenance.std_error:.2g}"
        mark = " (at bound)" if name in fit.at_bounds else ""
        first.add_row(name, f"{fit.before.parameters[name].value:.5g}", f"{p.value:.5g}{mark}", error, p.unit)
    second = Table(box=None, pad_edge=False)
    for heading in ("channel", "before", "validate", "fit", "noise", "validate / noise"):
        second.add_column(heading, justify="left" if heading == "channel" else "right")
    for channel, unit in (("angle_deg", "deg"), ("pressure_kPa", "kPa")):
        noise, after = fit.noise[channel], fit.validate_rmse[channel]
        if noise is None or after is None:
            continue
        before, on_fit = fit.validate_rmse_before[channel], fit.fit_rmse[channel]
        texts = ["-" if v is None else f"{v:.4g} {unit}" for v in (before, after, on_fit, noise)]
        second.add_row(channel.split("_")[0], *texts, f"{after / noise:.2f}" if noise else "-")
    lines: list[Any] = [fit.fitted.title, first, "", "rms error of free runs from the command", second, ""]
    for stage, found in fit.stages.items():
        lines.append(
            f"{stage} stage: {found.agreeing} of {len(found.costs)} starts ended at the same minimum"
        )
    lines += fit.remarks
    return lines
