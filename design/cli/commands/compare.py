"""``wrist compare``: fit, tune, compare, report."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from design.cli.common import Axis, JobsOption, JsonOption, SeedOption, command_line, write_json
from design.cli.completion import files
from design.cli.places import check_places
from design.cli.terminal.screen import console, progress

if TYPE_CHECKING:
    from design.controllers.controller import Controller
    from plants.measured.fit import Fit
    from plants.parameters.quantities import ParameterSet

NAME = "compare"
HELP = "Compare the tuned PI with the paper's, the textbook rules and other designs; write a report."
EXAMPLE = "Example: wrist compare plants/measured/examples/flexion --out build/compare"


def command(
    campaigns: Annotated[
        list[Path] | None,
        typer.Argument(
            help="Campaigns to fit, one a motion; with no campaign and no plant, the paper's wrist.",
            autocompletion=files,
        ),
    ] = None,
    plant: Annotated[
        list[Path] | None,
        typer.Option(
            help="Parameter set of a motion: where its fit starts, or, without a campaign, the plant.",
            autocompletion=files,
        ),
    ] = None,
    example: Annotated[
        bool, typer.Option("--example", help="Use the campaigns that ship with the project (synthetic).")
    ] = False,
    out: Annotated[Path, typer.Option("--out", help="Folder for the report.", autocompletion=files)] = Path(
        "build/compare"
    ),
    json: JsonOption = None,
    points: Annotated[int, typer.Option(help="Points of the map in each gain.", min=5, max=400)] = 40,
    samples: Annotated[
        int, typer.Option(help="Perturbed plants of each motion, at least 10; 0 leaves them out.", min=0)
    ] = 50,
    mpc_plants: Annotated[
        int, typer.Option(help="Of these, plants that the MPCs meet too, which takes seconds each.", min=0)
    ] = 10,
    robust_gains: Annotated[
        list[str] | None,
        typer.Option(
            help="Gains Kp,Ki of a robust PI to compare as well; of one motion alone as flexion=Kp,Ki. "
            "May be given again."
        ),
    ] = None,
    seed: SeedOption = 0,
    jobs: JobsOption = None,
) -> None:
    from design.cli.commands.compare_tables import contest_table, table
    from design.contest.statistics import FEWEST
    from design.studies.study import Question, study
    from plants.errors import InputError
    from plants.wrist import Wrist
    from reports.comparison.contest_words import sentences
    from reports.comparison.page import write_comparison
    from reports.comparison.record import comparison_record
    from reports.comparison.verdict_words import verdict_sentences
    from reports.shared.html import Made
    from reports.shared.tuning import refused

    if 0 < samples < FEWEST:
        raise InputError(
            f"--samples {samples}: too few for an interval; give at least {FEWEST}, or 0 for none"
        )
    check_places({"--json": json}, out)
    said = console(json)
    folders = list(campaigns or []) + (example_campaigns() if example else [])
    fits, sets = _plants(folders, plant or [], seed, said)
    more = robust(robust_gains or [], {name: Wrist.of(s) for name, s in sets.items()})
    question = Question(sets, fits, points, samples, mpc_plants, more, seed, jobs)
    with progress("compare") as tell:
        found = study(question, tell)
    if found.without_mpc:
        said.print(f"MPCs are left out: {found.without_mpc}")
    for name, answer in found.answers.items():
        t = answer.tuning
        said.print(f"{name}: Kp = {t.Kp:.4g} kPa/deg, Ki = {t.Ki:.4g} kPa/(deg s)")
    for name, no in found.refusals.items():
        said.print(f"{name}: {refused(no)}")
    for line in table(found.comparison):
        said.print(line)
    if found.contest is not None:
        for line in [*contest_table(found.contest), *sentences(found.contest)]:
            said.print(line)
    for name in found.unperturbed:
        said.print(f"{name}: has effects of its own, so that no perturbed plants are drawn of it")
    made = Made.now(
        command=command_line(),
        seed=seed,
        sets=sets,
        data={f.campaign.name: f.campaign.checksum for f in fits.values()},
        remark="The example campaigns are synthetic: they come from a simulator, not from a rig."
        if example
        else "",
    )
    with progress("page"):
        written = write_comparison(out, found, made)
    for sentence in verdict_sentences(found):
        said.print(sentence)
    said.print(f"report in {written}", soft_wrap=True)
    write_json(json, comparison_record(found, made))
    if found.refusals:
        raise typer.Exit(1)


def example_campaigns() -> list[Path]:
    """Folders of the campaigns that ship with the project."""
    import plants.measured

    return sorted(
        p.parent for p in (Path(plants.measured.__file__).parent / "examples").glob("*/campaign.toml")
    )


def robust(gains: list[str], wrists: Any) -> "dict[str, dict[str, Controller]]":
    """The robust PI of each motion that gains were given for, ``Kp,Ki`` for all or ``motion=Kp,Ki``."""
    from design.cli.common import pi_gains
    from design.controllers.pi import PI
    from plants.errors import InputError

    found: dict[str, dict[str, Controller]] = {}
    for text in gains:
        motion, given, pair = text.rpartition("=")
        if given and motion not in wrists:
            raise InputError(f"--robust-gains {text}: no motion {motion!r}; one of {', '.join(wrists)}")
        values = pi_gains(pair, "--robust-gains", "2.1,5.4")
        for name in [motion] if given else list(wrists):
            w = wrists[name]
            found[name] = {"robust PI": PI.of(w, values[0], values[1])}
    return found


def _plants(
    folders: list[Path], files: list[Path], seed: int, said: Any
) -> tuple[dict[str, "Fit"], dict[str, "ParameterSet"]]:
    """Fits of the campaigns, and the parameter set of each motion: fitted, given, or, where nothing is given,
    built in."""
    from design.cli.commands.fit import tables
    from design.cli.common import shown
    from plants.errors import InputError
    from plants.measured.campaign import load_campaign
    from plants.measured.trace.law import fit_rig
    from plants.parameters.files import built_in, load

    given: dict[str, ParameterSet] = {}
    fits: dict[str, Fit] = {}
    for path in files:
        one = load(path)
        if one.axis in given:
            raise InputError(f"{path}: a set for {one.axis!r} was given before; give one a motion")
        given[one.axis] = one
    files_of, campaigns = list(given.values()), {}
    for folder in folders:  # all are read before any is fitted, so that bad input ends the run at once
        data = load_campaign(folder, next((s.rig for s in files_of), None))
        if data.stage == "regulator":
            raise InputError(f"{folder}: has no angle; a comparison needs a campaign of the whole wrist")
        if data.axis in campaigns:
            raise InputError(f"{folder}: {data.axis!r} was given before; give one campaign a motion")
        campaigns[data.axis] = (
            data,
            given.pop(data.axis, None),
        )
    sets = dict(given)  # what no campaign starts from
    for axis, (data, start) in campaigns.items():
        with progress(f"fit {data.name}") as tell:
            fits[axis] = fit_rig(data, start, seed=seed, progress=tell).fit
        for part in tables(fits[axis]):
            said.print(part)
        sets[axis] = fits[axis].fitted
    motions = [axis.value for axis in Axis]
    if not sets:
        sets = {axis: built_in(axis) for axis in motions}
    shown(next(iter(sets.values())))
    order = sorted(sets, key=lambda name: (motions.index(name) if name in motions else len(motions), name))
    return fits, {name: sets[name] for name in order}
