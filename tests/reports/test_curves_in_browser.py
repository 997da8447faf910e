"""A figure answers in a browser: the pointer over a curve names and reads it, its label
switches it off and on, by the keyboard too; on paper every curve is there."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from reports.shared.figures.style import new_figure, styled, svg
from reports.shared.html import Shown, markup
from tests.reports.test_in_browser import CHROMIUM, Opened, browser, page_of  # noqa: F401

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium")

SLOW, QUICK = "paper's PI", "recommended PI"
SCRIPT = Path(__file__).parents[2] / "reports" / "templates" / "curves.js"


@pytest.fixture(scope="module")
def drawn():
    """A line y = 2 x with its name beside it, and on logarithmic axes another with a legend."""
    x = np.linspace(1.0, 10.0, 50)
    with styled():
        figure, (plain, log) = new_figure(1, 2)
        plain.plot(x, 2.0 * x, gid=SLOW)
        plain.plot(x, 4.0 + 0.0 * x, gid=QUICK)
        plain.annotate(SLOW, (8.0, 16.0), (2.0, 18.0), arrowprops={"arrowstyle": "-"})
        plain.set(xlabel="Time [s]", ylabel="Angle [deg]", ylim=(0.0, 22.0))
        log.loglog(x, x**2, label=QUICK)
        log.set(xlabel="Frequency [rad/s]", ylabel="|S| [1]")
        log.legend()
    return figure


@pytest.fixture(scope="module")
def page(drawn, tmp_path_factory) -> Path:
    shown = Shown(markup(svg(drawn, "curves")), "Two curves.")
    return page_of(shown, tmp_path_factory.mktemp("curves"))


@pytest.fixture
def tab(browser, page):  # noqa: F811
    with Opened(browser, page, 1100) as opened:
        yield opened.tab
        assert opened.complaints == []


def point_at(tab, drawn, panel: int, x: float, y: float) -> None:
    """Move the pointer to where matplotlib puts a point of a panel, given in data."""
    axes = drawn.axes[panel]
    across, up = drawn.transFigure.inverted().transform(axes.transData.transform((x, y)))
    tab.locator("svg.figure").scroll_into_view_if_needed()
    box = tab.locator("svg.figure").bounding_box()
    tab.mouse.move(box["x"] + across * box["width"], box["y"] + (1.0 - up) * box["height"])


def told(tab) -> tuple[str, list[float]]:
    """Name and values that are shown beside the pointer."""
    name, _, values = tab.locator(".tip").inner_text().partition(": ")
    return name, [float(v) for v in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", values)]


@pytest.mark.parametrize(
    ("panel", "x", "y", "name"), [(0, 3.0, 6.0, SLOW), (0, 7.5, 4.0, QUICK), (1, 4.0, 16.0, QUICK)]
)
def test_the_pointer_over_a_curve_names_and_reads_it(tab, drawn, panel, x, y, name):
    point_at(tab, drawn, panel, x, y)
    assert told(tab)[0] == name
    assert told(tab)[1] == pytest.approx([x, y], rel=0.02)


def test_values_carry_their_quantities_and_units(tab, drawn):
    point_at(tab, drawn, 0, 3.0, 6.0)
    assert re.search(r"Time [\d.]+ s, Angle [\d.]+ deg$", tab.locator(".tip").inner_text())


def test_away_from_every_curve_nothing_is_told(tab, drawn):
    point_at(tab, drawn, 0, 3.0, 6.0)
    point_at(tab, drawn, 0, 3.0, 15.0)
    assert not tab.locator(".tip").is_visible()


def visibility(tab, name: str) -> list[str]:
    curves = tab.locator("[data-curve]").all()
    return [
        c.evaluate("e => getComputedStyle(e).visibility")
        for c in curves
        if c.get_attribute("data-curve") == name
    ]


def test_a_legend_entry_switches_its_curve_off_in_every_panel_and_on_again(tab, drawn):
    label = tab.get_by_role("button", name=QUICK)
    label.click()
    assert visibility(tab, QUICK) == ["hidden", "hidden"]
    assert visibility(tab, SLOW) == ["visible"]
    assert label.get_attribute("aria-pressed") == "false"
    point_at(tab, drawn, 0, 7.5, 4.0)
    assert not tab.locator(".tip").is_visible()
    label.click()
    assert visibility(tab, QUICK) == ["visible", "visible"]


def test_a_name_beside_a_curve_is_reached_and_pressed_by_keys(tab):
    label = tab.get_by_role("button", name=SLOW)
    label.focus()
    tab.keyboard.press("Enter")
    assert visibility(tab, SLOW) == ["hidden"]
    tab.keyboard.press("Space")
    assert visibility(tab, SLOW) == ["visible"]


def test_arrow_keys_read_along_a_curve(tab):
    tab.get_by_role("button", name=SLOW).focus()
    read = []
    for _ in range(4):
        tab.keyboard.press("ArrowRight")
        name, (x, y) = told(tab)
        assert name == SLOW
        assert y == pytest.approx(2.0 * x, rel=0.02)
        read.append(x)
    assert read == sorted(set(read))
    tab.keyboard.press("Escape")
    assert not tab.locator(".tip").is_visible()


def test_on_paper_every_curve_is_there(tab):
    tab.get_by_role("button", name=QUICK).click()
    tab.emulate_media(media="print")
    assert visibility(tab, QUICK) == ["visible", "visible"]


def test_drawing_leaves_the_figure_as_it_was(drawn):
    once = svg(drawn, "same")
    assert [line.get_gid() for line in drawn.axes[0].lines] == [SLOW, QUICK]
    (panels,) = re.findall(r'data-panels="([^"]*)"', once)
    assert len(json.loads(panels.replace("&quot;", '"'))) == 2


def test_the_script_is_small():
    assert len(SCRIPT.read_bytes()) < 6500
