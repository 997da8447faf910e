"""The comparison as a page for a colleague, and beside it the same as JSON, CSV and pictures."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from design.break_even import BreakEven
from design.compare import Comparison
from design.contest import Contest
from design.contest.words import sentences
from design.metrics import SETTLING_BAND
from design.mpc.timing import Ledger
from design.tasks import STEP
from design.tuning import Tuning
from plants.quantities import Fitted, ParameterSet, built_in
from plants.wrist import COMMAND_RANGE, SAMPLE_TIME, Wrist
from reports import comparison_contest as broad
from reports import comparison_costs as costs
from reports import comparison_tables as tables
from reports import comparison_words as words
from reports import figures, paper
from reports.break_even_figure import break_even_figure
from reports.comparison_designs import budgets, designs
from reports.fitted import Fit, draw_fit
from reports.gain_map import COST_WORDS
from reports.html import Made, Shown, markup, render
from reports.records import comparison_record, contest_csv_text, csv_text
from reports.style import save, svg
from reports.tables import number, spaced

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["comparison_page", "write_comparison"]


def comparison_page(
    comparison: Comparison,
    tunings: Mapping[str, Tuning],
    sets: Mapping[str, ParameterSet],
    fits: Mapping[str, Fit],
    made: Made,
    contest: Contest | None = None,
    break_even: Mapping[str, BreakEven] | None = None,
    ledger: Mapping[str, Mapping[str, Ledger]] | None = None,
) -> str:
    """The whole comparison as one self-contained HTML text.

    `tunings`, `sets` and `fits` go by motion; `fits` may lack motions that were not fitted.  Sections of
    what is None are left out: `contest` on other plants; `break_even`, the maps of how wrong a model may
    be, by motion; `ledger`, how long steps take, by motion and controller.
    """
    drawn = main_figures(comparison, tunings, sets, fits, contest, break_even)
    return _page(comparison, tunings, sets, fits, made, drawn, contest, break_even, ledger)


def write_comparison(
    folder: str | Path,
    comparison: Comparison,
    tunings: Mapping[str, Tuning],
    sets: Mapping[str, ParameterSet],
    fits: Mapping[str, Fit],
    made: Made,
    contest: Contest | None = None,
    break_even: Mapping[str, BreakEven] | None = None,
    ledger: Mapping[str, Mapping[str, Ledger]] | None = None,
) -> Path:
    """Write comparison.html, .json and .csv, contest.csv where there was a contest, and the main figures
    as PNG into a folder, each complete or not at all; what it takes is as in `comparison_page`.  Returns
    the path of the page; raises InputError where it cannot be written."""
    from plants.files import json_text, write_atomically

    folder = Path(folder)
    drawn = main_figures(comparison, tunings, sets, fits, contest, break_even)
    page = _page(comparison, tunings, sets, fits, made, drawn, contest, break_even, ledger)
    for name, figure in drawn.items():
        save(figure, folder / f"{name}.png")
    record = comparison_record(comparison, tunings, sets, fits, made, contest, break_even, ledger)
    write_atomically(folder / "comparison.json", json_text(record))
    write_atomically(folder / "comparison.csv", csv_text(comparison))
    if contest:
        write_atomically(folder / "contest.csv", contest_csv_text(contest))
    write_atomically(folder / "comparison.html", page)
    return folder / "comparison.html"


def main_figures(
    comparison: Comparison,
    tunings: Mapping[str, Tuning],
    sets: Mapping[str, ParameterSet],
    fits: Mapping[str, Fit],
    contest: Contest | None = None,
    break_even: Mapping[str, BreakEven] | None = None,
) -> dict[str, "Figure"]:
    """The figures of the comparison by the names of their files."""
    wrists = {m: Wrist.of(s) for m, s in sets.items()}
    found = {
        "worst-values": figures.worst_values(comparison),
        "loops": figures.loop_trajectories(comparison, wrists),
    }
    found |= {f"steps-{slug(m)}": figures.step_responses(comparison, m) for m in _motions(comparison)}
    if contest:
        found["differences"] = broad.differences_figure(contest)
    found |= {f"break-even-{slug(m)}": break_even_figure(b) for m, b in (break_even or {}).items()}
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
    contest: Contest | None,
    break_even: Mapping[str, BreakEven] | None,
    ledger: Mapping[str, Mapping[str, Ledger]] | None,
) -> str:
    def shown(name: str, caption: str) -> Shown:
        return Shown(markup(svg(drawn[name], name, caption)), caption)

    motions = _motions(comparison)
    least = {t.problem.cost for t in tunings.values()}
    assumed = tables.assumption_table(sets)
    responses = [shown(f"steps-{slug(m)}", words.steps_caption(comparison, m)) for m in motions]
    responses.append(shown("loops", words.LOOPS_CAPTION))
    return render(
        "comparison.html",
        title=f"Holding {STEP:g} degrees: the tuned PI beside the paper's, textbook rules and other designs",
        kind="comparison of controllers", remarks=[made.remark] if made.remark else [],
        summary=words.summary(comparison, sets, fits, contest),
        sections=_sections(bool(fits), bool(comparison.designs), contest, break_even, ledger),
        verdicts=[v[:1].upper() + v[1:] for v in comparison.verdicts],
        step=STEP, sample_ms=1000.0 * SAMPLE_TIME, command_range=COMMAND_RANGE, window=figures.WINDOW,
        band=100.0 * SETTLING_BAND, tasks=_tasks(comparison),
        limits=tables.limits_table(comparison.limits),
        plants=[_plant(m, s, fits.get(m), shown) for m, s in sets.items()],
        cost=" and ".join(COST_WORDS.get(c, c) for c in sorted(least)),
        tunings=[_tuning(m, t, shown) for m, t in tunings.items()],
        designs=[(figures.title_of(m), designs(comparison, m)) for m in motions if comparison.designs],
        standings=tables.standings_table(comparison), worst=shown("worst-values", words.WORST_CAPTION),
        all_tasks=tables.task_table(comparison), row_count=len(comparison.rows),
        paper_note=tables.paper_note(),
        contest=_contest(comparison, tunings, contest, shown) if contest else None,
        wrong=[_wrong(m, b, shown) for m, b in (break_even or {}).items()],
        times=_times(ledger) if ledger else None,
        responses=responses, paper=_paper(sets),
        assumed=assumed, assumed_count=sum(len(g.rows) for g in assumed.groups), further=words.FURTHER,
        made=made,
    )  # fmt: skip


def _sections(fitted: bool, designs: bool, contest: Any, break_even: Any, ledger: Any) -> dict[str, str]:
    """Titles of the page's sections by their ids, of those that there are."""
    titles = {
        "asked": "What was asked",
        "table": "The comparison",
        "steps": "How they respond",
        "contest": "On other plants and tasks, with a noisy sensor" if contest else "",
        "wrong": "How wrong the model of a feedforward may be" if break_even else "",
        "times": "How long the steps take" if ledger else "",
        "tuning": "How the PI was tuned",
        "designs": "Other designs under the same limits" if designs else "",
        "fit": "The plant and its fit" if fitted else "The plant",
        "assumptions": "Assumptions",
        "paper": "The paper, redrawn",
    }
    return {name: title for name, title in titles.items() if title}


