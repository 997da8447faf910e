"""The guides that add to the project, followed in a copy of it: files written, edits made, tests run."""

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.guide import DOCS, ROOT, Block, blocks, edit, missing, write

LEFT_OUT = shutil.ignore_patterns("__pycache__", "examples", "*.png", "*.html")
PYTHON = ".venv/bin/python"


def copy_of_the_project(folder: Path) -> Path:
    """The project's code and tests, without what they made and the example data."""
    for name in ("plants", "design", "reports", "tests"):
        shutil.copytree(ROOT / name, folder / name, ignore=LEFT_OUT)
    shutil.copy(ROOT / "pyproject.toml", folder)
    return folder


def run(arguments: list[str], folder: Path) -> str:
    """What a process says that imports the copy rather than the project."""
    # In a pipe lines are as long as they come, but for who asks otherwise.
    known = {k: v for k, v in os.environ.items() if k != "COLUMNS"}
    environment = known | {"PYTHONPATH": str(folder), "MPLBACKEND": "Agg"}
    done = subprocess.run(
        [sys.executable, *arguments], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def commanded(block: Block, folder: Path) -> str:
    """What the commands of a ``sh`` block say."""
    said = ""
    for line in block.text.splitlines():
        program, *arguments = shlex.split(line)
        module = {"wrist": ["-m", "design.cli"], PYTHON: []}[program]
        quiet = ["-p", "no:cacheprovider"] if "pytest" in arguments else []
        said += run([*module, *arguments, *quiet], folder)
    return said


@pytest.mark.suite
@pytest.mark.parametrize("guide", ["add-an-effect.md", "add-a-controller.md", "add-a-hysteresis-law.md"])
def test_what_the_guide_adds_works_and_prints_what_it_shows(guide, tmp_path):
    folder, printed, added = copy_of_the_project(tmp_path), "", []
    code, shown = "", ""  # its Python blocks are run as one program, which starts once
    before = None
    for block in blocks(DOCS / guide):
        if block.path:
            added.append(write(block, folder).relative_to(folder).parts[0])
        elif block.language == "diff":
            edit(block, folder)
        elif block.language == "python":
            code += block.text
        elif block.language == "sh":
            printed = commanded(block, folder)
        elif before == "python":
            shown += block.text
        else:
            assert missing(block.text, printed) == [], f"line {block.line}; printed was:\n{printed}"
        before = block.language
    printed = run(["-c", code], folder)
    assert missing(shown, printed) == [], printed
    assert added[-1] == "tests"
    assert shown
