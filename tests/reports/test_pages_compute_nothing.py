"""Pages are handed what they show: nothing under reports simulates, tunes, searches or samples."""

import ast
from pathlib import Path

import pytest

REPORTS = Path(__file__).parents[2] / "reports"
COMPUTES = {
    "run", "play", "simulate", "tune", "retune", "compare", "contest", "study", "assess", "monte_carlo",
    "envelopes", "worst_case", "evaluate", "rollouts", "gain_plane", "break_even", "deadlines", "limit",
    "limit_cycles", "predicted", "certify", "trace_campaign", "fit_campaign", "branch_responses",
    "by_python_control",
}  # fmt: skip
"""Functions that take their time; who calls one belongs under design."""


@pytest.mark.parametrize("path", sorted(REPORTS.rglob("*.py")), ids=lambda p: str(p.relative_to(REPORTS)))
def test_no_page_computes_what_it_shows(path):
    calls = [n.func for n in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(n, ast.Call)]
    plain = {f.id for f in calls if isinstance(f, ast.Name)}
    methods = {f.attr for f in calls if isinstance(f, ast.Attribute)}
    assert not plain & COMPUTES
    assert not methods & {"simulate"}
