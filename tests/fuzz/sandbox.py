"""One try: ``wrist`` runs in this process, in a folder of its own, and what it left is looked at.

A try fails by a traceback or a bug (exit code 70), a refusal of more than a line, a file outside of its
output folder, a file that is not whole, an escape on the terminal, and by silence: taking what cannot be
meant.
"""

import contextlib
import io
import json
import os
import re
import shutil
import tomllib
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from plants.errors import InputError

TRACEBACK, OUTSIDE, HALF, SILENT, LINES = (
    "traceback",
    "file outside",
    "half a file",
    "silent",
    "not one line",
)
FAULTS = (TRACEBACK, OUTSIDE, HALF, SILENT, LINES)
ESCAPES = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f]")


class Outcome(NamedTuple):
    """How a try ended: exit code, what was said, and its faults."""

    code: int
    out: str
    err: str
    faults: tuple[str, ...]


class Sandbox:
    """A folder ``in`` with what is given, and ``out``, which may be written to; nothing else may change."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.given, self.out = root / "above" / "work" / "in", root / "above" / "work" / "out"

    @contextlib.contextmanager
    def fresh(self) -> Iterator[None]:
        """Both folders, anew and empty."""
        shutil.rmtree(self.root, ignore_errors=True)
        self.given.mkdir(parents=True)
        self.out.mkdir()
        before = Path.cwd()
        os.chdir(self.out.parent)
        try:
            yield
        finally:
            os.chdir(before)

    def wrist(self, line: list[str], must_refuse: bool = False) -> Outcome:
        """Run a line of the command."""
        from design.cli import main

        def run() -> int:
            try:
                main(line)
            except SystemExit as stop:
                return int(stop.code or 0)
            return 0

        return self.watched(run, must_refuse)

    def call(self, function: Callable[[], Any], must_refuse: bool = False) -> Outcome:
        """Call what a command would, where the command itself would take long."""

        def run() -> int:
            try:
                function()
            except InputError as error:
                print(f"wrist: {error}", file=os.sys.stderr)  # type: ignore[attr-defined]
                return 2
            return 0

        return self.watched(run, must_refuse)

    def watched(self, run: Callable[[], int], must_refuse: bool) -> Outcome:
        """Run, and look at what it said and left."""
        before = self.others()
        out, err = io.StringIO(), io.StringIO()
        faults: list[str] = []
        code = 70
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                code = run()
            except Exception as error:
                faults.append(TRACEBACK)
                err.write(repr(error))
        said = err.getvalue()
        lines = [x for x in said.splitlines() if not x.startswith("wrist: warning")]
        if code not in (0, 1, 2) or "Traceback" in said:
            faults.append(TRACEBACK)
        if code == 2 and (len(lines) != 1 or len(lines[0]) > 2000):
            faults.append(LINES)
        if ESCAPES.search(out.getvalue() + said):
            faults.append(LINES)
        if self.others() != before:
            faults.append(OUTSIDE)
        if not all(map(whole, self.out.rglob("*"))):
            faults.append(HALF)
        if must_refuse and code != 2:
            faults.append(SILENT)
        return Outcome(code, out.getvalue(), said, tuple(dict.fromkeys(faults)))

    def others(self) -> dict[str, bytes]:
        """All files that may not change, and their contents."""
        found = {}
        for path in self.root.rglob("*"):
            if not path.is_relative_to(self.out):
                found[str(path)] = path.read_bytes() if path.is_file() else b""
        return found


def whole(path: Path) -> bool:
    """Whether a file is complete: none under a temporary name, JSON, TOML and PNG as they should be."""
    if path.name.startswith(".wrist-"):
        return False
    if not path.is_file():
        return True
    content = path.read_bytes()
    try:
        match path.suffix:
            case ".json":
                json.loads(content)
            case ".toml":
                tomllib.loads(content.decode())
            case ".png":
                return content.startswith(b"\x89PNG") and content[-8:-4] == b"IEND"
            case _:
                return bool(content)
    except ValueError:
        return False
    return True
