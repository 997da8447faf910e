"""``wrist compare``: fit, tune, compare, report."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from design.cli.common import JobsOption, JsonOption, SeedOption, console, progress, seconds, write_json

if TYPE_CHECKING:
    from design.compare import Comparison
    from design.pi import PI
    from design.tuning import Tuning
    from plants.measured.fit import Fit
    from plants.quantities import ParameterSet

NAME = "compare"
HELP = "Compare the tuned PI with the paper's and the textbook rules on 15 degree tasks; write a report."
EXAMPLE = "Example: wrist compare plants/measured/examples/flexion --out build/compare"


def command(
    campaigns: Annotated[
        list[Path] | None,
        typer.Argument(
            help="Campaigns to fit, one a motion; the built-in parameters stand for a motion without one."
        ),
    ] = None,
    plant: Annotated[
        list[Path] | None,
        typer.Option(
            help="Parameter set of a motion: where its fit starts, or, without a campaign, the plant."
        ),
    ] = None,
    example: Annotated[
        bool, typer.Option("--example", help="Use the campaigns that ship with the project (synthetic).")
    ] = False,
    out: Annotated[Path, typer.Option("--out", help="Folder for the report.")] = Path("build/compare"),
    json: JsonOption = None,
    points: Annotated[int, typer.Option(help="Points of the map in each gain.", min=5, max=400)] = 40,
    seed: SeedOption = 0,
    jobs: JobsOption = None,
) -> None:
    import sys

    from design.answer import refusal
    from design.compare import compare
    from design.requirements import default_problem
    from design.tuning import Region, tune
    from plants.wrist import Wrist
    from reports.comparison import write_comparison
    from reports.html import Made
    from reports.records import comparison_record

    said = console(json)
    folders = list(campaigns or []) + (example_campaigns() if example else [])
    fits, sets = _plants(folders, plant or [], seed, said)
    wrists = {name: Wrist.of(s) for name, s in sets.items()}
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
    comparison = compare(wrists, tuned, refusals=refusals)
    for line in table(comparison):
        said.print(line)
    made = Made.now(
        command="wrist " + " ".join(sys.argv[1:]),
        seed=seed,
        sets=sets,
        data={f.campaign.name: f.campaign.checksum for f in fits.values()},
        remark="The example campaigns are synthetic: they come from a simulator, not from a rig."
        if example
        else "",
    )
    written = write_comparison(out, comparison, tunings, sets, fits, made)
    for verdict in comparison.verdicts:
        said.print(verdict)
    said.print(f"report in {written}")
    write_json(json, comparison_record(comparison, tunings, sets, fits, made))
    if refusals:
        raise typer.Exit(1)


def example_campaigns() -> list[Path]:
    """Folders of the campaigns that ship with the project."""
    import plants.measured

    return sorted(
        p.parent for p in (Path(plants.measured.__file__).parent / "examples").glob("*/campaign.toml")
    )


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


def table(comparison: "Comparison") -> list[object]:
    """A table for each motion, one row a controller; what breaks a limit carries a mark."""
    from rich.table import Table

    parts: list[object] = []
    for motion in {s.motion: None for s in comparison.standings}:
        one = Table(
            title=f"{motion}: gains, worst values over the tasks, and margins",
            title_justify="left",
            box=None,
            pad_edge=False,
        )
        for heading in ("controller", "Kp", "Ki", "settles", "overshoot", "IAE deg s", "Ms", "delay"):
            one.add_column(heading, justify="left" if heading == "controller" else "right", no_wrap=True)
        for s in comparison.standings:
            if s.motion != motion:
                continue
            cells = {
                "": f"{s.Kp:.3g}",
                " ": f"{s.Ki:.3g}",
                "steady_error_percent": seconds(s.worst_settling_s),
                "overshoot_percent": f"{s.worst_overshoot_percent:.2g} %",
                "  ": f"{s.worst_iae_deg_s:.3g}",
                "Ms": f"{s.Ms:.3g}",
                "delay_margin_s": f"{1000 * s.delay_margin_s:.0f} ms",
            }
            one.add_row(s.controller, *(text + ("!" if n in s.breaks else " ") for n, text in cells.items()))
        parts += [one, ""]
    return [*parts, "! beyond its limit"]
