"""Which tests reach which functions, recorded once for each file of tests and kept in ``build/``."""

import ast
import hashlib
import json
import re
import sys
import threading
import time
from collections.abc import Iterable, Iterator
from itertools import accumulate
from pathlib import Path
from types import CodeType, FrameType
from typing import Any, NamedTuple

import pytest

from tests.mutants.forked import pytest_forked

DEFINITIONS = (ast.ClassDef, ast.FunctionDef)


class Reached(NamedTuple):
    """A test: how long it took [s], and the functions it called, as ``path::qualified name``."""

    seconds: float
    functions: frozenset[str]


class Recorder:
    """A plugin that notes, for each test, the project's functions called in it and in its fixtures.

    It stops after ``most`` [s]: what comes later takes too long to be run on hundreds of mutants.
    """

    def __init__(self, most: float) -> None:
        self.root = str(Path.cwd()) + "/"
        self.end = time.monotonic() + most
        self.found: dict[str, tuple[float, list[str]]] = {}
        self.codes: dict[int, CodeType] = {}

    def _called(self, frame: FrameType, _event: str, _argument: Any) -> None:
        code = frame.f_code
        if id(code) not in self.codes:
            self.codes[id(code)] = code  # kept, so that no other code gets its number

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self.codes, begun = {}, time.perf_counter()
        threading.settrace(self._called)
        sys.settrace(self._called)
        try:
            return (yield)
        finally:
            sys.settrace(None)
            threading.settrace(None)  # type: ignore[arg-type]
            called = {
                f"{code.co_filename.removeprefix(self.root)}::{code.co_qualname}"
                for code in self.codes.values()
                if code.co_filename.startswith(self.root)
            }
            self.found[item.nodeid] = (round(time.perf_counter() - begun, 3), sorted(called))
            if time.monotonic() > self.end:
                item.session.shouldstop = "long enough"


def record(copy: Path, files: Iterable[str], kept: Path, most: float) -> tuple[dict[str, Reached], list[str]]:
    """Tests of these files with what they reach, and the files of which that is not known of every test.

    A file is recorded anew where it is another than before, for ``most`` [s]; of one whose first test takes
    three times as long nothing is known."""
    known = json.loads(kept.read_text()) if kept.exists() else {}
    reached: dict[str, Reached] = {}
    unknown = []
    for name in files:
        digest = hashlib.sha256((copy / name).read_bytes()).hexdigest()
        if known.get(name, {}).get("digest") != digest:
            begun = time.monotonic()
            ended = pytest_forked(copy, [name], lambda: Recorder(most), 3.0 * most)
            if ended.code not in (0, 2, 5, None):  # all passed, stopped, none there, out of time
                raise SystemExit(f"{name}: its tests do not pass as they are (exit code {ended.code})")
            print(f"{name}: {time.monotonic() - begun:.0f} s, {len(ended.found or {})} tests", flush=True)
            functions = sorted({f for _, called in (ended.found or {}).values() for f in called})
            number = {f: i for i, f in enumerate(functions)}
            known[name] = {
                "digest": digest, "functions": functions, "whole": ended.code in (0, 5),
                "tests": {t: [s, [number[f] for f in c]] for t, (s, c) in (ended.found or {}).items()},
            }  # fmt: skip
            kept.parent.mkdir(parents=True, exist_ok=True)
            kept.write_text(json.dumps(known))
        functions = known[name]["functions"]
        if not known[name]["whole"]:
            unknown.append(name)
        for test, (seconds, called) in known[name]["tests"].items():
            reached[test] = Reached(seconds, frozenset(functions[i] for i in called))
    return reached, unknown


