"""The tuner in JupyterLab, in Chromium: moved, the picture changes; limits turn red; gains are kept."""

import json
import shutil
import subprocess
import sys
import tomllib

import pytest

pytestmark = [
    pytest.mark.suite,
    pytest.mark.skipif(shutil.which("chromium") is None, reason="no chromium: apt install chromium"),
]

RESPONSE = ".wrist-tuner .steps path.response.line1"
RED = "rgb(198, 40, 40)"
MARGINS_LIKE = "t => document.querySelectorAll('.wrist-tuner table')[1].innerText === t"
MARGINS_OTHER_THAN = MARGINS_LIKE.replace("===", "!==")


def drawn(page, selector):
    """What the first path of a selector looks like."""
    return page.locator(selector).first.get_attribute("d")


def until_drawn_anew(page, selector, before):
    page.wait_for_function(
        "([s, d]) => document.querySelector(s).getAttribute('d') !== d", arg=[selector, before]
    )


def turns(page, selector, value, what="color"):
    """Wait until what a selector finds first has a colour; a drawing may be made anew meanwhile."""
    from playwright.sync_api import expect

    expect(page.locator(selector).first).to_have_css(what, value, timeout=30_000)


def point(page):
    circle = page.locator(".wrist-tuner .map circle.point")
    return float(circle.get_attribute("cx")), float(circle.get_attribute("cy"))


def test_keys_and_mouse_move_a_slider_and_the_response_follows(shown, put, tmp_path):
    page = shown.page
    before, at = drawn(page, RESPONSE), point(page)
    page.get_by_role("slider", name="Kp", exact=True).focus()
    for _ in range(10):
        page.keyboard.press("ArrowRight")
    until_drawn_anew(page, RESPONSE, before)
    assert point(page)[0] > at[0]
    assert point(page)[1] == at[1]

    before, at = drawn(page, RESPONSE), point(page)
    slider = page.get_by_role("slider", name="Ki", exact=True)
    box = slider.bounding_box()
    y, start = box["y"] + box["height"] / 2, float(slider.input_value()) / 400
    page.mouse.move(box["x"] + 8 + start * (box["width"] - 16), y)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.6 * box["width"], y, steps=12)
    page.mouse.up()
    until_drawn_anew(page, RESPONSE, before)
    assert point(page)[1] < at[1]  # higher on the screen
    page.screenshot(path=tmp_path / "moved.png")


def test_the_point_on_the_map_can_be_dragged(shown):
    page = shown.page
    before, box = drawn(page, RESPONSE), page.locator(".wrist-tuner .map").bounding_box()
    x, y = point(page)
    page.mouse.move(box["x"] + x, box["y"] + y)
    page.mouse.down()
    page.mouse.move(box["x"] + x + 60, box["y"] + y - 40, steps=5)
    page.mouse.up()
    until_drawn_anew(page, RESPONSE, before)
    assert point(page) == pytest.approx((x + 60, y - 40), abs=2.0)
    assert float(page.get_by_label("Kp in kPa/deg").input_value()) > 1.2


def test_of_a_hasty_drag_the_last_position_is_shown(shown, put):
    page, margins = shown.page, shown.page.locator(".wrist-tuner .tables table").nth(1)
    at_rest = margins.inner_text()
    put("Dead time in ms", "150")
    shown.settle()
    at_150_ms = margins.inner_text()
    assert at_150_ms != at_rest
    put("Dead time in ms", "0")
    shown.settle()
    assert margins.inner_text() == at_rest
    # All positions of a drag at once: those that Python has no time for are left out, the last is not.
    page.get_by_role("slider", name="Dead time").evaluate(
        "e => { for (let v = 1; v <= 150; v++) { e.value = v; e.dispatchEvent(new Event('input')); } }"
    )
    page.wait_for_function(MARGINS_LIKE, arg=at_150_ms)


