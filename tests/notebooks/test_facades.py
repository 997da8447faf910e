"""Notebooks and the guides of use take what they need from the packages, not from modules deep in them."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TEXTS = [
    *sorted((ROOT / "notebooks").glob("[0-9]_*.py")),
    ROOT / "README.md",
    *(ROOT / "docs" / f"{n}.md" for n in ("beyond-a-pi", "how-trace-decides", "your-own-rig")),
]
DEEP = re.compile(r"^\s*(?:>>> )?(?:from|import) ((?:plants|design|reports)\.[\w.]+)", re.MULTILINE)


@pytest.mark.parametrize("text", TEXTS, ids=lambda t: t.stem)
def test_nothing_is_imported_from_deep_within(text):
    assert DEEP.findall(text.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("package", ["plants", "design", "reports"])
def test_every_name_of_a_facade_is_there(package):
    facade = __import__(package)
    assert [n for n in facade.__all__ if not hasattr(facade, n)] == []
    with pytest.raises(AttributeError, match=f"module '{package}' has no attribute 'nothing'"):
        _ = facade.nothing
