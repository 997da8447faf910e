"""In every figure of every page all text is within the canvas, and none lies over another."""

import pytest
from matplotlib.figure import Figure

from reports.comparison.page import main_figures
from reports.robustness import page as robust
from reports.trace import page as trace
from tests.reports.legible import faults
from tests.reports.report_samples import small_robustness, small_trace, whole_study

ROOMS = {
    "comparison": lambda: main_figures(whole_study()),
    "robustness": lambda: robust.draw_all(small_robustness()),
    "trace": lambda: trace.draw_all(small_trace()),
}


@pytest.mark.parametrize("room", ROOMS)
def test_no_text_leaves_the_canvas_or_overlaps_another(room):
    found = {name: said for name, figure in ROOMS[room]().items() if (said := faults(figure))}
    assert found == {}


def test_a_fault_is_found_where_there_is_one():
    figure = Figure(figsize=(3, 2))
    figure.text(0.5, 0.5, "one")
    figure.text(0.52, 0.51, "other")
    figure.text(0.95, 0.2, "far too long for here")
    assert len(faults(figure)) == 2
