"""Shells complete commands, options and values, by the protocol that their scripts speak."""

import pytest

from design.export.catalogue import CATALOGUE
from design.export.plant.files import PLANT
from design.synthesis.requirements import COSTS
from plants.parameters.files import built_in
from plants.wrist import STARTS
from reports.paper.figures import FIGURES
from tests.cli.terminal import piped

VALUES = {
    "tune --axis ": ["flexion", "deviation"],
    "tune --cost ": list(COSTS),
    "simulate --start ": list(STARTS),
    "simulate --figure 1": [str(n) for n in FIGURES if str(n).startswith("1")],
    "export ": [*CATALOGUE, PLANT],
    "robust --axis deviation --box ": [f"{name}=" for name in built_in("deviation").parameters],
    "robust --plant nowhere.toml --box ": [],
    "ex": ["export"],
    "tune --st": ["--starts", "--steady-error"],
    "show --plant ": [],  # the shell's own: files
    "fit ": [],
}


def completed(shell: str, line: str) -> str:
    words = f"wrist {line}"
    outcome = piped(
        _WRIST_COMPLETE=f"complete_{shell}", COMP_WORDS=words, COMP_CWORD=str(words.count(" ")),
        _TYPER_COMPLETE_ARGS=words, _TYPER_COMPLETE_FISH_ACTION="get-args",
    )  # fmt: skip
    assert outcome.stderr == ""
    return outcome.stdout


@pytest.mark.slow
@pytest.mark.parametrize("line", VALUES)
def test_bash(line):
    assert sorted(completed("bash", line).split()) == sorted(VALUES[line])


@pytest.mark.slow
def test_zsh_says_what_each_controller_is_and_leaves_files_to_itself():
    said = completed("zsh", "export ")
    assert all(f'"{name}"' in said for name in CATALOGUE)
    assert completed("zsh", "show --plant ").strip() == "_files"


def test_fish_says_what_each_controller_is():
    lines = completed("fish", "export ").splitlines()
    assert [line.split("\t")[0] for line in lines] == [*CATALOGUE, PLANT]


@pytest.mark.parametrize(
    ("shell", "place"),
    [("bash", ".bash_completions/wrist.sh"), ("zsh", ".zfunc/_wrist"),
     ("fish", ".config/fish/completions/wrist.fish")],
)  # fmt: skip
def test_it_installs(tmp_path, shell, place):
    chosen = {"HOME": str(tmp_path), "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}
    outcome = piped("--install-completion", shell, **chosen)
    assert outcome.returncode == 0, outcome.stderr
    assert "_WRIST_COMPLETE" in (tmp_path / place).read_text()
