"""``wrist compare``: fit, tune, compare, report."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from design.cli.common import JobsOption, JsonOption, SeedOption, command_line, write_json
from design.cli.completion import files
from design.cli.places import check_places
from design.cli.screen import console, progress

if TYPE_CHECKING:
    from design.break_even import BreakEven
    from design.controllers.controller import Controller
    from design.controllers.pi import PI
    from design.tuning import Tuning
    from plants.measured.fit import Fit
    from plants.quantities import ParameterSet

NAME = "compare"
HELP = "Compare the tuned PI with the paper's, the textbook rules and other designs; write a report."
EXAMPLE = "Example: wrist compare plants/measured/examples/flexion --out build/compare"


def command(
    campaigns: Annotated[
        list[Path] | None,
        typer.Argument(
            help="Campaigns to fit, one a motion; the built-in parameters stand for a motion without one.",
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
    from design.alternatives.designs import design_others
    from design.answer import refusal
    from design.cli.compare_tables import contest_table, table
    from design.compare import compare, controllers
    from design.contest import contest
    from design.contest.statistics import FEWEST
    from design.contest.words import sentences
    from design.deadlines import deadlines
    from design.requirements import default_problem
    from design.tuning import Region, tune
    from plants.errors import InputError
    from plants.wrist import Wrist
    from reports.comparison import write_comparison
    from reports.html import Made
    from reports.records import comparison_record

    if 0 < samples < FEWEST:
        raise InputError(
            f"--samples {samples}: too few for an interval; give at least {FEWEST}, or 0 for none"
        )
    check_places({"--json": json}, out)
    said = console(json)
    folders = list(campaigns or []) + (example_campaigns() if example else [])
    fits, sets = _plants(folders, plant or [], seed, said)
    wrists = {name: Wrist.of(s) for name, s in sets.items()}
    more = robust(robust_gains or [], wrists)
    tunings: dict[str, Tuning] = {}
    for name, wrist in wrists.items():
        with progress(f"tune {name}") as tell:
            tunings[name] = tune(
                default_problem(wrist, jobs=jobs), Region(points=points), seed=seed, progress=tell
            )
        said.print(f"{name}: Kp = {tunings[name].Kp:.4g} kPa/deg, Ki = {tunings[name].Ki:.4g} kPa/(deg s)")
    refusals = {n: no for n, t in tunings.items() if (no := refusal(t)) is not None}
    for name, no in refusals.items():
        said.print(f"{name}: {no}")
    tuned = {n: _tuned(t) for n, t in tunings.items()}
    designs = {}
    mpcs = _mpcs(wrists, said)
    for name, t in tunings.items():
        with progress(f"{name}, other designs") as tell:
            designs[name] = design_others(t.problem, tell)
    with progress("compare") as tell:
        comparison = compare(
            wrists, tuned, refusals=refusals, designs=designs, more=more, periodic=mpcs, progress=tell
        )
    for line in table(comparison):
        said.print(line)
    named = {n: controllers(wrists[n], tuned[n], designs[n], more.get(n)) for n in wrists}
    alone = {n: {c: alike[0] for c, alike in of.items()} for n, of in named.items()}
    maps = _break_evens(wrists, alone, jobs)
    with progress("times of steps"):
        ledgers = {n: deadlines(w, alone[n], mpcs.get(n)) for n, w in wrists.items()}
    broad = None
    bare = {n: s for n, s in sets.items() if not s.effects}
    if samples and bare:
        with progress("other plants") as tell:
            broad = contest(
                bare, {n: alone[n] for n in bare},
                count=samples, seed=seed, jobs=jobs, progress=tell,
                periodic=mpcs if mpc_plants else None, periodic_count=mpc_plants,
            )  # fmt: skip
        for line in contest_table(broad):
            said.print(line)
        for sentence in sentences(broad):
            said.print(sentence)
    for name in set(sets) - set(bare) if samples else ():
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
        written = write_comparison(out, comparison, tunings, sets, fits, made, broad, maps, ledgers)
    for verdict in comparison.verdicts:
        said.print(verdict)
    said.print(f"report in {written}", soft_wrap=True)
    record = comparison_record(comparison, tunings, sets, fits, made, broad, maps, ledgers)
    write_json(json, record)
    if refusals:
        raise typer.Exit(1)


def example_campaigns() -> list[Path]:
    """Folders of the campaigns that ship with the project."""
    import plants.measured

    return sorted(
        p.parent for p in (Path(plants.measured.__file__).parent / "examples").glob("*/campaign.toml")
    )


def _mpcs(wrists: Any, said: Any) -> dict[str, Any]:
    """The MPCs of each motion; none, and why, where their solver is not installed."""
    from design.alternatives.designs import design_mpcs
    from plants.errors import InputError

    try:
        with progress("MPCs"):
            return {name: design_mpcs(wrist) for name, wrist in wrists.items()}
    except InputError as error:
        said.print(f"MPCs are left out: {error}")
        return {}


def _break_evens(wrists: Any, controllers: Any, jobs: int | None) -> "dict[str, BreakEven]":
    """The break-even map of each motion: what has a feedforward against the tuned PI, of a wrist that has an
    inverse and no effects of its own."""
    from design.alternatives.designs import FORWARD_PI
    from design.break_even import break_even
    from design.compare import FORWARD, TUNED

    found = {}
    for name, wrist in wrists.items():
        others = {n: c for n, c in controllers[name].items() if n in (FORWARD, FORWARD_PI)}
        if others and not wrist.effects:
            with progress(f"{name}, break-even map"):
                found[name] = break_even(wrist, controllers[name][TUNED], others, jobs=jobs)
    return found


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
            found[name] = {
                "robust PI": PI(values[0], values[1], w.regulator.gain, w.hysteresis.rest_pressure)
            }
    return found


def _tuned(tuning: "Tuning") -> "PI":
    from design.requirements import controller

    return controller(tuning.problem, tuning.Kp, tuning.Ki)


def _plants(
    folders: list[Path], files: list[Path], seed: int, said: Any
) -> tuple[dict[str, "Fit"], dict[str, "ParameterSet"]]:
    """Fits of the campaigns, and the parameter set of each motion: fitted, given, or built in."""
    from design.cli.common import starting_set
    from design.cli.fit import tables
    from plants.errors import InputError
    from plants.measured.campaign import load_campaign
    from plants.measured.fit import fit_campaign
    from plants.quantities import built_in, load

    given: dict[str, ParameterSet] = {}
    fits: dict[str, Fit] = {}
    for path in files:
        one = load(path)
        if one.axis in given:
            raise InputError(f"{path}: a set for {one.axis!r} was given before; give one a motion")
        given[one.axis] = one
    campaigns = {}
    for folder in folders:  # all are read before any is fitted, so that bad input ends the run at once
        data = load_campaign(folder)
        if data.stage == "regulator":
            raise InputError(f"{folder}: has no angle; a comparison needs a campaign of the whole wrist")
        if data.axis in campaigns:
            raise InputError(f"{folder}: {data.axis!r} was given before; give one campaign a motion")
        campaigns[data.axis] = (
            data,
            given.pop(data.axis) if data.axis in given else starting_set(data, None),
        )
    sets = dict(given)  # what no campaign starts from
    for axis, (data, start) in campaigns.items():
        with progress(f"fit {data.name}") as tell:
            fits[axis] = fit_campaign(data, start, seed=seed, progress=tell)
        for part in tables(fits[axis]):
            said.print(part)
        sets[axis] = fits[axis].fitted
    for axis in ("flexion", "deviation"):
        if len(sets) < 2 and axis not in sets:
            sets[axis] = built_in(axis)
    order = sorted(sets, key=lambda name: (name != "flexion", name))
    return fits, {name: sets[name] for name in order}
