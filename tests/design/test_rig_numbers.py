"""No number of the paper's wrist stands in code that serves any rig: they are in `plants/parameters`."""

import io
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
OF_THE_PAPER = {"plants/one_page.py", "design/studies/paper.py"}
"""The page that is the tests' oracle, and the paper's own figures."""

NUMBERS = {"49.4", "197.6", "0.0803", "0.0557"}
"""Gain and end of the regulator, slopes of the transit."""

SETTINGS = {"SAMPLE_TIME", "COMMAND_RANGE"}
"""Names of what a rig says; where they are defined, they come from the file of the built-in one."""


def tokens(file):
    text = file.read_text(encoding="utf-8")
    return list(tokenize.generate_tokens(io.StringIO(text).readline))


FILES = [
    f
    for room in ("plants", "design")
    for f in sorted((ROOT / room).rglob("*.py"))
    if str(f.relative_to(ROOT)) not in OF_THE_PAPER
]


@pytest.mark.parametrize("file", FILES, ids=lambda f: str(f.relative_to(ROOT)))
def test_no_number_of_the_paper_is_in_code(file):
    found = tokens(file)
    assert [t.start for t in found if t.type == tokenize.NUMBER and t.string in NUMBERS] == []
    numbers = [t for t in found if t.type in (tokenize.NUMBER, tokenize.OP, tokenize.NAME)]
    words = [t.string for t in numbers]
    assert [
        i
        for i in range(len(words) - 2)
        if words[i] in SETTINGS and words[i + 1] == "=" and words[i + 2][0].isdigit()
    ] == []
    pairs = [words[i : i + 5] for i in range(len(words) - 4)]
    assert ["(", "0.0", ",", "4.0", ")"] not in pairs
