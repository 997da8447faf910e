"""What the guides point at is there; their commands are understood; what they say of the pages is so."""

import re
from types import SimpleNamespace
from typing import Any

import pytest
import typer
from typer.main import get_command

from design.cli.app import app
from reports.comparison import page as comparison
from reports.robustness import page as robust_page
from tests.docs.guide import DOCS, ROOT, blocks, commands

PAGES = sorted(DOCS.glob("*.md"))
REPORT = (DOCS / "read-the-report.md").read_text(encoding="utf-8")


def anchors(text: str) -> set[str]:
    """Where a link into a page may point: its headings as GitHub names them."""
    found = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in found}


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_every_link_leads_somewhere(page):
    text = page.read_text(encoding="utf-8")
    for link in re.findall(r"\]\(([^)]+)\)", text):
        if not link.startswith("http"):
            name, _, anchor = link.partition("#")
            there = (page.parent / name).resolve() if name else page
            assert there.is_file(), link
            assert not anchor or anchor in anchors(there.read_text(encoding="utf-8")), link


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_every_command_is_one(page):
    """Understood by the command, options and all; that they do what they say other tests show, since a
    comparison takes a minute."""
    group = get_command(app)
    for block in blocks(page):
        for name, *arguments in commands(block) if block.language == "sh" else ():
            with typer.Context(group) as parent:
                group.commands[name].make_context(name, list(arguments), parent=parent)


@pytest.mark.parametrize("page", ["your-own-rig", "add-an-effect", "add-a-controller", "read-the-report"])
def test_a_guide_is_read_in_five_minutes(page):
    text = (DOCS / f"{page}.md").read_text(encoding="utf-8")
    prose = re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)
    words = [word for word in prose.split() if re.search(r"\w", word)]
    assert len(words) <= 1250  # 250 a minute


def test_every_guide_is_reached_from_the_readme():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert [p.name for p in PAGES if f"docs/{p.name}" not in readme] == []


def titles_told(heading: str) -> list[str]:
    """The sections that the guide tells of under a heading."""
    part = REPORT.split(f"## {heading}\n")[1].split("\n## ")[0]
    return re.findall(r"^\| \*\*(.+?)\*\* \|", part, re.MULTILINE)


def test_the_guide_tells_of_every_section_of_the_compare_page():
    whole: Any = SimpleNamespace(
        contest=object(), break_even=object(), execution_times=object(), fits=object(), redrawn=object(),
        comparison=SimpleNamespace(designs=object()),
    )  # fmt: skip
    shown = comparison._sections(whole)
    assert titles_told("The compare page") == list(shown.values())


def test_the_guide_tells_of_every_section_of_the_robust_page():
    assert titles_told("The robust page") == list(robust_page.SECTIONS.values())


def test_the_guide_tells_of_every_section_of_the_trace_page():
    source = (ROOT / "reports/trace/page.py").read_text(encoding="utf-8")
    for title in titles_told("The trace page"):
        assert f'"{title}"' in source, title
    assert len(titles_told("The trace page")) == 7


@pytest.mark.filterwarnings("ignore")
def test_what_beyond_a_pi_shows_runs():
    for block in blocks(DOCS / "beyond-a-pi.md"):
        if block.language == "python":
            exec(block.text, {})
