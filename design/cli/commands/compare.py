"""``wrist compare``: fit and tune, or take a design, compare, report."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from design.cli.common import (
    Axis,
    JobsOption,
    JsonOption,
    SeedOption,
    command_line,
    following,
    shown,
    write_json,
)
from design.cli.completion import files
from design.cli.design_folder import alternatives, gains_file, motions, plant_file, recommended
from design.cli.design_folder import stages as design_stages
from design.cli.places import check_places
from design.cli.terminal.screen import console, progress

if TYPE_CHECKING:
    from design.alternatives.designs import RequirementDesign
    from design.controllers.controller import Controller
    from design.controllers.pi import PI
    from plants.measured.fitting.fit import Fit
    from plants.parameters.quantities import ParameterSet

NAME = "compare"
HELP = (
    "Compare the recommended PI, tuned for the whole requirement, with a PI tuned without dead time, the "
    "paper's PI, textbook rules and other designs; write a report."
)
EXAMPLE = "Example: wrist compare plants/measured/examples/flexion --out build/compare"
NEXT = "wrist robust --gains Kp,Ki"


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
    design: Annotated[
        Path | None,
        typer.Option(
            "--design",
            help="Folder that `wrist design` wrote: its plants and recommended gains.",
            autocompletion=files,
        ),
    ] = None,
    example: Annotated[
        bool, typer.Option("--example", help="Use the example campaigns of the project (synthetic).")
    ] = False,
    out: Annotated[Path, typer.Option("--out", help="Folder for the report.", autocompletion=files)] = Path(
        "build/compare"
    ),
    json: JsonOption = None,
    points: Annotated[int, typer.Option(help="Points of the map in each gain.", min=5, max=400)] = 24,
    plain: Annotated[
        bool,
        typer.Option("--plain", help="Tune for steps only: no dead time, load or search; faster."),
    ] = False,
    samples: Annotated[
        int, typer.Option(help="Perturbed plants of each motion, at least 10; 0 leaves them out.", min=0)
    ] = 50,
    mpc_plants: Annotated[
        int, typer.Option(help="Of these, plants on which the MPCs run too (seconds each).", min=0)
    ] = 10,
    robust_gains: Annotated[
        list[str] | None,
        typer.Option(
            help="Gains Kp,Ki of a robust PI to compare as well; of one motion alone as flexion=Kp,Ki. "
            "May be repeated."
        ),
    ] = None,
    seed: SeedOption = 0,
    jobs: JobsOption = None,
) -> None:
    from design.cli.commands.compare_tables import contest_table, table
    from design.comparison.compare import TUNED
    from design.contest.statistics import FEWEST
    from design.studies.stages import Stages
    from design.studies.study import Question, study
    from plants.errors import InputError
    from plants.measured.campaigns.campaign import shipped
    from plants.wrist import Wrist
    from reports.comparison.contest.words import sentences
    from reports.comparison.page import write_comparison
    from reports.comparison.record import comparison_record
    from reports.comparison.verdict_words import verdict_sentences
    from reports.shared.html import Made
    from reports.shared.tuning import gains_line, refused

    if 0 < samples < FEWEST:
        raise InputError(
            f"--samples {samples}: too few for an interval; give at least {FEWEST}, or 0 for none"
        )
    beside = {"a campaign": campaigns, "--plant": plant, "--example": example, "--plain": plain}
    if design is not None and any(beside.values()):
        words = ", ".join(n for n, v in beside.items() if v)
        raise InputError(f"--design: has its plants and gains; leave out {words}")
    check_places({"--json": json}, out)
    said = console(json)
    fits: dict[str, Fit] = {}
    given: dict[str, PI] = {}
    others: dict[str, dict[str, RequirementDesign]] = {}
    if design is not None:
        sets, given = _designed(design, said)
        others = {m: alternatives(design, plant) for m, plant in sets.items()}
    else:
        fits, sets = _plants(list(campaigns or []) + (shipped() if example else []), plant or [], seed, said)
    more = robust(robust_gains or [], {name: Wrist.of(s) for name, s in sets.items()})
    stages = Stages(None if design is None else design_stages(design), read_only=True)
    question = Question(
        sets, fits, points, samples, mpc_plants, plain, given, more, seed, jobs, stages, others
    )
    with progress("compare") as tell:
        found = study(question, tell)
    if found.without_mpc:
        said.print(f"MPCs are left out: {found.without_mpc}")
    for name, answer in found.answers.items():
        said.print(f"{name}: {gains_line(answer.tuning)}")
    for name, no in found.refusals.items():
        said.print(f"{name}: {refused(no)}")
    for line in table(found.comparison):
        said.print(line)
    if found.contest is not None:
        for line in [*contest_table(found.contest), *sentences(found.contest)]:
            said.print(line)
    for name in found.unperturbed:
        said.print(f"{name}: has effects, so no perturbed plants are drawn")
    made = Made.now(
        command=command_line(),
        seed=seed,
        sets=sets,
        data={f.campaign.name: f.campaign.checksum for f in fits.values()},
    )
    with progress("page"):
        written = write_comparison(out, found, made)
    for sentence in verdict_sentences(found):
        said.print(sentence)
    said.print(f"report in {written}", soft_wrap=True)
    for name, d in found.decisions.items():
        gains: object = f"{d.gains['Kp']:.4g},{d.gains['Ki']:.4g}"
        rest = ("--plant", plant[0]) if plant and len(plant) == 1 else ("--axis", name)
        if design is not None:
            gains = gains_file(design, name) if d.controller == TUNED else gains
            rest = ("--plant", plant_file(design, name))
        following(said, "wrist", "robust", "--gains", gains, *rest)
    write_json(json, comparison_record(found, made))
    if found.refusals:
        raise typer.Exit(1)


def _designed(folder: Path, said: Any) -> "tuple[dict[str, ParameterSet], dict[str, PI]]":
    """Of each motion of a design the plant, without what a design leaves out, and the recommended controller;
    says in a line what is left out."""
    from design.synthesis.designed_plant import designed, left_out
    from plants.parameters.files import load

    whole = _ordered({m: load(plant_file(folder, m)) for m in motions(folder)})
    shown(next(iter(whole.values())))
    sets = {m: designed(plant) for m, plant in whole.items()}
    given = {m: recommended(folder, plant) for m, plant in sets.items()}
    gone = [f"{name} of {m}" for m, plant in whole.items() for name in left_out(plant)]
    if gone:
        said.print(f"left out, as in the design: {', '.join(gone)}")
    return sets, given


def _ordered(sets: "Mapping[str, ParameterSet]") -> "dict[str, ParameterSet]":
    """The same in the order in which motions are shown."""
    known = [axis.value for axis in Axis]
    order = sorted(sets, key=lambda name: (known.index(name) if name in known else len(known), name))
    return {name: sets[name] for name in order}


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
        for name in [motion] if given else list(wrists):
            w = wrists[name]
            values = pi_gains(pair, "--robust-gains", "2.1,5.4", w.rig)
            found[name] = {"robust PI": PI.of(w, values[0], values[1])}
    return found


def _plants(
    folders: list[Path], files: list[Path], seed: int, said: Any
) -> tuple[dict[str, "Fit"], dict[str, "ParameterSet"]]:
    """Fits of the campaigns, and the parameter set of each motion: fitted, given, or, where nothing is given,
    built in."""
    from design.cli.commands.logs.fit import tables
    from plants.errors import InputError
    from plants.measured.campaigns.campaign import load_campaign
    from plants.measured.trace.rig_fit import fit_rig
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
    if not sets:
        sets = {axis.value: built_in(axis.value) for axis in Axis}
    shown(next(iter(sets.values())))
    return fits, _ordered(sets)
