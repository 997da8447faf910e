"""The comparison as a page for a colleague, and beside it the same as JSON, CSV and pictures."""

import re
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from design.comparison.break_even import BreakEven
from design.comparison.compare import FORWARD, Comparison
from design.contest import Contest
from design.controllers.pi import PI
from design.mpc.timing import Ledger
from design.studies.shown.cell_steps import CellSteps
from design.studies.study import Study
from design.synthesis.answer import Answer
from plants.measured.fitting.fit import Fit
from plants.parameters.quantities import Fitted, ParameterSet
from reports.comparison import captions, costs, figures, tables, words
from reports.comparison.contest import table as broad
from reports.comparison.contest.break_even_figure import break_even_figure
from reports.comparison.contest.words import sentences
from reports.comparison.designs import budgets, designs
from reports.comparison.record import comparison_record, contest_csv_text, csv_text
from reports.comparison.trade_off_figure import trade_off, trade_off_caption
from reports.paper import figures as paper
from reports.shared.card import CardRow, card, step_caption
from reports.shared.cells import cells
from reports.shared.figures.dead_time_figure import dead_time_figure
from reports.shared.figures.decision_card import draw_steps
from reports.shared.figures.fit import draw_fit
from reports.shared.figures.gain_map import gain_map
from reports.shared.figures.style import save, svg
from reports.shared.html import Made, Shown, markup, render
from reports.shared.names import COST_WORDS, WINDOW, title_of
from reports.shared.plant_tables import assumption_table, error_table, parameter_table
from reports.shared.tables import number, spaced

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["comparison_page", "write_comparison"]


def comparison_page(study: Study, made: Made) -> str:
    """The whole study as one self-contained HTML text; sections of what the study lacks are left out."""
    return _page(study, made, main_figures(study))


def write_comparison(folder: str | Path, study: Study, made: Made) -> Path:
    """Write comparison.html, .json and .csv, contest.csv where there was a contest, paper.html where the
    paper's figures were redrawn, and the main figures as PNG into a folder, each complete or not at all.
    Returns the path of the page; raises InputError where it cannot be written."""
    from plants.files import json_text, write_atomically

    folder = Path(folder)
    # Numbers first: a place that cannot be written to is told before anything is drawn.
    write_atomically(folder / "comparison.json", json_text(comparison_record(study, made)))
    write_atomically(folder / "comparison.csv", csv_text(study.comparison))
    drawn = main_figures(study)
    page = _page(study, made, drawn)
    for name, figure in drawn.items():
        save(figure, folder / f"{name}.png")
    if study.contest:
        write_atomically(folder / "contest.csv", contest_csv_text(study.contest))
    if study.redrawn:
        write_atomically(folder / "paper.html", paper_page(study, made))
    write_atomically(folder / "comparison.html", page)
    return folder / "comparison.html"


def main_figures(study: Study) -> dict[str, "Figure"]:
    """The figures of the comparison by the names of their files."""
    comparison = study.comparison
    rows = card_rows(study)
    found = {"decision": draw_steps(rows)} if rows else {}
    found |= {
        "worst-values": figures.worst_values(comparison),
        "loops": figures.loop_trajectories(comparison, study.question.wrists),
    }
    found["trade-off"] = trade_off(comparison)
    if study.late:
        sweeps = {title_of(m): sweep for m, sweep in study.late.items()}
        shown = {
            title_of(m): figures.coloured(comparison, m, [n for n in s.overshoot if n != FORWARD])
            for m, s in study.late.items()
        }
        found["dead-time"] = dead_time_figure(sweeps, comparison.limits.overshoot_percent, shown)
    found |= {f"steps-{slug(m)}": figures.step_responses(comparison, m) for m in study.motions}
    if study.contest:
        found["differences"] = broad.differences_figure(study.contest)
    found |= {f"break-even-{slug(m)}": break_even_figure(b) for m, b in (study.break_even or {}).items()}
    found |= {f"gains-{slug(m)}": gain_map(t) for m, t in study.tunings.items()}
    return found | {f"fit-{slug(m)}": draw_fit(f) for m, f in study.fits.items()}


def slug(motion: str) -> str:
    """A motion's name as part of an id or a file.

    >>> slug("left wrist/flexion")
    'left-wrist-flexion'
    """
    return re.sub(r"[^A-Za-z0-9_]+", "-", motion)[:60].strip("-") or "motion"


def _page(study: Study, made: Made, drawn: Mapping[str, "Figure"]) -> str:
    def shown(name: str, caption: str, data: Any = "") -> Shown:
        return Shown(markup(svg(drawn[name], name, caption)), caption, data)

    comparison, motions = study.comparison, study.motions
    least = {t.problem.cost for t in study.tunings.values()}
    assumed = assumption_table(study.plants)
    responses = [shown(f"steps-{slug(m)}", captions.steps_caption(comparison, m)) for m in motions]
    cards = card_rows(study)
    return render(
        "comparison.html", title=words.title(study), kind="comparison of controllers",
        remarks=[made.remark] if made.remark else [],
        summary=words.summary(study), sections=_sections(study),
        decision=card(cards, shown("decision", step_caption(cards))) if cards else None,
        step=comparison.rig.task.step, sample_ms=1000.0 * comparison.rig.sample_time,
        command_range=comparison.rig.command_range, window=WINDOW,
        band=100.0 * comparison.rig.task.band, tasks=_tasks(comparison),
        limits=tables.limits_table(comparison.limits),
        plants=[_plant(m, s, study.fits.get(m), shown) for m, s in study.plants.items()],
        cost=" and ".join(COST_WORDS.get(c, c) for c in sorted(least)),
        tunings=[_tuning(m, a, study.cells.get(m), shown) for m, a in study.answers.items()],
        designs=[(title_of(m), designs(comparison, m)) for m in motions if comparison.designs],
        standings=tables.standings_table(comparison),
        worst=shown("worst-values", captions.worst_caption(comparison)),
        trade_off=shown("trade-off", trade_off_caption(comparison)),
        late=shown("dead-time", captions.late_caption(study)) if study.late else None,
        paper_note=tables.paper_note(),
        contest=_contest(study, study.contest, shown) if study.contest else None,
        wrong=[_wrong(m, b, shown) for m, b in (study.break_even or {}).items()],
        times=_times(study.execution_times, comparison) if study.execution_times else None,
        responses=responses, loops=shown("loops", captions.loops_caption(comparison)),
        assumed=assumed, assumed_count=sum(len(g.rows) for g in assumed.groups),
        further=words.further(motions), motion_count=len(motions),
        made=made,
    )  # fmt: skip