def naming(copy: Path, files: Iterable[str], path: Path, functions: Iterable[str] = ()) -> list[str]:
    """The files of tests that name a module, or what it defines; first those that name one of some functions,
    for time may be out before all of them are through."""
    defined = [n.name for n in ast.parse((copy / path).read_text()).body if isinstance(n, DEFINITIONS)]
    public = "|".join(n for n in defined if not n.startswith("_") and len(n) > 4) or "-"
    wanted = re.compile(rf"{importing([path]).pattern}|\b({public})\b")
    texts = {f: (copy / f).read_text(encoding="utf-8") for f in files}
    near = re.compile("|".join(rf"\b{re.split('::|[.]', f)[-1]}\b" for f in functions) or r"(?!)")
    return sorted((f for f in texts if wanted.search(texts[f])), key=lambda f: not near.search(texts[f]))


def importing(paths: Iterable[Path]) -> re.Pattern[str]:
    """What stands in a source that imports one of some modules."""
    places = [".".join(path.with_suffix("").parts).rpartition(".") for path in paths]
    return re.compile("|".join(rf"{p}\.{n}\b|from {p} import [^\n]*\b{n}\b" for p, _, n in places))


def enclosing(source: str, path: str, line: int) -> list[str]:
    """The functions that a line lies in, innermost first."""

    def inside(node: ast.AST, prefix: str) -> Iterator[str]:
        for child in ast.iter_child_nodes(node):
            named = isinstance(child, ast.FunctionDef | ast.ClassDef)
            if named and child.lineno <= line <= (child.end_lineno or 0):  # type: ignore[attr-defined]
                name = f"{prefix}{child.name}"  # type: ignore[attr-defined]
                local = isinstance(child, ast.FunctionDef)
                yield from inside(child, f"{name}.<locals>." if local else f"{name}.")
                if local:
                    yield f"{path}::{name}"

    return list(inside(ast.parse(source), ""))


def chosen(reached: dict[str, Reached], functions: list[str], path: str, most: float) -> list[str]:
    """Tests to be run on a fault, in their order, that take no more than ``most`` [s] together.

    First those that call the innermost function that any calls, quick ones first; then the rest of their
    files, which may use what these have left in a cache; where none calls one, those that call the most of
    the module.
    """
    direct: dict[str, float] = {}
    for function in functions:
        direct = {t: r.seconds for t, r in reached.items() if function in r.functions}
        if direct:
            break
    if not direct:
        used = {t: sum(f.startswith(f"{path}::") for f in r.functions) for t, r in reached.items()}
        direct = {t: reached[t].seconds / n for t, n in used.items() if n}
    files = {t.partition("::")[0] for t in direct}
    rest = sorted(
        (r.seconds, t) for t, r in reached.items() if t not in direct and t.partition("::")[0] in files
    )
    found, spent = [], 0.0
    for test in [*sorted(direct, key=direct.__getitem__), *(t for _, t in rest)]:
        spent += reached[test].seconds
        if spent > most and found:
            break
        found.append(test)
    return found


def seen(reached: dict[str, Reached], functions: list[str]) -> bool:
    """Whether any test calls one of some functions, as none does where they are called on import alone."""
    return any(not r.functions.isdisjoint(functions) for r in reached.values())


def quickest(reached: dict[str, Reached], most: float) -> list[str]:
    """As many tests as end in ``most`` [s] together."""
    ordered = sorted(reached, key=lambda t: reached[t].seconds)
    spent = accumulate(reached[t].seconds for t in ordered)
    return [test for test, until in zip(ordered, spent, strict=True) if until <= most]


def limits(reached: dict[str, Reached]) -> dict[str, float]:
    """Seconds after which a test hangs: five times the longest of its file, as recorded, and a minute.

    Of its file, for another test may now be the one that makes what they share; a minute, for kernels of a
    law with a fault are compiled anew."""
    longest: dict[str, float] = {}
    for test, (seconds, _) in reached.items():
        file = test.partition("::")[0]
        longest[file] = max(seconds, longest.get(file, 0.0))
    return {test: 5.0 * longest[test.partition("::")[0]] + 60.0 for test in reached}
