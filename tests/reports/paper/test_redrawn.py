"""The paper's figures are drawn from the model alone, labelled with units, and say what they rest on."""

import json
import re

import numpy as np
import pytest

from design.studies.paper import SERIES, series
from plants import Wrist, built_in
from reports.paper import figures as paper
from reports.shared.figures.style import svg

NUMBERS = (5, 6, 8, 10, 11, 12, 13, 14, 15)


@pytest.fixture(scope="module")
def wrists() -> tuple[Wrist, Wrist]:
    return Wrist.flexion(), Wrist.deviation()


def test_nine_figures_can_be_redrawn():
    assert tuple(paper.FIGURES) == tuple(SERIES) == NUMBERS


@pytest.mark.parametrize("number", NUMBERS)
def test_every_axis_has_a_label_with_a_unit_and_data(number, wrists):
    figure = paper.draw(number, series(number, *wrists))
    assert figure.axes
    for axes in figure.axes:
        assert any(len(line.get_xdata()) > 1 for line in axes.get_lines())
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert not label or re.search(r"\[(kPa|deg|s|V)\]$", label), label
    labels = [axes.get_xlabel() for axes in figure.axes], [axes.get_ylabel() for axes in figure.axes]
    assert all(any(side) for side in labels)


@pytest.mark.parametrize("number", NUMBERS)
def test_data_are_what_is_drawn(number, wrists):
    record = json.loads(json.dumps(paper.data(number, series(number, *wrists)), allow_nan=False))
    drawn = [
        np.round(np.asarray(line.get_ydata(), float), 6)
        for axes in paper.draw(number, series(number, *wrists)).axes
        for line in axes.get_lines()
    ]
    for panel in record["panels"]:
        for s in panel["series"]:
            assert len(s["x"]) == len(s["y"]) > 1
            assert any(y.size == len(s["y"]) and np.allclose(y, s["y"], atol=1e-6) for y in drawn), s["name"]


@pytest.mark.parametrize("number", NUMBERS)
def test_captions_name_every_assumed_parameter_and_the_lost_measurement(number):
    words = paper.caption(number)
    assert "measured curve of the paper is not available" in words
    for name in set(paper.FIGURES[number].names) & set(built_in("flexion").assumed):
        assert re.search(rf"\b{name}\b", words)
    assert ("no assumed parameter" in words) == (number in (5, 6))
    assert ("Kp = 1.2 kPa/deg" in words) == (number in (14, 15))


def test_a_fitted_parameter_is_no_longer_called_assumed():
    s = built_in("flexion")
    fitted = s.fitted({"a1": 0.4}, {"a1": 0.01}, "rig")
    words = paper.caption(12, {"flexion": fitted, "deviation": built_in("deviation")})
    assert "Fitted to data: a1 of palmar/dorsal flexion." in words
    assert "parameters w1, a2, w2 of palmar/dorsal flexion" in words


def test_steady_pressure_is_proportional_to_the_command(wrists):
    points = series(5, *wrists)[0].series[1]
    assert points.x.tolist() == [0.5 * i for i in range(9)]
    np.testing.assert_allclose(points.y, 49.4 * points.x, atol=0.01)


def test_the_variable_model_ends_where_the_lag_does_but_later(wrists):
    panel = series(8, *wrists)[0]
    lag, variable = panel.named("lag of 0.111 s"), panel.named("variable P model")
    at = [int(np.searchsorted(lag.x, t)) for t in (1.0, 11.9)]
    assert lag.y[at[0]] - variable.y[at[0]] > 1.0
    assert abs(lag.y[at[1]] - variable.y[at[1]]) < 0.05


def test_the_simulated_points_of_the_initial_motion_lie_on_the_virgin_curve(wrists):
    for panel in series(10, *wrists):
        curve, points = panel.named("virgin curve"), panel.named("held for 20 s")
        np.testing.assert_allclose(points.y, np.interp(points.x, curve.x, curve.y), atol=0.02)
        assert points.x[-1] == pytest.approx(197.6, abs=0.05)  # 200 kPa are out of reach of 4 V


def test_the_loop_closes_and_has_two_angles_at_one_pressure(wrists):
    for panel in series(12, *wrists):
        y = panel.named("steady states").y
        assert y[1] == pytest.approx(y[9], abs=0.02)  # 150 kPa, going up, before and after the loop
        assert y[3] - y[1] > 4.0  # 150 kPa, coming down


def test_regulators_that_differ_are_drawn_each(wrists):
    flexion, deviation = wrists[0], wrists[1].with_values(k_slow=2.0)
    names = [s.name for s in series(8, flexion, deviation)[0].series]
    assert "variable P model, flexion" in names
    assert "variable P model, deviation" in names


def test_a_figure_that_is_no_graph_of_the_model_is_refused(wrists):
    with pytest.raises(ValueError, match=r"Fig\. 9 cannot be redrawn; one of 5, 6"):
        paper.draw(9, series(9, *wrists))


def test_the_same_figure_gives_the_same_svg_and_ids_of_its_own(wrists):
    texts = [svg(paper.draw(5, series(5, *wrists)), "one") for _ in range(2)]
    other = svg(paper.draw(5, series(5, *wrists)), "other")
    assert texts[0] == texts[1]

    def ids(text: str) -> set[str]:
        return set(re.findall(r'\bid="([^"]+)"', text))

    assert ids(texts[0])
    assert not ids(texts[0]) & ids(other)
    used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', texts[0]))
    assert used <= ids(texts[0])
