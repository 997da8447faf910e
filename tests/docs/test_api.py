"""The API pages: every public name of plants and design is told of, with its units, errors and source."""

import ast
import importlib
import inspect
import pkgutil
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from docs.build import build

PACKAGES = ("plants", "design")
ROOT = Path(__file__).parents[2]
OF_THE_COMMAND = "design.cli"
"""Told of by `wrist --help`."""

PORTS = {
    "target",
    "valve",
    "chamber",
    "supply",
    "drive",
    "bend",
    "steepen",
    "static",
    "joint",
    "friction",
    "stop",
    "sensor",
}
"""Laws of effects, which go by the name of their port: `plants.effects.effect` says what each one means."""

QUANTITIES = {"dt", "duration", "dead_time", "period", "begin", "pressure", "angle", "command", "commands"}
"""Parameters that are numbers with a unit."""

UNIT = re.compile(r"\[[^\]]*\b(s|V|kPa|deg|rad/s|samples|1/s|ms)\b[^\]]*\]|\b(in|both in) (s|V|kPa|deg)\b")
REFUSALS = ("InputError", "ValueError", "KeyError", "RuntimeError")

OTHERS = (
    "AMIGO", "SIMC", "Popov", "Clopper", "describing function", "structured singular value",
    "convex-concave", "Haar", "Halton", "Nelder",
)  # fmt: skip
"""Methods that others found; the module that has one at work says where it is from."""


class Told(NamedTuple):
    """A public name: where it is, what it is, and the docstrings that tell of it, its own first."""

    name: str
    thing: Any
    words: tuple[str, ...]

    @property
    def tree(self) -> ast.FunctionDef | None:
        """The source of a function."""
        if not inspect.isfunction(self.thing):
            return None
        tree = ast.parse(textwrap.dedent(inspect.getsource(self.thing))).body[0]
        return tree if isinstance(tree, ast.FunctionDef) else None


def modules() -> Iterator[Any]:
    for package in map(importlib.import_module, PACKAGES):
        yield package
        for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not found.name.startswith(OF_THE_COMMAND):
                yield importlib.import_module(found.name)


def public(module: Any) -> Iterator[Told]:
    """The module, its functions and classes, and their methods."""
    about = inspect.getdoc(module) or ""
    yield Told(module.__name__, module, (about,))
    for name, thing in vars(module).items():
        if name.startswith("_") or getattr(thing, "__module__", None) != module.__name__:
            continue
        if not (inspect.isfunction(thing) or inspect.isclass(thing)):
            continue
        where, words = f"{module.__name__}.{name}", inspect.getdoc(thing) or ""
        yield Told(where, thing, (words, about))
        for own, member in vars(thing).items() if inspect.isclass(thing) else ():
            plain = getattr(member, "fget", None) or getattr(member, "func", None) or member
            plain = getattr(plain, "__func__", plain)
            law = own in PORTS and module.__name__.startswith("plants.effects")
            if inspect.isfunction(plain) and not own.startswith("_") and not law:
                told = inspect.getdoc(getattr(thing, own)) or inspect.getdoc(plain) or ""
                yield Told(f"{where}.{own}", plain, (told, words, about))


EVERY = [told for module in modules() for told in public(module)]


def refuses(tree: ast.AST) -> bool:
    """Whether a function raises an error of its caller's by itself."""
    calls = [n.exc for n in ast.walk(tree) if isinstance(n, ast.Raise) and isinstance(n.exc, ast.Call)]
    return any(isinstance(c.func, ast.Name) and c.func.id in REFUSALS for c in calls)


def untold_error(told: Told) -> bool:
    """Whether a function, or the check of a class, raises without saying so."""
    if inspect.isclass(told.thing):
        check = vars(told.thing).get("__post_init__")
        if check is None or check.__module__ != told.thing.__module__:
            return False
        tree: ast.AST | None = ast.parse(textwrap.dedent(inspect.getsource(check)))
    else:
        tree = told.tree
    return tree is not None and refuses(tree) and not re.search(r"[Rr]aise", told.words[0])


def without_unit(told: Told) -> bool:
    """Whether a function takes a number that has a unit, and neither it, its class nor module gives one."""
    if told.tree is None:
        return False
    names = {a.arg for a in (*told.tree.args.args, *told.tree.args.kwonlyargs)}
    return bool(names & QUANTITIES) and not any(UNIT.search(words) for words in told.words)


def test_there_are_names_to_look_at():
    assert len(EVERY) > 1000
    assert {"plants.wrist.Wrist.simulate", "design.synthesis.tuning.tune"} <= {t.name for t in EVERY}


def test_every_public_name_is_told_of():
    assert [t.name for t in EVERY if not t.words[0]] == []


def test_meaning_comes_first():
    """In a sentence: no list of parameters before it, and an end."""
    lists = re.compile(r"(Args|Parameters|Returns|Raises)\b *:?\n")
    unsaid = [t.name for t in EVERY if lists.match(t.words[0]) or not re.search(r"[.:;)]", t.words[0])]
    assert unsaid == []


@pytest.mark.slow
def test_errors_that_a_function_raises_are_told():
    assert [t.name for t in EVERY if untold_error(t)] == []


@pytest.mark.slow
def test_numbers_have_units():
    assert [t.name for t in EVERY if without_unit(t)] == []


def test_methods_of_others_are_cited():
    """Somewhere in the module that names one in its first sentence: a year, or a doi."""
    unsourced = []
    for module in modules():
        first = (inspect.getdoc(module) or "").split("\n\n")[0]
        at_work = any(
            inspect.isfunction(x) and x.__module__ == module.__name__ for x in vars(module).values()
        )
        if at_work and any(name in first for name in OTHERS):
            strings = [inspect.getdoc(module) or "", inspect.getsource(module)]
            if not any(re.search(r"\b(19|20)\d\d\b|doi", text) for text in strings):
                unsourced.append(module.__name__)
    assert unsourced == []


@pytest.mark.slow
@pytest.mark.filterwarnings("default")
def test_pages_are_made_without_a_warning(tmp_path):
    """Of one package here; `python -m docs.build` makes all and stops at a warning likewise."""
    build(tmp_path, ("plants.effects",))
    page = (tmp_path / "plants/effects/effect.html").read_text(encoding="utf-8")
    assert "valve(s, pressure, error, around)" in page  # the table of the ports, as it stands
    assert "What an effect is" in page
    assert "Alias for field number" not in page
    assert (tmp_path / "plants/effects/wrist/creep.html").is_file()
    assert (tmp_path / "index.html").is_file()
    guides = {p.stem.replace("-", "_") for p in (ROOT / "docs").glob("*.md")}
    assert {p.stem for p in (tmp_path / "guides").glob("*.html")} == guides
    for page in [tmp_path / "guides.html", *(tmp_path / "guides").glob("*.html")]:
        links = re.findall(r'href="([^"#:]+\.html)', page.read_text(encoding="utf-8"))
        assert [to for to in links if not (page.parent / to).is_file()] == []
    index = (tmp_path / "search.js").read_text(encoding="utf-8")
    assert "guides.your_own_rig" in index  # one search finds guides and API
    assert "plants.effects.wrist.creep" in index
