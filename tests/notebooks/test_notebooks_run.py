"""Each notebook runs from top to bottom in a fresh kernel and shows the numbers that are stored."""

import copy
import os

import pytest

from tests.notebooks import outputs
from tests.notebooks.stored import TEXTS


@pytest.mark.suite
@pytest.mark.parametrize("text", TEXTS, ids=lambda p: p.stem)
def test_notebook_runs_and_shows_what_is_stored(text):
    import nbformat

    from notebooks.build import NEEDS_DATA, executed, notebook_of

    stored = nbformat.read(text.with_suffix(".ipynb"), as_version=4)
    skipped = {"varies"} | (set() if os.environ.get("WRIST_DATA") else {NEEDS_DATA})
    for before, now in zip(stored.cells, executed(notebook_of(text)).cells, strict=True):
        if not skipped & set(now.metadata.get("tags", ())):
            differs = outputs.difference(before, now)
            assert differs is None, (
                f"{differs}\nin the cell\n{now.source}\nrun `make notebooks` and look at it"
            )


@pytest.mark.slow
def test_a_number_that_changed_is_seen_and_rounding_is_not():
    import nbformat

    said = nbformat.v4.new_output("stream", name="stdout", text="Kp 3.13 kPa/deg, off by 3e-14, never: ∞\n")
    cell = nbformat.v4.new_code_cell("x", outputs=[said])
    for text, same in (
        ("Kp 3.14 kPa/deg, off by 2e-15, never: ∞\n", True),
        ("Kp 3.33 kPa/deg, off by 3e-14, never: ∞\n", False),
        ("Kp 3.13 kPa/deg, off by 3e-14, never: 9.1\n", False),
        ("Kp 3.13 kPa/deg, off by 3e-14, never\n", False),
    ):
        other = copy.deepcopy(cell)
        other.outputs[0].text = text
        assert (outputs.difference(cell, other) is None) == same
    picture = nbformat.v4.new_output("display_data", {"image/png": "", "text/plain": "<Figure>"})
    assert outputs.difference(cell, nbformat.v4.new_code_cell("x", outputs=[picture])) is not None
