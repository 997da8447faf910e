"""A map of gains answers in a browser: a click on a cell shows its step and margins, the arrow keys go on to
the next; without the script and on paper the map is a figure as any other."""

from pathlib import Path

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.scenarios import tuning_scenarios
from design.evaluation.steps import run
from design.studies.shown.cell_steps import cell_steps
from design.synthesis.evaluate import evaluate
from design.synthesis.requirements import Problem
from plants import Wrist
from plants.simulation.disturbance import burdened
from reports.shared.cells import cells
from reports.shared.figures.style import new_figure, styled, svg
from reports.shared.html import Shown, markup
from reports.shared.tables import number
from tests.reports.test_in_browser import CHROMIUM, Opened, browser, page_of  # noqa: F401

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium")

WRIST = Wrist.flexion()
KP, KI = np.geomspace(1.0, 16.0, 5), np.geomspace(2.0, 50.0, 4)
LIMITS = {"Ms": 1.6, "delay_margin_s": 0.2}
SCRIPT = Path(__file__).parents[2] / "reports" / "templates" / "cells.js"


@pytest.fixture(scope="module")
def evaluated():
    """What limits are held against, and the steps, of each cell."""
    rows, columns = (g.ravel() for g in np.meshgrid(KP, KI, indexing="ij"))
    problem = Problem.of(WRIST, tuning_scenarios(WRIST)[:2], duration=4.0)
    return evaluate(problem, rows, columns), cell_steps(WRIST, PI(rows, columns))


@pytest.fixture(scope="module")
def page(evaluated, tmp_path_factory) -> Path:
    with styled():
        figure, (axes,) = new_figure()
        axes.set(xscale="log", yscale="log", xlim=KP[[0, -1]], ylim=KI[[0, -1]])
        axes.plot(2.0, 5.0, "*", label="star")
    shown = Shown(markup(svg(figure, "map")), "A map.", cells(KP, KI, *evaluated, LIMITS, (2.1, 5.5), "iae"))
    return page_of(shown, tmp_path_factory.mktemp("cells"))


@pytest.fixture
def tab(browser, page):  # noqa: F811
    with Opened(browser, page, 1100) as opened:
        yield opened.tab
        assert opened.complaints == []


def click(tab, i: int, j: int) -> None:
    """Click where the cell of the i-th Kp and the j-th Ki lies."""
    place = tab.evaluate(
        """([x, y]) => {
          const svg = document.querySelector('svg[data-panels]'), panel = JSON.parse(svg.dataset.panels)[0];
          const [px, py] = [x, y].map((share, i) => panel[i].from + share * (panel[i].to - panel[i].from));
          svg.scrollIntoView();
          const at = new DOMPoint(px, py).matrixTransform(svg.getScreenCTM());
          return [at.x, at.y];
        }""",
        [i / (KP.size - 1), j / (KI.size - 1)],
    )
    tab.mouse.click(*place)


def gains_shown(tab) -> str:
    return tab.locator(".cell p").inner_text().partition(" Click")[0]


def gains(i: int, j: int) -> str:
    return f"Cell of Kp {number(KP[i])} kPa/deg, Ki {number(KI[j])} kPa/(deg s)."


def test_the_cell_of_the_chosen_gains_is_shown_first(tab):
    assert gains_shown(tab) == gains(1, 1)


@pytest.mark.parametrize(("i", "j"), [(2, 3), (4, 0), (0, 2)])
def test_a_click_shows_what_the_limits_of_a_cell_are_held_against(tab, evaluated, i, j):
    at, cell = evaluated[0], i * KI.size + j
    click(tab, i, j)
    assert gains_shown(tab) == gains(i, j)
    shown = dict(r.split("\t") for r in tab.locator(".cell table").inner_text().splitlines())
    Ms, delay = at.values["Ms"][cell], at.values["delay_margin_s"][cell]
    assert shown["Ms"] == ("▲ " if Ms > LIMITS["Ms"] else "") + number(Ms)
    assert shown["Delay margin [s]"] == ("▲ " if delay < LIMITS["delay_margin_s"] else "") + number(delay)
    assert shown["Worst IAE [deg s]"] == number(at.cost[cell])


def test_some_cells_break_a_limit_and_some_do_not(evaluated):
    Ms = evaluated[0].values["Ms"]
    assert (Ms > LIMITS["Ms"]).any()
    assert (Ms < LIMITS["Ms"]).any()


def test_the_step_that_is_drawn_is_the_step_of_the_cell(tab, evaluated):
    click(tab, 2, 3)
    steps = evaluated[1]
    for number_, late in enumerate((None, 0.05)):
        plant, pi = burdened(WRIST, late, None), PI(KP[2], KI[3])
        whole = run(plant, pi, 15.0, duration=3.0, record=True)[2]
        angle = np.interp(steps.time, whole.time, whole.angle[:, 0])
        points = tab.locator(f".cell .way{number_}").first.get_attribute("points")
        x, y = np.array([p.split(",") for p in points.split()], float).T
        slope, offset = np.polyfit(angle, y, 1)
        assert np.ptp(angle) > 10.0
        assert np.abs(slope * angle + offset - y).max() < 0.01 * np.ptp(y)
        assert np.allclose(np.diff(x) / np.diff(steps.time), np.ptp(x) / np.ptp(steps.time), rtol=0.05)


def test_arrow_keys_go_to_the_next_cell_and_stop_at_the_edge(tab):
    tab.locator("svg[data-panels]").focus()
    way = {"Right": (2, 1), "Up": (2, 2), "Left": (1, 2), "Down": (1, 1)}
    for key, cell in [*way.items(), ("Down", (1, 0)), ("Down", (1, 0))]:
        tab.keyboard.press(f"Arrow{key}")
        assert gains_shown(tab) == gains(*cell)


def test_on_paper_the_map_is_a_figure_as_any_other(tab):
    assert tab.locator(".cell").is_visible()
    tab.emulate_media(media="print")
    assert not tab.locator(".cell").is_visible()
    assert not tab.locator(".cell-mark").is_visible()


def test_without_the_script_nothing_of_the_cells_is_seen(browser, page):  # noqa: F811
    tab = browser.new_page(java_script_enabled=False)
    tab.goto(page.as_uri())
    assert tab.locator("svg[data-panels]").is_visible()
    assert tab.locator(".cell").count() == 0
    assert "Worst IAE" not in tab.locator("body").inner_text()
    tab.close()


def test_the_script_is_small():
    assert len(SCRIPT.read_bytes()) < 5500
