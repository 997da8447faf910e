"""A stored notebook is its text, with outputs that any viewer shows and that name no machine."""

import ast
import base64
import re
from pathlib import Path

import pytest

from tests.notebooks import outputs
from tests.notebooks.stored import HERE, TEXTS

WORDS = 1800
"""Words that are read in ten minutes, figures looked at."""

BYTES = 1_000_000
MACHINE = re.compile(r"/(?:home|root|tmp|work|usr|var|Users|opt)/|[A-Z]:\\\\")
SHOWN = ("print", "display")


@pytest.fixture(params=TEXTS, ids=lambda p: p.stem)
def text(request) -> Path:
    return request.param


@pytest.fixture
def stored(text):
    import nbformat

    return nbformat.read(text.with_suffix(".ipynb"), as_version=4)


def code(notebook):
    """Each code cell with its syntax tree, magics left out."""
    for cell in notebook.cells:
        if cell.cell_type == "code":
            lines = [line for line in cell.source.splitlines() if not line.startswith("%")]
            yield cell, ast.parse("\n".join(lines))


def prose(notebook) -> str:
    return "\n\n".join(c.source for c in notebook.cells if c.cell_type == "markdown")


def test_they_are_in_order_each_paired():
    assert [p.name[0] for p in TEXTS] == list("0123456")
    assert sorted(p.stem for p in HERE.glob("*.ipynb")) == [p.stem for p in TEXTS]


def test_the_text_and_the_notebook_have_the_same_cells(text, stored):
    from notebooks.build import notebook_of

    made = notebook_of(text)
    assert [(c.cell_type, c.source, c.metadata) for c in made.cells] == [
        (c.cell_type, c.source, c.metadata) for c in stored.cells
    ], "run `make notebooks`"


def test_nothing_is_stored_that_differs_from_run_to_run(text, stored):
    from notebooks.build import KERNEL, LANGUAGE, content

    assert content(stored) == text.with_suffix(".ipynb").read_text()
    assert set(stored.metadata) == {"kernelspec", "language_info"}
    assert (stored.metadata.kernelspec, stored.metadata.language_info) == (KERNEL, LANGUAGE)
    assert [c.id for c in stored.cells] == [f"cell-{i:02d}" for i in range(len(stored.cells))]
    counts = [c.execution_count for c in stored.cells if c.cell_type == "code"]
    assert counts == list(range(1, len(counts) + 1))  # run once, from top to bottom


def test_every_cell_that_shows_something_has_its_output_stored(stored):
    for cell, tree in code(stored):
        names = {
            n.func.id for n in ast.walk(tree) if isinstance(n, ast.Call) and isinstance(n.func, ast.Name)
        }
        if isinstance(tree.body[-1], ast.Expr) or names & set(SHOWN):
            assert cell.outputs, cell.source
    assert not [o for c in stored.cells for o in c.get("outputs", ()) if o.output_type == "error"]
    assert "stderr" not in [k for c in stored.cells for k in outputs.kinds(c)]


def test_every_figure_is_a_picture_of_a_size_to_be_read(text, stored):
    pictures = [
        o.data["image/png"]
        for c in stored.cells
        for o in c.get("outputs", ())
        if "image/png" in o.get("data", {})
    ]
    assert len(pictures) >= 4
    for picture in map(base64.b64decode, pictures):
        assert picture.startswith(b"\x89PNG\r\n\x1a\n")
        width, height = (int.from_bytes(picture[i : i + 4], "big") for i in (16, 20))
        assert 500 <= width <= 1100
        assert 150 <= height <= 1100
    assert "<Figure" not in "".join(outputs.text(c) for c in stored.cells)
    assert text.with_suffix(".ipynb").stat().st_size < BYTES


def test_no_path_of_a_machine_is_in_it(stored):
    for cell in stored.cells:
        assert not MACHINE.search(cell.source), cell.source
        assert not MACHINE.search(outputs.text(cell)), outputs.text(cell)


def test_nothing_is_defined_that_others_might_want(stored):
    wanted = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Lambda)
    assert not [n for _, tree in code(stored) for n in ast.walk(tree) if isinstance(n, wanted)]


def test_it_is_read_in_ten_minutes_and_says_what_does_not_follow(stored):
    words = prose(stored)
    assert len(words.split()) < WORDS
    assert words.startswith("# ")
    assert "**" in stored.cells[0].source
    assert stored.cells[0].source.count("?") >= 1
    assert "## What follows, and what does not\n" in stored.cells[-1].source


def test_every_figure_comes_with_what_to_see(stored):
    """Between a figure and the next heading stands a sentence that says what to see."""
    waiting = 0
    for cell in stored.cells:
        waiting += outputs.kinds(cell).count("image/png")
        if cell.cell_type == "markdown":
            first = cell.source.split("\n## ")[0]
            if "*What to see:" in first:
                waiting = 0
            assert not (waiting and "## " in cell.source), cell.source
    assert not waiting


def test_numbers_in_prose_are_printed_by_a_cell_or_stand_in_one(stored):
    """So that prose does not go stale: what it says in digits is in the code or in what the code shows."""
    shown = " ".join(c.source + " " + outputs.text(c) for c in stored.cells if c.cell_type == "code")
    known = {abs(n) for n in outputs.numbers(shown.replace("_", ""))} | {float(n) for n in range(11)}
    said = re.sub(
        r"\[.*?\]\(.*?\)|`.*?`|(Fig|section|notebook)s?\.? [\d.]+|\$.*?\$|^#.*$",
        "",
        prose(stored),
        flags=re.M,
    )
    assert not [n for n in outputs.numbers(said) if abs(n) not in known]
