"""The guide from a ``.mat`` to gains on the target, followed from top to bottom in an empty folder."""

import re
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest

from design.cli import main
from plants.errors import InputError
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.formats.binary.matlab import ADVICE
from plants.measured.trace.rig_fit import fit_rig
from tests.docs.guide import DOCS, blocks, commands, missing, write

GUIDE = DOCS / "your-own-rig.md"
TEXT = GUIDE.read_text(encoding="utf-8")

QUICKER = {
    "design": ["--samples", "400", "--budget", "3000", "--points", "10", "--no-alternatives"],
    "robust": ["--budget", "200"],
}
"""What is added to commands that take minutes of one core as the guide gives them: fewer points, samples and
tries.  What the guide shows of them does not depend on these."""

NO_PAGES = ("trace", "robust")
"""Commands whose pages other tests draw."""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def run(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Callable[..., tuple[int, str]]:
    """Run ``wrist``: its exit code and all that it says, in lines as long as they come."""
    monkeypatch.setenv("COLUMNS", "400")

    def call(arguments: list[str]) -> tuple[int, str]:
        capsys.readouterr()
        with pytest.raises(SystemExit) as stop:
            main(arguments)
        said = capsys.readouterr()
        return int(stop.value.code or 0), said.out + said.err

    return call


def quicker(arguments: list[str]) -> list[str]:
    """A command as the tests run it."""
    name = arguments[0]
    if name in NO_PAGES:
        at = arguments.index("--out")
        arguments = arguments[:at] + arguments[at + 2 :]
    return arguments + QUICKER.get(name, [])


@pytest.mark.suite
def test_every_step_works_and_prints_what_the_guide_shows(here, run):
    printed, ran = "", []
    for block in blocks(GUIDE):
        if block.path:
            write(block, here)
        elif block.language == "python":
            exec(compile(block.text, f"{GUIDE.name}, line {block.line}", "exec"), {})
        elif block.language == "sh":
            for arguments in commands(block):
                code, printed = run(quicker(arguments))
                assert code == 0, (arguments, printed)
                ran.append(arguments[0])
        elif block.language == "text":
            assert missing(block.text, printed) == [], f"line {block.line}; printed was:\n{printed}"
    assert ran == ["fit", "trace", "design", "robust"]
    for made in ("fit/fit-my-rig.png", "design/design.html", "design/c-flexion/Makefile"):
        assert (here / "build" / made).stat().st_size > 0


SPOILED = {
    "no column 'phi'": ('"theta"', '"phi"'),
    "no column 'command_V'": ('command_V = "u"\n', ""),
    "looks like radians": ('{name = "theta", scale = 57.29578}', '"theta"'),
    "the median step": ("0.01", "0.001"),
    "outside 0 to 4 V": ('"u"', '{name = "u", scale = 1000}'),
    "in both fit and validate": ('"sine.mat"', '"steps.mat"'),
    "the angle falls as the pressure rises": ("57.29578", "-57.29578"),
}
"""How to spoil the campaign so that it is answered in these words."""

TROUBLES = TEXT.split("## When it does not work")[1].split("\n## ")[0]
TOLD = re.findall(r"^\| `(.+?)`", TROUBLES, re.MULTILINE)
"""The messages in the guide's last table."""


def answer(folder: Path) -> str:
    """All that a fit of one start says of a campaign, or why it is refused."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            data = load_campaign(folder)
            if not caught:  # a fit of data in wrong units says nothing that the guide shows
                return "\n".join(fit_rig(data, starts=1).fit.remarks)
        except InputError as error:
            return str(error)
    return "\n".join(str(w.message) for w in caught)


@pytest.mark.slow
@pytest.mark.parametrize("words", SPOILED)
def test_every_message_in_its_table_is_one_that_is_given(here, words):
    blocks_ = [b for b in blocks(GUIDE) if b.path or "savemat" in b.text]
    for block in sorted(blocks_, key=lambda b: b.path is not None):
        if block.path:
            path = write(block, here)
        else:
            exec(block.text, {})
    path.write_text(path.read_text().replace(*SPOILED[words]))
    (message,) = [m for m in TOLD if words in m]
    assert message in answer(here / "my-rig")


def test_what_it_says_of_matlab_objects_is_said():
    (message,) = [m for m in TOLD if "MATLAB objects" in m]
    assert message in ADVICE
    assert len(TOLD) == len(SPOILED) + 2  # and a folder without a campaign.toml, `tests/measured/test_draft`
