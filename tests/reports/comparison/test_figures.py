"""Figures of a comparison have axes with labels, units and data, and mark what they must."""

import re
from itertools import combinations

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from design.studies.study import Study
from reports.comparison import figures
from reports.comparison.trade_off_figure import trade_off
from reports.shared.figures import signals
from reports.shared.figures.fit import draw_fit, shown_run
from reports.shared.figures.gain_map import gain_map
from reports.shared.figures.style import CONTROLLER_LINES, FAINT, save, svg
from reports.shared.tables import number
from tests.reports.report_samples import small_study


@pytest.fixture(scope="module")
def compared() -> Study:
    return small_study()


def texts(figure) -> list[str]:
    """All text of a figure's axes and legends."""
    legends = [*figure.legends, *(a.get_legend() for a in figure.axes if a.get_legend())]
    found = [t.get_text() for legend in legends for t in legend.get_texts()]
    return found + [t.get_text() for a in figure.axes for t in a.texts]


def drawn(compared):
    """Every figure of a comparison by a name."""
    yield "steps", figures.step_responses(compared.comparison, "flexion")
    yield "loops", figures.loop_trajectories(compared.comparison, compared.question.wrists)
    yield "worst", figures.worst_values(compared.comparison)
    yield "trade-off", trade_off(compared.comparison)
    yield "map", gain_map(compared.tunings["flexion"])
    yield "fit", draw_fit(compared.fits["flexion"])


@pytest.mark.slow
def test_outer_axes_are_labelled_with_units_and_hold_data(compared):
    for name, figure in drawn(compared):
        labels = [x for a in figure.axes for x in (a.get_xlabel(), a.get_ylabel()) if x]
        assert len(labels) >= 2, name
        assert all(re.search(r"\[.+\]", x) for x in labels), (name, labels)
        for axes in figure.axes:
            assert axes.lines or axes.collections or axes.patches, name


@pytest.mark.slow
def test_steps_show_every_controller_until_the_end_of_the_window(compared):
    figure = figures.step_responses(compared.comparison, "deviation")
    names = {"recommended PI", "paper's PI (stand-in)", "SIMC", "AMIGO", "Ziegler-Nichols"}
    assert names | {"convex-concave PI", "robust LQI"} <= set(texts(figure))
    assert figure.axes[-1].get_xlim()[1] == 10.0
    for axes in figure.axes:
        curves = [line for line in axes.lines if len(line.get_xdata()) > 100]
        assert 4 <= len(curves) <= 8
        in_colour = [line for line in curves if line.get_color() != FAINT]
        assert (
            len(in_colour) == 2
        )  # the recommended PI and one more; all others are grey and named at the curve
        assert len({str(line._dash_pattern) for line in in_colour}) == 2  # told apart without colour


@pytest.mark.slow
def test_a_name_beside_a_curve_points_at_that_curve(compared):
    figure = figures.step_responses(compared.comparison, "deviation")
    for name, words in (("SIMC", "SIMC"), ("AMIGO", "AMIGO"), ("paper", "paper's PI (stand-in)")):
        (label,) = [t for a in figure.axes for t in a.texts if t.get_text() == words]
        t = compared.comparison.steps["deviation", name]
        assert np.interp(label.xy[0], t.time, t.angle[:, 0]) == pytest.approx(label.xy[1], abs=0.1)


def test_every_controller_has_a_colour_of_its_own():
    colours = [look["color"] for look in CONTROLLER_LINES.values()]
    assert len(set(colours)) == len(colours)
    values = [np.array(to_rgb(c)) for c in colours]
    assert min(np.abs(a - b).max() for a, b in combinations(values, 2)) > 0.1


@pytest.mark.slow
def test_the_map_marks_the_gains_that_matter(compared):
    tuning = compared.tunings["flexion"]
    figure = gain_map(tuning)
    words = texts(figure)
    for name in (
        "SIMC",
        "AMIGO",
        "Ziegler-Nichols",
        "paper's PI (stand-in), its range",
        "end of a local search",
    ):
        assert name in words
    axes = figure.axes[0]
    assert axes.get_xscale() == axes.get_yscale() == "log"
    points = [line.get_xydata()[0] for line in axes.lines if len(line.get_xydata()) == 1]
    assert any(np.allclose(p, (tuning.Kp, tuning.Ki)) for p in points)
    assert any(" > " in w for w in words)  # a limit that some gains break


@pytest.mark.slow
def test_worst_values_that_never_settle_are_drawn_at_the_edge(compared):
    figure = figures.worst_values(compared.comparison)
    assert figure.axes[0].get_xlim()[0] == 0.0
    assert any(line.get_marker() == ">" for line in figure.axes[0].lines)


@pytest.mark.slow
def test_a_fit_is_shown_on_a_recording_that_took_no_part(compared):
    fit = compared.fits["flexion"]
    assert shown_run(fit).role == "validate"
    assert "held out" in draw_fit(fit).axes[0].get_title(loc="left")


def test_signals_are_drawn_with_what_is_there():
    time = np.arange(100) / 100.0
    result = {
        "time_s": time,
        "angle_deg": time,
        "pressure_kPa": time,
        "command_V": time,
        "measured_angle_deg": None,
    }
    figure = signals.draw(result, "a run")
    assert [a.get_ylabel() for a in figure.axes] == ["Angle [deg]", "Pressure [kPa]", "Command [V]"]
    assert len(figure.axes[0].lines) == 1


@pytest.mark.slow
def test_drawing_leaves_no_trace_in_the_settings_of_matplotlib(compared):
    before = dict(matplotlib.rcParams)
    svg(figures.worst_values(compared.comparison), "worst")
    assert dict(matplotlib.rcParams) == before


@pytest.mark.slow
def test_figures_are_saved_the_same_each_time_as_png_or_svg(compared, tmp_path):
    for ending in ("png", "svg"):
        one = save(figures.worst_values(compared.comparison), tmp_path / "a" / f"x.{ending}", dpi=40)
        other = save(figures.worst_values(compared.comparison), tmp_path / "b" / f"x.{ending}", dpi=40)
        assert one.read_bytes() == other.read_bytes()
    with pytest.raises(ValueError, match=r"png or \.svg"):
        save(figures.worst_values(compared.comparison), tmp_path / "x.pdf")


@pytest.mark.slow
def test_an_id_that_is_none_is_refused(compared):
    with pytest.raises(ValueError, match="cannot go before an id"):
        svg(figures.worst_values(compared.comparison), "a b")


@pytest.mark.parametrize(
    ("value", "text"), [(1e-9, "1e-09"), (123456.0, "123000"), (float("inf"), "∞"), (0.0, "0"), (9.999, "10")]
)
def test_numbers_read_well(value, text):
    assert number(value) == text
