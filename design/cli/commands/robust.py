"""``wrist robust``: how far gains can be trusted, in certificates, predictions and samples."""

from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from design.cli.common import (
    Axis,
    AxisOption,
    JobsOption,
    JsonOption,
    PlantOption,
    SchedulerOption,
    SeedOption,
    check_dead_time,
    command_line,
    following,
    numbers,
    parameter_set,
    pi_gains,
    say_left_out,
    write_json,
)
from design.cli.completion import files
from design.cli.completion import intervals as parameters
from design.cli.places import check_places
from design.cli.strict import LARGEST
from design.cli.terminal.screen import Sheet, console, progress
from design.status import BY_PROOF, Status

if TYPE_CHECKING:
    from design.controllers.pi import PI
    from design.robustness.assess import Assessment
    from design.robustness.statement import Statement
    from plants.wrist import Wrist

NAME = "robust"
HELP = "Judge gains on every branch: verdict, certificates, predictions, samples, the worst case."
EXAMPLE = "Example: wrist robust --gains 2.3,6.4 --out build/robust"
NEXT = "wrist export pi --gains Kp,Ki"

KINDS: dict[tuple[Status, ...], str] = {
    BY_PROOF: "Certificates (proved, and checked outside the solver)",
    (Status.PREDICTED,): "Predictions (linear theory and describing functions)",
    (Status.SAMPLED,): "Samples (simulated)",
}


def command(
    gains: Annotated[
        str,
        typer.Option(
            help="Kp,Ki of the PI: kPa/deg, kPa/(deg s); of one with two degrees of freedom also b,Tf: 1, s; "
            "or a TOML file with them."
        ),
    ],
    axis: AxisOption = Axis.flexion,
    plant: PlantOption = None,
    box: Annotated[
        list[str] | None,
        typer.Option(
            help="Interval of a parameter, such as a1=0.34:0.38, in place of two standard errors "
            "(where fitted) or the shares of --corners (where assumed). May be repeated.",
            autocompletion=parameters,
        ),
    ] = None,
    corners: Annotated[
        str | None, typer.Option(help="Relative deviations of assumed loop width, slopes and lag.")
    ] = None,
    dead_time: Annotated[
        float | None,
        typer.Option(
            help="Longest dead time in samples and worst case [s], the plant's own included; by default the "
            "rig's.",
            min=0.0,
        ),
    ] = None,
    load: Annotated[
        float | None,
        typer.Option(
            help="Load in these, as a shift of the static angle [deg]; by default the rig's.", min=0.0
        ),
    ] = None,
    noise: Annotated[
        float | None,
        typer.Option(
            help="Noise of the angle at 100 Hz in samples, s.d. [deg]; by default the rig's.", min=0.0
        ),
    ] = None,
    quantum: Annotated[
        float | None,
        typer.Option(help="Resolution of the angle sensor in samples [deg]; by default the rig's.", min=0.0),
    ] = None,
    samples: Annotated[int, typer.Option(help="Independent samples.", min=20, max=10_000_000)] = 2000,
    budget: Annotated[
        int, typer.Option(help="Maximum number of runs of the worst-case search.", min=200)
    ] = 20_000,
    worst: Annotated[
        Path | None,
        typer.Option(
            help="Write the worst scenario to this file, for `wrist simulate --scenario`.",
            autocompletion=files,
        ),
    ] = None,
    points: Annotated[
        int, typer.Option(help="Points of the page's gain plane in each gain.", min=4, max=100)
    ] = 20,
    seed: SeedOption = 0,
    json: JsonOption = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the page and its figures.", autocompletion=files)
    ] = None,
    jobs: JobsOption = None,
    scheduler: SchedulerOption = None,
) -> None:
    from design.controllers.pi import PI
    from design.evaluation.scenarios import Spread
    from design.robustness.assess import assess
    from design.robustness.box import box_of
    from design.robustness.samples.conditions import Conditions
    from design.robustness.samples.scenario_file import save
    from design.synthesis.designed_plant import designed
    from plants.errors import InputError
    from plants.wrist import Wrist
    from reports.robustness.record import assessment_record

    check_places({"--worst": worst, "--json": json}, out)
    whole = parameter_set(axis, plant)
    chosen = designed(whole)
    spread = (
        Spread.of(chosen.rig) if corners is None else Spread(*numbers(corners, "--corners", "0.2,0.1,0.2"))
    )
    if max(vars(spread).values()) >= 1.0:
        raise InputError(f"--corners: {corners!r} must be shares below 1")
    pi = controller(gains, Wrist.of(chosen))
    around = box_of(chosen, spread, given=intervals(box or []))
    check_dead_time(chosen, dead_time)
    asked = {"dead_time": dead_time, "load": load, "noise": noise, "quantum": quantum}
    conditions = replace(Conditions.of(chosen.rig), **{n: v for n, v in asked.items() if v is not None})
    with progress("robust") as tell:
        found = assess(around, pi, None, conditions, samples, seed, jobs, scheduler, tell, budget)
    said = console(json)
    say_left_out(said, whole)
    for part in lines(found):
        said.print(part)
    if worst is not None:
        save(found.worst, worst)
        said.print(f"worst scenario in {worst}", soft_wrap=True)
    if out is not None:
        said.print(f"page in {_write_page(out, found, points, seed, jobs)}", soft_wrap=True)
    if found.stable:
        more = ["--plant", plant] if plant else ["--axis", chosen.axis]
        kind = "pi" if type(pi) is PI else "pi-2dof"
        its = ",".join(gains.split(",")[:2]) if kind == "pi" else gains
        following(said, "wrist", "export", kind, "--gains", its, *more, "--out", "build/c")
    write_json(json, assessment_record(found))
    if not found.stable:
        raise typer.Exit(1)


