"""The comparison as a page for a colleague, and beside it the same as JSON, CSV and pictures."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from design.compare import TUNED, Comparison
from design.metrics import SETTLING_BAND
from design.rules import PAPER_FACTOR, PAPER_GAINS
from design.tasks import STEP
from design.tuning import Tuning
from plants.quantities import Assumed, ParameterSet, built_in
from plants.wrist import COMMAND_RANGE, SAMPLE_TIME, Wrist
from reports import comparison_tables as tables
from reports import figures, paper
from reports.comparison_record import comparison_record, csv_text, json_text
from reports.fitted import Fit, draw_fit, shown_run
from reports.gain_map import COST_WORDS
from reports.html import Made, markup, render
from reports.style import save, svg
from reports.tables import number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["comparison_page", "comparison_record", "write_comparison"]

FURTHER = (
    "The law by which the regulator's P gain varies: dP/dt = k(e) e with k(e) = k_slow + (k_fast - k_slow) e² / (e² + e0²).",
    "The form of the controller: command = (rest pressure + Kp e + Ki ∫e dt) / gain, on kilopascals, the integrator "
    "stopped while the command is clipped.",
    f"The paper's gains: Kp = {PAPER_GAINS[0]:g} kPa/deg, Ki = {PAPER_GAINS[1]:g} kPa/(deg s) stand in for the lost "
    f"ones, with a factor of {PAPER_FACTOR:g} either way, because a PI with them is as slow as the paper reads.",
    "How far the corners of the plant lie that gains are tuned on: loop width ±20 %, slopes ±10 %, Tw ±20 % unless set otherwise.",
    "One pressure stands for a motion, its antagonist mirrored about the rest pressure; the two motions do not act on each other.",
)
"""What is assumed besides the values of parameters."""


@dataclass(frozen=True)
class Shown:
    """A figure in a page: SVG ready to be put in, and the words beneath."""

    svg: Any
    caption: str


def comparison_page(
    comparison: Comparison,
    tunings: Mapping[str, Tuning],
    sets: Mapping[str, ParameterSet],
    fits: Mapping[str, Fit],
    made: Made,
) -> str:
    """The whole comparison as one self-contained HTML text.

    `tunings`, `sets` and `fits` go by motion; `fits` may lack motions that were not fitted.
    """
    return _page(comparison, tunings, sets, fits, made, main_figures(comparison, tunings, sets, fits))


def write_comparison(
    folder: str | Path,
    comparison: Comparison,
    tunings: Mapping[str, Tuning],
    sets: Mapping[str, ParameterSet],
    fits: Mapping[str, Fit],
    made: Made,
) -> Path:
    """Write comparison.html, .json and .csv and the main figures as PNG into a folder, each complete
    or not at all.  Returns the path of the page; raises InputError where it cannot be written."""
    from plants.files import write_atomically

    folder = Path(folder)
    drawn = main_figures(comparison, tunings, sets, fits)
    page = _page(comparison, tunings, sets, fits, made, drawn)
    for name, figure in drawn.items():
        save(figure, folder / f"{name}.png")
    record = comparison_record(comparison, tunings, sets, fits, made)
    write_atomically(folder / "comparison.json", json_text(record))
    write_atomically(folder / "comparison.csv", csv_text(comparison))
    write_atomically(folder / "comparison.html", page)
    return folder / "comparison.html"


def main_figures(
    comparison: Comparison,
    tunings: Mapping[str, Tuning],
    sets: Mapping[str, ParameterSet],
    fits: Mapping[str, Fit],
) -> dict[str, "Figure"]:
    """The figures of the comparison by the names of their files."""
    wrists = {m: Wrist.from_values(s.values) for m, s in sets.items()}
    found = {"worst-values": figures.worst_values(comparison), "loops": figures.loop_trajectories(comparison, wrists)}
    found |= {f"steps-{slug(m)}": figures.step_responses(comparison, m) for m in _motions(comparison)}
    found |= {f"gains-{slug(m)}": figures.gain_map(t) for m, t in tunings.items()}
    return found | {f"fit-{slug(m)}": draw_fit(f) for m, f in fits.items()}


def slug(motion: str) -> str:
    """A motion's name as part of an id or a file.

    >>> slug("left wrist/flexion")
    'left-wrist-flexion'
    """
    return re.sub(r"[^A-Za-z0-9_]+", "-", motion).strip("-") or "motion"


def _motions(comparison: Comparison) -> list[str]:
    return list({s.motion: None for s in comparison.standings})


def _page(
    comparison: Comparison,
    tunings: Mapping[str, Tuning],
    sets: Mapping[str, ParameterSet],
    fits: Mapping[str, Fit],
    made: Made,
    drawn: Mapping[str, "Figure"],
) -> str:
    def shown(name: str, caption: str) -> Shown:
        return Shown(markup(svg(drawn[name], name, caption)), caption)

    motions = _motions(comparison)
    costs = {t.problem.cost for t in tunings.values()}
    assumed = tables.assumption_table(sets)
    responses = [shown(f"steps-{slug(m)}", _steps_caption(comparison, m)) for m in motions]
    responses.append(shown("loops", LOOPS_CAPTION))
    return render(
        "comparison.html",
        title=f"Holding {STEP:g} degrees: the tuned PI beside the paper's and the textbook rules",
        summary=summary(comparison, sets),
        step=STEP, sample_ms=1000.0 * SAMPLE_TIME, command_range=COMMAND_RANGE, window=figures.WINDOW,
        band=100.0 * SETTLING_BAND, tasks=_tasks(comparison),
        limits=tables.limits_table(comparison.limits),
        fitted_any=bool(fits),
        plants=[_plant(m, s, fits.get(m), shown) for m, s in sets.items()],
        cost=" and ".join(COST_WORDS.get(c, c) for c in sorted(costs)),
        tunings=[_tuning(m, t, shown) for m, t in tunings.items()],
        standings=tables.standings_table(comparison), worst=shown("worst-values", WORST_CAPTION),
        all_tasks=tables.task_table(comparison), row_count=len(comparison.rows), paper_note=tables.paper_note(),
        responses=responses, paper=_paper(sets),
        assumed=assumed, assumed_count=sum(len(g.rows) for g in assumed.groups), further=FURTHER,
        made=made,
    )  # fmt: skip


def summary(comparison: Comparison, sets: Mapping[str, ParameterSet]) -> list[str]:
    """At most three sentences: the verdicts, and what they rest on."""
    assumed = sum(isinstance(p.provenance, Assumed) for s in sets.values() for p in s.parameters.values())
    count = sum(len(s.parameters) for s in sets.values())
    rest = f"All of this is simulated; {assumed} of the plants' {count} parameters are assumed, none of them measured."
    if assumed == 0:
        rest = "All of this is simulated, on plants whose parameters are stated or fitted to recordings."
    elif assumed < sum(len(built_in("flexion").assumed) for _ in sets):
        rest = f"All of this is simulated; {assumed} of the plants' {count} parameters are still assumed."
    return [*comparison.verdicts[:2], rest]


def _tasks(comparison: Comparison) -> list[str]:
    """The tasks of a motion in words, steps by their starts."""
    names = list({r.task: None for r in comparison.rows})
    steps: dict[str, list[str]] = {}
    for name in names:
        step, _, start = name.partition(", ")
        steps.setdefault(step, []).append(start)
    return [f"{step}, from {', '.join(s)}" if all(s) else step for step, s in steps.items()]


def _plant(motion: str, s: ParameterSet, fit: Fit | None, shown: Any) -> dict[str, Any]:
    title = figures.title_of(motion)
    if fit is None:
        words = f"{s.title}. No recordings were given for this motion: the parameters are as declared."
        return {
            "title": title, "words": words, "parameters": tables.parameter_table(s), "errors": None,
            "judged_on": "", "figure": None,
        }  # fmt: skip
    took = [r.recording.name for r in fit.runs if r.role == "fit"]
    apart = [r.recording.name for r in fit.runs if r.role == "validate"]
    words = f"Fitted to {', '.join(took)} of the campaign “{fit.campaign.name}”"
    words += f"; judged on {', '.join(apart)}, which took no part." if apart else "; no recording was kept apart to judge it."
    bounds = getattr(fit, "at_bounds", ())
    words += f" At a bound: {', '.join(bounds)}." if bounds else ""
    run = shown_run(fit)
    caption = (
        f"{title}: measured and simulated on {run.recording.name}, with the parameters before the fit and after it; the "
        "errors of both; and the angle against the pressure. The simulation sees the command alone."
    )
    return {
        "title": title, "words": words, "parameters": tables.parameter_table(fit.fitted, fit.before),
        "errors": tables.error_table(fit), "figure": shown(f"fit-{slug(motion)}", caption),
        "judged_on": " on the recordings that took no part" if apart else "",
    }  # fmt: skip


def _tuning(motion: str, t: Tuning, shown: Any) -> dict[str, Any]:
    unit = COST_WORDS.get(t.problem.cost, "").partition("[")[2].rstrip("]")
    cost, where = float(t.at.cost[0]), t.problem.scenarios[int(t.at.cost_at[0])].name
    found = f": worst cost {number(cost)} {unit}, on {where}."
    if not t.feasible:
        found += " No gains hold every limit; these come nearest."
    elif t.active:
        found += f" The active limit is {tables.limit_name(t.active).lower()}: less cost would break it."
    else:
        found += " No limit is active: the optimum lies inside all of them."
    rows, ratios = t.region.points, t.region.resolution
    ends = [s for s in t.searches if s.feasible]
    near = sum(s.cost <= 1.01 * cost for s in ends)
    evidence = (
        f"Evidence that this is the global optimum: a map of {rows} × {rows} gains, Kp {t.region.Kp[0]:g} to "
        f"{t.region.Kp[1]:g} kPa/deg and Ki {t.region.Ki[0]:g} to {t.region.Ki[1]:g} kPa/(deg s), neighbours "
        f"{100 * (ratios[0] - 1):.0f} % and {100 * (ratios[1] - 1):.0f} % apart, shows every valley; {len(t.searches)} local "
        f"searches from its lowest ones ended at {len(ends)} points that hold the limits, {near} of them within 1 % of "
        "the cost found, none below it; finer maps around the best point found nothing lower."
    )
    if any(s.cost < cost * (1 - 1e-9) for s in ends):
        evidence = evidence.replace(", none below it", "")
    if t.on_edge:
        evidence += " The optimum lies on the edge of the searched region: a wider region may hold a better one."
    caption = (
        f"{figures.title_of(motion)}: worst cost over the gains, dark is worse. Inside the black line every limit is held; "
        "elsewhere the hatching tells which one is broken most."
    )
    return {
        "title": figures.title_of(motion), "found": found, "evidence": evidence, "table": tables.tuning_table(t),
        "gains": f"Kp = {number(t.Kp)} kPa/deg, Ki = {number(t.Ki)} kPa/(deg s)",
        "figure": shown(f"gains-{slug(motion)}", caption),
    }  # fmt: skip


WORST_CAPTION = (
    "Worst settling time and overshoot over the tasks of a motion. The grey bar is the range that the paper's PI takes "
    "over the range of its gains; an arrow means that it does not settle while it is watched."
)
LOOPS_CAPTION = (
    "The step from rest under the tuned PI in the plane of pressure and angle: along the dead zone until line 1 is met, "
    "then up beside it. The dots are instants after the step."
)


def _steps_caption(comparison: Comparison, motion: str) -> str:
    count = sum(m == motion for m, _ in comparison.steps)
    return (
        f"{figures.title_of(motion)}: a step of {STEP:g} deg from rest under {count} controllers; angle, pressure and command. "
        f"The scale of time changes at {figures.SOON:g} s. The {figures.name_of(TUNED)} is drawn thick."
    )


def _paper(sets: Mapping[str, ParameterSet]) -> list[Shown]:
    """All figures of the paper, a motion that the page lacks taken from the built-in set."""
    both = {"flexion": sets.get("flexion", built_in("flexion")), "deviation": sets.get("deviation", built_in("deviation"))}
    wrists = [Wrist.from_values(s.values) for s in both.values()]
    found = []
    for number_ in paper.FIGURES:
        words = paper.caption(number_, both)
        drawing = svg(paper.draw(number_, *wrists), f"paper-{number_}", paper.FIGURES[number_].title)
        found.append(Shown(markup(drawing), words))
    return found
