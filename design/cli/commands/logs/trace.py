"""``wrist trace``: from a measured campaign to what the declared wrist lacks, and the revised plant; of two
campaigns of one rig, what changed between them."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from design.cli.common import (
    CampaignArgument,
    JobsOption,
    JsonOption,
    SeedOption,
    StartOption,
    command_line,
    following,
    given_set,
    rig_of,
    write_json,
)
from design.cli.completion import files
from design.cli.places import check_places
from design.cli.terminal.screen import Sheet, console, progress

if TYPE_CHECKING:
    from design.studies.check.campaigns import CampaignChange
    from design.synthesis.retune import Control
    from plants.measured.campaigns.campaign import Campaign
    from plants.measured.trace.result import Named, Trace
    from reports.shared.html import Made

NAME = "trace"
HELP = (
    "Find the effect that the model lacks on a measured rig, its size, and the revised plant. With two "
    "campaigns of one rig: find which parameters and effects changed."
)
EXAMPLE = "Example: wrist trace plants/measured/examples/flexion --out build/trace --save build/revised.toml"
NEXT = "wrist design CAMPAIGN, or wrist tune --plant FILE"


def command(
    campaign: CampaignArgument,
    new: Annotated[
        Path | None,
        typer.Argument(help="Folder of a later campaign of the same rig.", autocompletion=files),
    ] = None,
    plant: StartOption = None,
    save: Annotated[
        Path | None,
        typer.Option(
            help="Write the revised plant as TOML, for the other commands' --plant.", autocompletion=files
        ),
    ] = None,
    learn: Annotated[
        bool,
        typer.Option(
            "--learn",
            help="Learn what no effect explains of the angle; added where the error on held-out rows falls.",
        ),
    ] = False,
    retune: Annotated[
        bool,
        typer.Option(
            "--retune", help="Tune the PI on the declared and on the revised plant, and compare the two."
        ),
    ] = False,
    seed: SeedOption = 0,
    json: JsonOption = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", help="Folder for the page, its pictures, JSON and TOML.", autocompletion=files),
    ] = None,
    jobs: JobsOption = None,
) -> None:
    from plants.measured.campaigns.campaign import load_campaign
    from plants.measured.trace.trace import trace_campaign
    from plants.parameters.files import dump
    from reports.trace.control_words import control_sentence
    from reports.trace.record import control_record, trace_record

    check_places({"--save": save, "--json": json}, out)
    data = load_campaign(campaign, rig_of(plant))
    of_one = {"--save": save, "--retune": retune, "--learn": learn}
    later = None if new is None else _later(data, new, plant, of_one)
    start = given_set(plant)
    with progress(f"trace {data.name}") as tell:
        trace = trace_campaign(data, start, seed, tell, learn)
    if new is not None and later is not None:
        _tell_change(trace, later, new, seed, json, out)
        return
    control = _retuned(trace, seed, jobs) if retune else None
    said = console(json)
    for part in lines(trace):
        said.print(part)
    if retune:
        said.print(f"\n{control_sentence(control)}")
    if save is not None:
        dump(trace.revised, save)
        said.print(f"plant in {save}", soft_wrap=True)
    if out is not None:
        said.print(f"page in {_write_page(out, trace, control, seed)}", soft_wrap=True)
    following(said, "wrist", *_next(trace, campaign, save))
    write_json(json, trace_record(trace, control_record(control) if retune else None))


def _next(trace: "Trace", campaign: Path, save: Path | None) -> tuple[str | Path, ...]:
    """The command that makes gains of what was found: tasks go either way from zero, which a rig that bends
    to one side does only as `wrist design` counts its angle.  Of a revised plant that is worse than the
    declared one, the command that saves that one."""
    from design.synthesis.answer import bends_to_one_side
    from plants.wrist import Wrist

    if trace.worse:
        return ("fit", campaign, "--save", "declared.toml")
    aside = trace.campaign.stage == "wrist" and bends_to_one_side(Wrist.of(trace.revised))
    return ("design", campaign) if save is None or aside else ("tune", "--plant", save)


def _retuned(trace: "Trace", seed: int, jobs: int | None) -> "Control | None":
    """Both PIs; None where the campaign has no angle, and so no loop to tune."""
    from design.synthesis.retune import retune

    if trace.campaign.stage != "wrist":
        return None
    with progress("retune") as tell:
        return retune(trace.fit.fitted, trace.revised, seed=seed, jobs=jobs, progress=tell)


def _later(old: "Campaign", new: Path, plant: Path | None, of_one: Mapping[str, object]) -> "Campaign":
    """The later of two campaigns; InputError where they cannot be compared, or options are of one alone."""
    from plants.errors import InputError
    from plants.measured.campaigns.campaign import load_campaign
    from plants.measured.trace.change.refit import check_comparable

    for option, asked in of_one.items():
        if asked:
            raise InputError(f"{option}: is of one campaign; run `wrist trace {new} {option}` beside")
    later = load_campaign(new, rig_of(plant))
    check_comparable(old, later)
    return later


def _tell_change(
    trace: "Trace", later: "Campaign", new: Path, seed: int, json: Path | None, out: Path | None
) -> None:
    """What changed between the campaign of a trace and a later one: in words, as JSON, on a page."""
    from design.studies.check.campaigns import campaign_change
    from reports.trace.change.page import write_change
    from reports.trace.change.record import change_record
    from reports.trace.change.words import interval_words, remarks, title

    with progress(f"compare with {later.name}") as tell:
        change = campaign_change(trace, later, seed, tell)
    said = console(json)
    came = ("", "came:", _effects(change.came)) if change.came else ()
    differences = (interval_words(change.parameters), _differences(change))
    for part in (title(change), "", *differences, *came, "", *remarks(change)):
        said.print(part)
    if out is not None:
        with progress("page"):
            page = write_change(out, change, _made(trace, seed, {f"{later.name}, new": later.checksum}))
        said.print(f"page in {page}", soft_wrap=True)
    if change.changed:
        following(said, "wrist", "design", new)
    write_json(json, change_record(change))


def _differences(change: "CampaignChange") -> Sheet:
    from reports.trace.change.words import difference

    rows = [
        (p.name, f"{p.old:.4g}", f"{p.new:.4g}", difference(p), p.unit, "yes" if p.differs else "-")
        for p in change.parameters
    ]
    headings = ("parameter", "old", "new", "difference", "unit", "differs")
    return Sheet(headings, tuple(rows), words=(0, 4, 5))


def _made(trace: "Trace", seed: int, more: dict[str, str] | None = None) -> "Made":
    """What made a page of a trace; more: checksums of further campaigns by name."""
    from reports.shared.html import Made

    data = {trace.campaign.name: trace.campaign.checksum} | (more or {})
    return Made.now(command=command_line(), seed=seed, sets={trace.campaign.axis: trace.revised}, data=data)


def _write_page(out: Path, trace: "Trace", control: "Control | None", seed: int) -> Path:
    from reports.trace.page import write_trace

    with progress("page"):
        return write_trace(out, trace, _made(trace, seed), control)


def lines(trace: "Trace") -> list[Any]:
    """What people read of a trace: the verdict first, then errors, effects, and what is open."""
    from reports.trace.residual_words import description
    from reports.trace.words import block_words, log_words, verdict_sentence

    said: list[Any] = [verdict_sentence(trace), ""]
    said += ["RMS error of open-loop simulations, on the held-out recordings", _errors(trace)]
    if trace.effects:
        said += ["", _effects(trace.effects)]
    words = [w for e in trace.effects for w in e.separations]
    words += [
        description(s.description, s.stage.channel) for s in trace.unexplained if s.description is not None
    ]
    if trace.cannot_judge:
        words.append("These recordings cannot decide:")
        words += [f"  {name}: {why}" for name, why in trace.cannot_judge.items()]
    words += block_words(trace) + log_words(trace)
    return said + (["", *words] if words else [])


def _errors(trace: "Trace") -> Sheet:
    rows = []
    for channel, unit in (("angle_deg", "deg"), ("pressure_kPa", "kPa")):
        before, after, noise = (x.get(channel) for x in (trace.before, trace.after, trace.noise))
        if before is None or after is None:
            continue
        texts = ("-" if v is None else f"{v:.4g}" for v in (before, after, noise))
        rows.append((channel.split("_")[0], unit, *texts, f"{after / noise:.2f}" if noise else "-"))
    headings = ("channel", "unit", "before", "after", "noise", "after / noise")
    return Sheet(headings, tuple(rows), words=(0, 1))


def _effects(effects: "Sequence[Named]") -> Sheet:
    rows = []
    for effect in effects:
        first = (f"{effect.name}, {effect.form}", ", ".join(effect.alternatives) or "-")
        for name, (value, unit, error) in effect.parameters.items():
            shown_error = "-" if error is None else f"{error:.2g}"
            rows.append((first[0], name, f"{value:.4g}", shown_error, unit, first[1]))
            first = ("", "")
    headings = ("effect", "parameter", "value", "s.e.", "unit", "or else")
    return Sheet(headings, tuple(rows), words=(0, 1, 4, 5))
