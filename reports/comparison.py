"""The comparison as a page for a colleague, and beside it the same as JSON, CSV and pictures."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from design.compare import Comparison
from design.metrics import SETTLING_BAND
from design.tasks import STEP
from design.tuning import Tuning
from plants.quantities import ParameterSet, built_in
from plants.wrist import COMMAND_RANGE, SAMPLE_TIME, Wrist
from reports import comparison_tables as tables
from reports import comparison_words as words
from reports import figures, paper
from reports.fitted import Fit, draw_fit
from reports.gain_map import COST_WORDS
from reports.html import Made, markup, render
from reports.records import comparison_record, csv_text
from reports.style import save, svg
from reports.tables import number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["comparison_page", "write_comparison"]


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
    from plants.files import json_text, write_atomically

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
    wrists = {m: Wrist.of(s) for m, s in sets.items()}
    found = {
        "worst-values": figures.worst_values(comparison),
        "loops": figures.loop_trajectories(comparison, wrists),
    }
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
    responses = [shown(f"steps-{slug(m)}", words.steps_caption(comparison, m)) for m in motions]
    responses.append(shown("loops", words.LOOPS_CAPTION))
    return render(
        "comparison.html",
        title=f"Holding {STEP:g} degrees: the tuned PI beside the paper's and the textbook rules",
        summary=words.summary(comparison, sets, fits),
        step=STEP, sample_ms=1000.0 * SAMPLE_TIME, command_range=COMMAND_RANGE, window=figures.WINDOW,
        band=100.0 * SETTLING_BAND, tasks=_tasks(comparison),
        limits=tables.limits_table(comparison.limits),
        fitted_any=bool(fits),
        plants=[_plant(m, s, fits.get(m), shown) for m, s in sets.items()],
        cost=" and ".join(COST_WORDS.get(c, c) for c in sorted(costs)),
        tunings=[_tuning(m, t, shown) for m, t in tunings.items()],
        standings=tables.standings_table(comparison), worst=shown("worst-values", words.WORST_CAPTION),
        all_tasks=tables.task_table(comparison), row_count=len(comparison.rows),
        paper_note=tables.paper_note(),
        responses=responses, paper=_paper(sets),
        assumed=assumed, assumed_count=sum(len(g.rows) for g in assumed.groups), further=words.FURTHER,
        made=made,
    )  # fmt: skip


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
        note = f"{s.title}. No recordings were given for this motion: the parameters are as declared."
        none = {"errors": None, "misfit": "", "judged_on": "", "figure": None}
        return {"title": title, "words": note, "parameters": tables.parameter_table(s), **none}
    apart = any(r.role == "validate" for r in fit.runs)
    return {
        "title": title,
        "words": words.fit_words(fit),
        "parameters": tables.parameter_table(fit.fitted, fit.before),
        "errors": tables.error_table(fit),
        "misfit": words.misfit(fit),
        "figure": shown(f"fit-{slug(motion)}", words.fit_caption(motion, fit)),
        "judged_on": " on the recordings that took no part" if apart else "",
    }


def _tuning(motion: str, t: Tuning, shown: Any) -> dict[str, Any]:
    return {
        "title": figures.title_of(motion),
        "gains": f"Kp = {number(t.Kp)} kPa/deg, Ki = {number(t.Ki)} kPa/(deg s).",
        "found": words.found(t),
        "evidence": words.evidence(t),
        "table": tables.tuning_table(t),
        "figure": shown(f"gains-{slug(motion)}", words.map_caption(motion)),
    }


def _paper(sets: Mapping[str, ParameterSet]) -> list[Shown]:
    """All figures of the paper, a motion that the page lacks taken from the built-in set."""
    both = {
        "flexion": sets.get("flexion", built_in("flexion")),
        "deviation": sets.get("deviation", built_in("deviation")),
    }
    wrists = [Wrist.of(s) for s in both.values()]
    found = []
    for which, figure in paper.FIGURES.items():
        drawing = svg(paper.draw(which, *wrists), f"paper-{which}", figure.title)
        found.append(Shown(markup(drawing), paper.caption(which, both)))
    return found