def intervals(texts: list[str]) -> dict[str, tuple[float, float]]:
    """Bounds by name, of options such as ``a1=0.34:0.38``.  Raises InputError for another form, and
    for a name that is given twice.

    >>> intervals(["a1=0.34:0.38"])
    {'a1': (0.34, 0.38)}
    """
    from plants.errors import InputError

    found: dict[str, tuple[float, float]] = {}
    for text in texts:
        name, _, bounds = text.partition("=")
        low, _, high = bounds.partition(":")
        try:
            pair = (float(low), float(high))
            if not all(isfinite(x) and abs(x) <= LARGEST for x in pair):
                raise ValueError
        except ValueError:
            raise InputError(f"--box: {text!r} is not name=low:high, like a1=0.34:0.38") from None
        if name in found:
            raise InputError(f"--box: {name} is given twice")
        found[name] = pair
    return found


def controller(gains: str, wrist: "Wrist") -> "PI":
    """The PI of ``--gains``, with the reference weight and the filter where they are given; raises
    InputError for gains that are not both above zero."""
    from design.controllers.pi import PI
    from design.controllers.pi_two_dof import TwoDofPI
    from design.tuner.gains_file import read_more
    from plants.errors import InputError

    if gains.count(",") == 3:
        Kp, Ki, b, Tf = numbers(gains, "--gains", "3.1,10.4,0.7,0.01")
    else:
        Kp, Ki = pi_gains(gains, rig=wrist.rig)
        b, Tf = read_more(gains) if gains.endswith(".toml") else (1.0, 0.0)
    if Kp <= 0.0 or Ki <= 0.0:
        raise InputError(
            f"--gains: {gains!r}: Kp and Ki must both be above 0; without Ki the error never goes"
        )
    return PI.of(wrist, Kp, Ki) if (b, Tf) == (1.0, 0.0) else TwoDofPI.of(wrist, Kp, Ki, b, Tf)


def lines(found: "Assessment") -> list[Any]:
    """What people read of an assessment: the verdict in one line, what it rests on, the statements by kind,
    where they disagree."""
    from design.robustness.verdict import verdict
    from reports.robustness.disagreements import disagreement_sentences
    from reports.robustness.words import answer, details, remarks

    said: list[Any] = [answer(found), "", *details(found), *remarks(found)]
    for statuses, words in KINDS.items():
        statements = [s for s in verdict(found) if s.status in statuses]
        rows = tuple(_cells(s) for s in statements)
        said += ["", Sheet(("result", "value", "statement", "branch"), rows, words, words=(0, 2, 3))]
    contradictions = disagreement_sentences(found)
    if contradictions:
        said += ["", "Apparent contradictions"] + [f"- {d}" for d in contradictions]
    return said


def _cells(s: "Statement") -> tuple[str, ...]:
    from reports.robustness.claims import claim_words
    from reports.robustness.tables import outcome, shown

    return outcome(s), shown(s), claim_words(s.claim), s.branch


def _write_page(out: Path, found: "Assessment", points: int, seed: int, jobs: int | None) -> Path:
    from design.studies.robustness_study import robustness_study
    from reports.robustness.page import write_robust
    from reports.shared.html import Made

    plant = found.box.plant
    with progress("page") as tell:
        study = robustness_study(found, points, jobs, tell)
        return write_robust(out, study, Made.now(command_line(), seed, {plant.axis: plant}))
