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
    following,
    given_set,
    rig_of,
    write_json,
)
from design.cli.completion import files
from design.cli.places import check_places
from design.cli.terminal.screen import Sheet, console, progress

if TYPE_CHECKING:
    from plants.measured.fitting.fit import Fit
    from plants.measured.trace.rig_fit import RigFit

NAME = "fit"
HELP = "Fit the wrist to a measured campaign, and report the error on held-out recordings."
EXAMPLE = "Example: wrist fit plants/measured/examples/flexion --save build/fitted.toml"
NEXT = "wrist trace CAMPAIGN"


def command(
    campaign: CampaignArgument,
    plant: StartOption = None,
    save: Annotated[
        Path | None,
        typer.Option(help="Write the fitted set as TOML, for the other commands.", autocompletion=files),
    ] = None,
    starts: Annotated[
        int | None,
        typer.Option(
            help="Starting points of each stage: 6, or 1 where the fit starts from the log alone.", min=1
        ),
    ] = None,
    seed: SeedOption = 0,
    json: JsonOption = None,
    out: OutOption = None,
) -> None:
    from plants.measured.campaigns.campaign import load_campaign
    from plants.measured.trace.rig_fit import fit_rig
    from plants.parameters.files import dump
    from reports.shared.figures.fit import fit_record, start_record

    check_places({"--save": save, "--json": json}, out)
    data = load_campaign(campaign, rig_of(plant))
    with progress(f"fit {data.name}") as tell:
        found = fit_rig(data, given_set(plant), starts, seed, tell)
    fitted = found.fit
    said = console(json)
    for part in [*tables(fitted), *chosen(found)]:
        said.print(part)
    if save is not None:
        dump(fitted.fitted, save)
        said.print(f"fitted set in {save}", soft_wrap=True)
    if out is not None:
        from plants.files import file_name
        from reports.shared.figures.fit import draw_fit
        from reports.shared.figures.style import save as save_figure

        path = out / f"fit-{file_name(data.name)}.png"
        save_figure(draw_fit(fitted), path)
        said.print(f"picture in {path}", soft_wrap=True)
    following(said, "wrist", "trace", campaign)
    write_json(json, fit_record(fitted) | start_record(found))


def chosen(found: "RigFit") -> list[str]:
    """How the hysteresis law was chosen, and what the logger does; empty where there is nothing to say."""
    from reports.shared.figures.fit import law_sentence

    law = [law_sentence(found.law)] if found.law is not None else []
    return law + [f"Instrument: {r}" for r in found.start.instrument]


def tables(fit: "Fit") -> list[Any]:
    """What people read of a fit: parameters, errors, how the search went."""
    lines: list[Any] = [fit.fitted.title, _parameters(fit), ""]
    lines += ["RMS error of open-loop simulations", _errors(fit), ""]
    for stage, found in fit.stages.items():
        if len(found.costs) > 1:
            lines.append(
                f"{stage} stage: {found.agreeing} of {len(found.costs)} starts ended at the same minimum"
            )
    lines += fit.remarks
    return lines


def _parameters(fit: "Fit") -> Sheet:
    from plants.parameters.quantities import Fitted

    rows = []
    for name, p in fit.fitted.parameters.items():
        if not isinstance(p.provenance, Fitted):
            continue
        error = "-" if p.provenance.std_error is None else f"{p.provenance.std_error:.2g}"
        mark = " (at bound)" if name in fit.at_bounds else ""
        before = f"{fit.before.parameters[name].value:.5g}"
        rows.append((name, before, f"{p.value:.5g}{mark}", error, p.unit))
    return Sheet(("name", "before", "fitted", "s.e.", "unit"), tuple(rows), words=(0, 4))


def _errors(fit: "Fit") -> Sheet:
    rows = []
    for channel, unit in (("angle_deg", "deg"), ("pressure_kPa", "kPa")):
        noise, after = fit.noise[channel], fit.validate_rmse[channel]
        if noise is None or after is None:
            continue
        shown = (fit.validate_rmse_before[channel], after, fit.fit_rmse[channel], noise)
        texts = ("-" if v is None else f"{v:.4g}" for v in shown)
        rows.append((channel.split("_")[0], unit, *texts, f"{after / noise:.2f}" if noise else "-"))
    headings = ("channel", "unit", "before", "validate", "fit", "noise", "validate / noise")
    return Sheet(headings, tuple(rows), words=(0, 1))
