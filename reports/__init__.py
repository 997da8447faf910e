"""Figures, tables and sentences of what was found; pages for a colleague who never runs anything.

>>> import reports
>>> reports.number(0.123456)
'0.123'

Names are imported when they are first used, so that the command starts fast.
"""

from typing import Any

from plants.facade import named

_HOMES = {  # the module of each name, and what it is called there where that is something else
    "BLACK": "reports.shared.figures.style",
    "CardRow": "reports.shared.card",
    "Cell": "reports.shared.tables",
    "DASHED": "reports.shared.figures.style",
    "DOTTED": "reports.shared.figures.style",
    "GREY": "reports.shared.figures.style",
    "LINES": "reports.shared.figures.style",
    "Markdown": "reports.notebooks.tables",
    "PAPER_FIGURES": "reports.paper.figures:FIGURES",
    "block_words": "reports.trace.words",
    "box_table": "reports.robustness.tables",
    "break_even_figure": "reports.comparison.contest.break_even_figure",
    "control_sentence": "reports.trace.control_words",
    "controller_line": "reports.shared.figures.style",
    "cycle_table": "reports.robustness.tables",
    "describing": "reports.robustness.branches.figures",
    "disagreement_sentences": "reports.robustness.disagreements",
    "draw_control": "reports.trace.fit_figures",
    "draw_envelopes": "reports.robustness.figures",
    "draw_errors": "reports.trace.fit_figures",
    "draw_fit": "reports.shared.figures.fit",
    "draw_gain_plane": "reports.robustness.figures",
    "draw_paper": "reports.paper.figures:draw",
    "draw_ranking": "reports.trace.search_figures",
    "draw_remainder": "reports.trace.residual_figures",
    "draw_series": "reports.trace.fit_figures",
    "draw_steps": "reports.shared.figures.decision_card",
    "draw_worst": "reports.robustness.figures",
    "error_table": "reports.shared.plant_tables",
    "errors_before_and_after": "reports.trace.tables:error_table",
    "gain_map": "reports.shared.figures.gain_map",
    "limit_name": "reports.shared.names",
    "limits_held": "reports.notebooks.tables",
    "limits_table": "reports.comparison.tables",
    "margin_table": "reports.robustness.tables",
    "matrix_table": "reports.shared.card",
    "new_figure": "reports.shared.figures.style",
    "number": "reports.shared.tables",
    "nyquist": "reports.robustness.branches.figures",
    "parameter_table": "reports.shared.plant_tables",
    "rows": "reports.notebooks.tables",
    "sensitivities": "reports.robustness.branches.figures",
    "shown": "reports.notebooks.tables",
    "styled": "reports.shared.figures.style",
    "tuning_table": "reports.comparison.tables",
    "verdict_sentence": "reports.trace.words",
    "word_growth": "reports.notebooks.figures",
    "worst_words": "reports.robustness.captions",
}
__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    return named("reports", _HOMES, name)