def test_a_violated_limit_turns_red_and_says_so(shown, put, tmp_path):
    page = shown.page
    assert page.locator(".wrist-tuner .violated").count() == 0
    put("Ki in kPa/(deg s)", "80")
    page.locator(".wrist-tuner td.violated").first.wait_for()
    assert page.locator(".wrist-tuner .status").inner_text().startswith("▲ Violated: ")
    row = page.locator(".wrist-tuner .tables tr", has_text="Ms, peak")
    assert row.locator("td").first.inner_text().startswith("▲ ")
    assert "violated" in row.inner_text()
    turns(page, ".wrist-tuner td.violated", RED)
    turns(page, ".wrist-tuner .status", RED)
    turns(page, ".wrist-tuner .limit.Ms.violated", RED, "stroke")
    turns(page, ".wrist-tuner .point", RED, "fill")
    page.screenshot(path=tmp_path / "red.png")


def test_another_plant_has_another_map_and_margins_and_none_says_why(shown, put, tmp_path):
    page = shown.page
    held, margins = drawn(page, ".wrist-tuner .map .held"), page.locator(".wrist-tuner .tables table").nth(1)
    before = margins.inner_text()
    put("Dead time in ms", "60")
    until_drawn_anew(page, ".wrist-tuner .map .held", held)
    page.wait_for_function(MARGINS_OTHER_THAN, arg=before)
    put("Line slopes in times that of the wrist", "0.5")
    put("Transit slope in times that of the wrist", "3")
    page.get_by_text("No such plant: transit slope s = 0.1671 is not below a1 = 0.1425").wait_for()
    page.screenshot(path=tmp_path / "none.png")


def test_the_gains_are_kept_as_a_file_that_the_command_takes(shown, put, tmp_path):
    page = shown.page
    put("Kp in kPa/deg", "2.5")
    put("Ki in kPa/(deg s)", "6.5")
    page.get_by_label("Keep as").fill("mine")
    page.get_by_role("button", name="Keep gains").click()
    page.get_by_text("Written: ").wait_for()
    path = shown.folder / "mine.toml"
    assert str(path) in page.locator(".wrist-tuner .kept").inner_text()
    assert tomllib.loads(path.read_text())["gains"]["Kp"] == {"value": 2.5, "unit": "kPa/deg"}
    page.screenshot(path=tmp_path / "kept.png")

    def simulated(gains):
        command = ["simulate", "--axis", "deviation", "--gains", gains, "--json", "-"]
        done = subprocess.run([sys.executable, "-m", "design.cli", *command], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)["metrics"]

    assert simulated(str(path)) == simulated("2.5,6.5")


def test_a_file_of_somebody_else_is_not_touched(shown):
    page = shown.page
    other = shown.folder / "other.toml"
    other.write_text("mine = 1\n")
    page.get_by_label("Keep as").fill("other.toml")
    page.get_by_role("button", name="Keep gains").click()
    page.get_by_text("exists already; choose another name").wait_for()
    assert other.read_text() == "mine = 1\n"
    turns(page, ".wrist-tuner .kept", RED)


def test_it_fits_a_narrow_window_and_a_dark_page(shown, put, tmp_path):
    page = shown.page
    wide = page.viewport_size
    try:
        page.evaluate(
            "window.jupyterapp.commands.execute('apputils:change-theme', {theme: 'JupyterLab Dark'})"
        )
        page.locator(".wrist-tuner[data-theme='dark']").wait_for()
        for width in (1600, 900, 480):
            page.set_viewport_size({"width": width, "height": 1100})
            page.wait_for_timeout(500)
            over = page.locator(".wrist-tuner").evaluate("e => e.scrollWidth - e.clientWidth")
            page.screenshot(path=tmp_path / f"dark-{width}.png")
            assert over <= 0
    finally:
        page.set_viewport_size(wide)
        page.evaluate(
            "window.jupyterapp.commands.execute('apputils:change-theme', {theme: 'JupyterLab Light'})"
        )
        page.locator(".wrist-tuner[data-theme='light']").wait_for()
