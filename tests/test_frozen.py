"""What others can hold of a dataclass nobody changes under them: each with a public name is frozen."""

import ast

import pytest

from tests.cli.terminal import ROOT

SOURCES = sorted(p for room in ("plants", "design", "reports") for p in (ROOT / room).rglob("*.py"))


def thawed(tree):
    """Public dataclasses that are not frozen."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            for decorator in node.decorator_list:
                said = ast.unparse(decorator)
                if said.startswith("dataclass") and "frozen=True" not in said:
                    yield node.name


def test_one_that_is_not_is_found():
    kinds = ("", "(frozen=False)", "(frozen=True)")
    text = "\n".join(f"@dataclass{how}\nclass {name}: ..." for how, name in zip(kinds, "ABC", strict=True))
    assert list(thawed(ast.parse(text))) == ["A", "B"]


@pytest.mark.parametrize("room", ["plants", "design", "reports"])
def test_public_dataclasses_are_frozen(room):
    sources = [p for p in SOURCES if p.relative_to(ROOT).parts[0] == room]
    assert len(sources) > 20
    found = {
        str(p.relative_to(ROOT)): names for p in sources if (names := list(thawed(ast.parse(p.read_text()))))
    }
    assert not found