def _wrong(motion: str, found: BreakEven, shown: Any) -> dict[str, Any]:
    return {
        "title": figures.title_of(motion),
        "words": costs.break_even_words(motion, found),
        "figure": shown(f"break-even-{slug(motion)}", costs.break_even_caption(motion, found)),
        "table": costs.break_even_table(found),
    }


def _times(ledger: Mapping[str, Mapping[str, Ledger]]) -> dict[str, Any]:
    return {
        "words": costs.ledger_words(ledger), "table": costs.ledger_table(ledger),
        "caption": costs.LEDGER, "note": costs.TIMES,
    }  # fmt: skip


def _contest(
    comparison: Comparison, tunings: Mapping[str, Tuning], contest: Contest, shown: Any
) -> dict[str, Any]:
    overshoot = comparison.limits.overshoot_percent
    return {
        "said": [s[:1].upper() + s[1:] for s in sentences(contest)],
        "how": [*broad.how(contest), budgets(comparison, tunings)],
        "main": broad.main_table(contest, overshoot),
        "further": broad.further_tables(contest, overshoot),
        "figure": shown("differences", broad.CAPTION),
    }


def _tasks(comparison: Comparison) -> list[str]:
    """The tasks of a motion in words, steps by their starts."""
    names = list({spaced(r.task): None for r in comparison.rows})
    steps: dict[str, list[str]] = {}
    for name in names:
        step, _, start = name.partition(", ")
        steps.setdefault(step, []).append(start)
    return [f"{step}, from {', '.join(s)}" if all(s) else step for step, s in steps.items()]


def _plant(motion: str, s: ParameterSet, fit: Fit | None, shown: Any) -> dict[str, Any]:
    title = figures.title_of(motion)
    if fit is None:
        measured = any(isinstance(p.provenance, Fitted) for p in s.parameters.values())
        as_is = "as given" if s.effects or measured else "as declared"
        note = f"{s.title}. No recordings were given for this motion: the parameters are {as_is}."
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
