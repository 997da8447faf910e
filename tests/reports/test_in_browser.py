"""Every page opens in a browser as it should: nothing overflows, no figure is missing, nothing is asked for
from elsewhere, and it can be printed."""

import re
import zlib
from pathlib import Path

import pytest

from reports.shared.figures.direct_labels import SIZE
from reports.shared.html import Made, Shown, render

sync_api = pytest.importorskip("playwright.sync_api")

EXAMPLES = Path(__file__).parents[2] / "reports" / "examples"
CHROMIUM = next((p for p in map(Path, ("/usr/bin/chromium", "/usr/bin/google-chrome")) if p.exists()), None)
QUIET = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update",
)  # fmt: skip
WIDTHS = (1100, 390)
PAGES = ("comparison", "trace", "robust")
A4 = {"width": 672, "height": 1002}
"""What of a sheet lies within the margins [px]."""

FOOT = ("Workbench", "Commit", "Command", "Seed", "Plant", "Data")

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="no chromium")]


@pytest.fixture(scope="module")
def browser():
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=str(CHROMIUM), args=list(QUIET))
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def made_here(written_comparison, written_trace, written_robust) -> dict[str, Path]:
    """Small pages of each kind, by name."""
    written = (written_comparison, written_trace, written_robust)
    return {name: w.path for name, w in zip(PAGES, written, strict=True)}


@pytest.fixture(
    scope="module", params=[f"{name}, {where}" for where in ("small", "example") for name in PAGES]
)
def page(request, made_here) -> Path:
    """A page of each kind that this session made, and the committed examples."""
    name, _, where = request.param.partition(", ")
    path = made_here[name] if where == "small" else EXAMPLES / f"{name}.html"
    assert path.is_file(), path
    return path


def page_of(shown: Shown, folder: Path) -> Path:
    """A page that shows one figure and nothing else."""
    text = render(
        "paper.html", title="A figure", kind="test", summary=["One."], remarks=[],
        sections={"paper": "Figure"}, paper=[shown], made=Made.now("test"),
    )  # fmt: skip
    path = folder / "page.html"
    path.write_text(text, encoding="utf-8")
    return path


class Opened:
    """A page in a window, and all that it complained of and asked for."""

    def __init__(self, browser, path: Path, width: int) -> None:
        self.complaints: list[str] = []
        self.asked: list[str] = []
        self.tab = browser.new_page(viewport={"width": width, "height": 900})
        self.tab.on("console", lambda message: self.complaints.append(message.text))
        self.tab.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.tab.on("request", lambda request: self.asked.append(request.url))
        self.tab.goto(path.resolve().as_uri())
        self.tab.evaluate("document.querySelectorAll('details').forEach(d => d.open = true)")

    def __enter__(self) -> "Opened":
        return self

    def __exit__(self, *_) -> None:
        self.tab.close()


OVERFLOWS = """() => {
  const wide = document.documentElement.clientWidth;
  const inside = e => e.closest('.scroll') || e.closest('svg');
  return [...document.body.querySelectorAll('*')]
    .filter(e => !inside(e) && e.getBoundingClientRect().right > wide + 0.5)
    .map(e => e.tagName + ' ' + e.textContent.slice(0, 40));
}"""

FIGURES = """() => [...document.querySelectorAll('figure')].map(f => {
  const svg = f.querySelector('svg'), size = svg ? svg.getBoundingClientRect() : {width: 0, height: 0};
  const caption = f.querySelector('figcaption');
  return {width: size.width, height: size.height, paths: f.querySelectorAll('svg path').length,
          letters: [...f.querySelectorAll('text, use')].filter(u => {
            const box = u.getBBox(); return box.width > 0 || box.height > 0; }).length,
          caption: caption ? caption.textContent.trim() : ''};
})"""


@pytest.mark.parametrize("width", WIDTHS)
def test_it_fits_the_window_and_all_its_figures_are_there(browser, page, width):
    with Opened(browser, page, width) as opened:
        root = "document.documentElement"
        assert opened.tab.evaluate(f"{root}.scrollWidth") <= opened.tab.evaluate(f"{root}.clientWidth")
        assert opened.tab.evaluate(OVERFLOWS) == []
        figures = opened.tab.evaluate(FIGURES)
        assert len(figures) >= 4
        for number, figure in enumerate(figures, start=1):
            assert figure["width"] > 0.6 * min(width, 600), figure
            assert figure["height"] > 60, figure
            assert figure["paths"] > 0, figure
            assert figure["letters"] > 10, figure
            assert re.fullmatch(rf"Figure {number}\. .{{40,}}", figure["caption"]), figure
        assert opened.complaints == []
        assert all(url.startswith("file:") for url in opened.asked)


