"""The trace as a page for a colleague, and beside it the same as JSON, TOML and pictures."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from design.synthesis.retune import Control
from plants.effects import EFFECTS
from plants.measured.trace.result import StageTrace, Trace
from reports.shared.card import Card
from reports.shared.figures.style import save, svg
from reports.shared.html import Made, Shown, markup, render
from reports.shared.plant_tables import assumption_table
from reports.trace import captions, control_words, tables, words
from reports.trace.fit_figures import draw_control, draw_errors, draw_loop, draw_series
from reports.trace.parameter_figure import draw_parameters, parameters_caption
from reports.trace.record import control_record, trace_record
from reports.trace.residual_figures import draw_description, draw_remainder
from reports.trace.search_figures import draw_ranking

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["trace_page", "write_trace"]


def write_trace(folder: str | Path, trace: Trace, made: Made, control: Control | None = None) -> Path:
    """Write trace.html, trace.json, revised.toml and the figures as PNG into a folder, each complete or
    not at all.  Returns the path of the page; raises InputError where it cannot be written."""
    from plants.files import json_text, write_atomically
    from plants.parameters.files import dump

    folder = Path(folder)
    drawn = draw_all(trace, control)
    page = _page(trace, made, control, drawn)
    for name, figure in drawn.items():
        save(figure, folder / f"{name}.png")
    record = trace_record(trace, None if control is None else control_record(control))
    write_atomically(folder / "trace.json", json_text(record))
    dump(trace.revised, folder / "revised.toml")
    write_atomically(folder / "trace.html", page)
    return folder / "trace.html"


def trace_page(trace: Trace, made: Made, control: Control | None = None) -> str:
    """The whole trace as one self-contained HTML text."""
    return _page(trace, made, control, draw_all(trace, control))


def draw_all(trace: Trace, control: Control | None = None) -> dict[str, "Figure"]:
    """The figures of a trace by the names of their files."""
    found: dict[str, Figure | None] = {"errors": draw_errors(trace)}
    found |= {f"fit-{c.split('_')[0]}": draw_series(trace, c) for c in shown_channels(trace)}
    found["loop"] = draw_loop(trace)
    found["parameters"] = draw_parameters(trace)
    for s in trace.stages:
        found[f"left-{s.name}"] = draw_remainder(s, captions.after_name(trace).removeprefix("the "))
        found[f"ranking-{s.name}"] = draw_ranking(s)
    found |= {f"unexplained-{s.name}": draw_description(s) for s in trace.unexplained}
    if control is not None:
        found["control"] = draw_control(control)
    return {name: figure for name, figure in found.items() if figure is not None}


def shown_channels(trace: Trace) -> list[str]:
    """Channels to draw over time: the angle, and the pressure where something was found in it or where
    there is no angle."""
    by_channel = {s.stage.channel: s for s in trace.stages}
    quiet = "angle_deg" in by_channel and not _busy(by_channel.get("pressure_kPa"))
    return [c for c in ("angle_deg", "pressure_kPa") if c in by_channel and not (c != "angle_deg" and quiet)]


def _busy(stage: StageTrace | None) -> bool:
    return stage is not None and bool(stage.model.forms or not stage.explained or stage.before.structured)


def _page(trace: Trace, made: Made, control: Control | None, drawn: Mapping[str, "Figure"]) -> str:
    def shown(name: str, caption: str) -> Shown:
        return Shown(markup(svg(drawn[name], name, caption)), caption)

    fits = [shown(f"fit-{c.split('_')[0]}", captions.series(trace, c)) for c in shown_channels(trace)]
    card = Card(
        tables.effect_table(trace), [tables.error_table(trace)], shown("errors", captions.errors(trace))
    )
    fits += [shown("loop", captions.loop(trace))] if "loop" in drawn else []
    return render(
        "trace.html",
        title=captions.title(trace),
        kind=f"trace of the campaign “{trace.campaign.name}”, {trace.campaign.axis}",
        summary=words.summary(trace), remarks=words.log_words(trace), sections=_sections(trace, control),
        verdict_words=words.verdict_sentence(trace), block_words=words.block_words(trace),
        declared_law=trace.fit.fitted.law.NAME, after_words=captions.after_words(trace),
        choice_words=captions.choice_words(),
        decision=card,
        recordings=tables.recording_table(trace), fit_figures=fits,
        stages=[_stage(s, captions.after_name(trace), shown) for s in trace.stages],
        plant_words=captions.plant_words(trace), parameters=tables.parameter_table(trace),
        assumed=assumption_table({trace.campaign.axis: trace.revised}),
        parameter_figure=shown("parameters", parameters_caption(trace)) if "parameters" in drawn else None,
        separations=[s for e in trace.effects for s in e.separations],
        no_alternatives=captions.no_alternatives(trace),
        judge=tables.judge_table(trace.cannot_judge) if trace.cannot_judge else None, count=len(EFFECTS),
        unexplained=[_unexplained(trace, s, shown) for s in trace.unexplained],
        control=None if control is None else _control(trace, control, drawn, shown),
        versions=captions.versions(), made=made,
    )  # fmt: skip


def _sections(trace: Trace, control: Control | None) -> dict[str, str]:
    """Titles of the page's sections by their ids."""
    left = "Residuals of the declared model" + (" and of the revised one" if trace.effects else "")
    return {
        "errors": "Errors before and after",
        "fit": "Measured and simulated",
        "plant": "The revised plant" if trace.effects or trace.block else "The plant",
        **({} if control is None else {"control": "Retuning"}),
        "doubt": "What is undecided",
        "left": left,
        "choice": "How effects are selected",
    }


def _stage(s: StageTrace, after: str, shown: Any) -> dict[str, Any]:
    refitted = any(r.candidates for r in s.search.rounds)
    return {
        "title": words.stage_title(s),
        "quiet": not _busy(s),
        "left": captions.left(s, after),
        "remainder": shown(f"left-{s.name}", captions.remainder(s, after)),
        "findings": tables.finding_table(s.before, s.after),
        "decisions": tables.decision_table(s.search.rounds) if refitted else None,
        "nothing": captions.nothing_refitted(s),
        "ranking": shown(f"ranking-{s.name}", captions.ranking(s)),
    }


def _unexplained(trace: Trace, s: StageTrace, shown: Any) -> dict[str, Any]:
    adopted = bool(trace.effects or trace.block)
    return {
        "title": f"of the {s.stage.channel.split('_')[0]}",
        "words": captions.what_is_left(s, adopted, trace.remainder.get(s.stage.channel)),
        "learnt": captions.learnt(s),
        "figure": shown(f"unexplained-{s.name}", captions.DESCRIPTION),
    }


def _control(trace: Trace, control: Control, drawn: Mapping[str, "Figure"], shown: Any) -> dict[str, Any]:
    caption = captions.control(control)
    return {
        "sentence": control_words.control_sentence(control),
        "caution": captions.CAUTION if trace.unexplained else "",
        "judge": control.judge,
        "table": tables.control_table(control) if "control" in drawn else None,
        "figure": shown("control", caption) if "control" in drawn else None,
    }
