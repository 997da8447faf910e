"""Robustness as a page for a colleague, and beside it the same as JSON, pictures and a scenario."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from design.robustness.samples.scenario_file import save as save_scenario
from design.studies.robustness_study import RobustnessStudy
from reports.robustness import captions, tables, words
from reports.robustness import figures as robust_figures
from reports.robustness.branches import figures as branches
from reports.robustness.branches.signature import COMPARED, signature
from reports.robustness.disagreements import disagreement_sentences
from reports.robustness.load_figure import load_caption, load_figure
from reports.robustness.record import assessment_record
from reports.shared.card import card
from reports.shared.cells import cells
from reports.shared.figures.dead_time_figure import dead_time_figure
from reports.shared.figures.style import save, svg
from reports.shared.html import Made, Shown, markup, render
from reports.shared.plant_tables import assumption_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["robust_page", "write_robust"]

FIRST = {"samples": captions.envelope_caption, "worst": captions.worst_caption}
"""Caption of the figure on the card: the samples, or the worst scenario where none could be drawn."""

SECTIONS = {
    "branches": "The loop on every branch",
    "verdict": "Statements and evidence",
    "gains": "Gain plane",
    "worst": "The worst scenario found",
    "samples": "Samples",
    "margins": "Margins on every branch",
    "cycles": "Limit cycles",
    "certificates": "Certificates",
    "box": "Box and assumptions",
}
"""Titles of the page's sections by their ids."""


def write_robust(folder: str | Path, study: RobustnessStudy, made: Made) -> Path:
    """Write robust.html, robust.json, worst.toml and the figures as PNG into a folder, each complete or
    not at all.  Returns the path of the page; raises InputError where it cannot be written."""
    from plants.files import json_text, write_atomically

    folder = Path(folder)
    drawn = draw_all(study)
    page = _page(study, made, drawn)
    for name, figure in drawn.items():
        save(figure, folder / f"{name}.png")
    write_atomically(folder / "robust.json", json_text(assessment_record(study.assessment)))
    save_scenario(study.assessment.worst, folder / "worst.toml")
    write_atomically(folder / "robust.html", page)
    return folder / "robust.html"


def robust_page(study: RobustnessStudy, made: Made) -> str:
    """The whole study as one self-contained HTML text."""
    return _page(study, made, draw_all(study))


def draw_all(study: RobustnessStudy) -> dict[str, "Figure"]:
    """The figures by the names of their files."""
    a = study.assessment
    marks = {"these gains": (float(a.controller.Kp), float(a.controller.Ki)), **study.gains}
    found = {
        "signature": signature(a.wrist, study.branches, a.limits),
        "dead-time": dead_time_figure({"": study.branches.late}, a.limits.overshoot_percent, {"": COMPARED}),
        "gains": robust_figures.draw_gain_plane(study.plane, a.limits, marks),
        "nyquist": branches.nyquist(a.wrist, {"these gains": a.controller}),
        "bode": branches.bode(a.wrist, a.controller),
        "sensitivities": branches.sensitivities(a.wrist, a.controller, a.limits),
        "describing": branches.describing(a.wrist, a.controller, a.cycles),
        "worst": robust_figures.draw_worst(a.worst, study.worst_run),
    }
    if study.load is not None:
        found["load"] = load_figure(study.load)
    if study.envelopes is not None:
        found["samples"] = robust_figures.draw_envelopes(
            study.envelopes, a.wrist.rig.task.step, a.wrist.rig.task.band
        )
    return found


def _page(study: RobustnessStudy, made: Made, drawn: Mapping[str, "Figure"]) -> str:
    a = study.assessment

    def shown(name: str, caption: str, data: Any = "") -> Shown:
        return Shown(markup(svg(drawn[name], name, caption)), caption, data)

    plane, gains = study.plane, (float(a.controller.Kp), float(a.controller.Ki))
    known = cells(plane.Kp, plane.Ki, plane.at, study.cells, a.limits.named, gains)
    row = words.card_row(study)
    first = "samples" if "samples" in drawn else "worst"
    content: dict[str, Any] = {
        "title": words.title(a),
        "kind": f"robustness of a PI, {a.box.plant.axis}",
        "sections": SECTIONS,
        "summary": words.summary(a),
        "remarks": words.remarks(a),
        "details": words.details(a),
        "decision": card([row], shown(first, FIRST[first](a))),
        "verdict": tables.verdict_table(a),
        "disagreements": disagreement_sentences(a),
        "plane": shown("gains", captions.plane_caption(a), known),
        "signature": shown("signature", captions.signature_caption(a)),
        "late": shown("dead-time", captions.late_caption(a, study.branches.late, COMPARED)),
        "load": shown("load", load_caption(study.load)) if study.load is not None else None,
        "margins": tables.margin_table(a),
        "nyquist": shown("nyquist", captions.nyquist_caption(a)),
        "bode": shown("bode", captions.bode_caption(a)),
        "sensitivities": shown("sensitivities", captions.sensitivities_caption(a)),
        "model_words": captions.model_words(a),
        "ladder": tables.ladder_table(a),
        "claims": captions.claims(a),
        "constant": tables.constant_table(a),
        "region": captions.region(a),
        "describing": shown("describing", captions.describing_caption(a)),
        "cycles": tables.cycle_table(a.cycles) if a.cycles else None,
        "no_cycles": captions.NO_CYCLES,
        "sample_words": captions.sample_words(a),
        "violations": tables.violation_table(a.cases),
        "quantiles": tables.quantile_table(a.cases),
        "worst_words": captions.worst_words(a),
        "worst": shown("worst", captions.worst_caption(a)) if first != "worst" else None,
        "box": tables.box_table(a.box),
        "assumptions": captions.assumptions(a),
        "assumed": assumption_table({a.box.plant.axis: a.box.plant}),
    }
    return render("robust.html", made=made, **content)