def test_a_table_that_is_wider_than_a_phone_scrolls_in_its_own_box(browser, made_here):
    with Opened(browser, made_here["comparison"], 390) as opened:
        boxes = opened.tab.evaluate(
            "[...document.querySelectorAll('.scroll')].map(b => [b.scrollWidth, b.clientWidth])"
        )
        assert any(inner > outer for inner, outer in boxes)
        assert all(outer <= 390 for _, outer in boxes)


def test_its_foot_says_what_made_it_and_its_head_three_sentences(browser, page):
    with Opened(browser, page, 1100) as opened:
        terms = opened.tab.eval_on_selector_all("footer dt", "e => e.map(x => x.textContent)")
        said = opened.tab.eval_on_selector_all("footer dd", "e => e.map(x => x.textContent.trim())")
        for field in FOOT:
            assert any(t == field or t.startswith(f"{field},") for t in terms), field
        assert all(said)
        assert opened.tab.locator(".summary p").count() == 3
        links = opened.tab.eval_on_selector_all("nav a", "e => e.map(x => x.getAttribute('href').slice(1))")
        headings = opened.tab.eval_on_selector_all("main h2", "e => e.map(x => x.id)")
        assert links == headings


def test_it_prints_and_no_page_is_blank(browser, page):
    with Opened(browser, page, 1100) as opened:
        pdf = opened.tab.pdf(prefer_css_page_size=True, print_background=True)
    drawn = painted(pdf)
    assert 3 <= len(drawn) <= 40
    assert min(drawn) > 20, drawn  # the number of a page alone takes less


@pytest.mark.parametrize("name", ["comparison", "robust"])
def test_a_page_takes_eight_sheets_at_most_and_its_card_is_on_the_first(browser, made_here, name):
    with Opened(browser, made_here[name], 1100) as opened:
        assert len(painted(opened.tab.pdf(prefer_css_page_size=True, print_background=True))) <= 8
        opened.tab.emulate_media(media="print")
        opened.tab.set_viewport_size(A4)
        foot = opened.tab.evaluate("document.querySelector('.card').getBoundingClientRect().bottom")
        assert foot < A4["height"]


@pytest.mark.parametrize("name", PAGES)
def test_letters_of_a_printed_figure_are_not_smaller_than_six_points(browser, made_here, name):
    with Opened(browser, made_here[name], 1100) as opened:
        opened.tab.emulate_media(media="print")
        opened.tab.set_viewport_size(A4)
        scales = opened.tab.evaluate(
            "[...document.querySelectorAll('figure svg')].filter(s => s.getBoundingClientRect().width > 0)"
            ".map(s => s.getBoundingClientRect().width / s.viewBox.baseVal.width)"
        )
        assert len(scales) >= 3
        assert min(scales) * 72.0 / 96.0 * SIZE >= 6.0


def painted(pdf: bytes) -> list[int]:
    """How often each page of a PDF shows text or paints a path, those of its forms not counted.

    Enough of the format for what Chromium writes: plain objects, contents compressed at most."""
    objects = {
        int(number): body for number, body in re.findall(rb"\n(\d+) 0 obj\s(.*?)\nendobj", pdf, re.DOTALL)
    }
    pages = [body for body in objects.values() if re.search(rb"/Type\s*/Page\b(?!s)", body)]
    found = []
    for body in pages:
        content = objects[int(re.search(rb"/Contents (\d+) 0 R", body).group(1))]
        begin = re.search(rb"stream\r?\n", content).end()  # its last byte may look like the end of a line
        stream = content[begin : begin + int(re.search(rb"/Length (\d+)", content).group(1))]
        text = zlib.decompress(stream) if b"/FlateDecode" in content else stream
        found.append(len(re.findall(rb"(?:^|\s)(?:Tj|TJ|f\*?|S|s|B\*?|Do)(?=\s|$)", text)))
    return found