def paper_page(study: Study, made: Made) -> str:
    """The figures of the paper by this model, as one self-contained HTML text."""
    return render(
        "paper.html", title="The paper's figures, redrawn by the model", kind="the paper redrawn",
        summary=words.paper_summary(study), remarks=[], sections={"paper": "Figures"}, paper=_paper(study),
        made=made,
    )  # fmt: skip


def card_rows(study: Study) -> list[CardRow]:
    """What the decision card shows, a row a motion that was decided on."""
    return [
        CardRow(
            d.motion, words.card_name(d), d.gains, d.matrix, d.evidence["proved"], d.band,
            words.reason(d),
        )
        for d in study.decisions.values()
    ]  # fmt: skip


def _sections(study: Study) -> dict[str, str]:
    """Titles of the page's sections by their ids, of those that there are."""
    titles = {
        "table": "The comparison",
        "steps": "Step responses",
        "contest": "Perturbed plants with a noisy sensor" if study.contest else "",
        "tuning": "How the PI was tuned",
        "asked": "Task and limits",
        "wrong": "Model errors and feedforward" if study.break_even else "",
        "times": "Execution times" if study.execution_times else "",
        "designs": "Other designs" if study.comparison.designs else "",
        "fit": "The plant and its fit" if study.fits else "The plant",
        "assumptions": "Assumptions",
    }
    return {name: title for name, title in titles.items() if title}


def _wrong(motion: str, found: BreakEven, shown: Any) -> dict[str, Any]:
    return {
        "title": title_of(motion),
        "figure": shown(f"break-even-{slug(motion)}", costs.break_even_caption(motion, found)),
        "table": costs.break_even_table(found),
    }


def _times(ledger: Mapping[str, Mapping[str, Ledger]], comparison: Comparison) -> dict[str, Any]:
    # Gains of a PI change no step of it: the first of them stands for all.
    pis = [s.controller for s in comparison.standings if set(s.settings) == {f.name for f in fields(PI)}]
    return {
        "words": costs.ledger_words(ledger),
        "table": costs.ledger_table(ledger, tuple(dict.fromkeys(pis))[1:]),
        "caption": costs.LEDGER, "note": costs.TIMES,
    }  # fmt: skip


def _contest(study: Study, contest: Contest, shown: Any) -> dict[str, Any]:
    overshoot = study.comparison.limits.overshoot_percent
    return {
        "said": [s[:1].upper() + s[1:] for s in sentences(contest)],
        "how": [*broad.how(contest), budgets(study.comparison, study.tunings)],
        "on_others": words.on_others(study.comparison, contest),
        "main": broad.main_table(contest, overshoot),
        "figure": shown("differences", broad.differences_caption(contest, study.comparison)),
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
    title = title_of(motion)
    if fit is None:
        measured = any(isinstance(p.provenance, Fitted) for p in s.parameters.values())
        as_is = "as given" if s.effects or measured else "as declared"
        note = f"{s.title}. No recordings were given for this motion: the parameters are {as_is}."
        none = {"errors": None, "misfit": "", "judged_on": "", "figure": None}
        return {"title": title, "words": note, "parameters": parameter_table(s), **none}
    apart = any(r.role == "validate" for r in fit.runs)
    return {
        "title": title,
        "words": words.fit_words(fit),
        "parameters": parameter_table(fit.fitted, fit.before),
        "errors": error_table(fit),
        "misfit": words.misfit(fit),
        "figure": shown(f"fit-{slug(motion)}", captions.fit_caption(motion, fit)),
        "judged_on": " on the held-out recordings" if apart else "",
    }


def _tuning(motion: str, answer: Answer, steps: CellSteps | None, shown: Any) -> dict[str, Any]:
    t = answer.tuning
    limits, gains = t.problem.limits.named, (t.Kp, t.Ki)
    known = "" if steps is None else cells(*t.region.grid, t.map, steps, limits, gains, t.problem.cost)
    return {
        "title": title_of(motion),
        "gains": f"Kp = {number(t.Kp)} kPa/deg, Ki = {number(t.Ki)} kPa/(deg s).",
        "found": words.found(answer),
        "evidence": words.evidence(answer),
        "table": tables.tuning_table(t),
        "figure": shown(f"gains-{slug(motion)}", captions.map_caption(motion, t), known),
    }


def _paper(study: Study) -> list[Shown]:
    """The figures of the paper, of its two motions."""
    found = []
    for which, panels in study.redrawn.items():
        drawing = svg(paper.draw(which, panels), f"paper-{which}", paper.FIGURES[which].title)
        found.append(Shown(markup(drawing), paper.caption(which, study.plants)))
    return found
