"""``wrist --plugin FILE.py``: effects, laws and controllers that are the user's own, in every command."""

from pathlib import Path

import pytest

from design.controllers.registry import REGISTERED
from plants.effects import EFFECTS
from plants.hysteresis import LAWS
from tests.docs.guide import DOCS, blocks


@pytest.fixture(autouse=True)
def forgotten():
    """What a test makes known is not known to the next."""
    before = [(known, dict(known)) for known in (EFFECTS, LAWS, REGISTERED)]
    yield
    for known, kept in before:
        known.clear()
        known.update(kept)


def of_guide(guide: str, path: str) -> str:
    """The file of a path that a guide writes."""
    (found,) = [b for b in blocks(DOCS / guide) if b.path == path]
    return found.text.split("\n", 1)[1]


def plugin(folder: Path, guide: str, path: str, call: str) -> Path:
    """A guide's file with the call that registers what is in it."""
    made = folder / "own.py"
    made.write_text(of_guide(guide, path) + call)
    return made


@pytest.fixture
def bouc_wen(tmp_path):
    call = "\n\nfrom plants.hysteresis import register\n\nregister(BoucWen)\n"
    own = plugin(tmp_path, "add-a-hysteresis-law.md", "plants/hysteresis/bouc_wen.py", call)
    plant = tmp_path / "plant.toml"
    plant.write_text(of_guide("add-a-hysteresis-law.md", "build/bouc-wen.toml"))
    return own, plant


def test_a_law_of_ones_own_is_simulated(wrist, bouc_wen):
    own, plant = bouc_wen
    assert "unknown hysteresis" in wrist("show", "--plant", plant).err
    outcome = wrist("--plugin", own, "simulate", "--plant", plant, "--gains", "2,6")
    assert outcome.code == 0, outcome.err
    assert "settles in 2.19 s" in outcome.out  # as the guide shows


def test_the_variable_does_as_the_option(wrist, bouc_wen, monkeypatch):
    own, plant = bouc_wen
    monkeypatch.setenv("WRIST_PLUGIN", str(own))
    assert wrist("show", "--plant", plant, "--json", "-").json["recovery"]["value"] == 43.0


def test_a_controller_of_ones_own_goes_to_the_target(wrist, tmp_path):
    call = (
        "\n\nfrom design.controllers import register\n\n"
        'register("pid", lambda wrist: PID(5.0, 12.0, 0.5, 0.05, wrist.regulator.gain, 100.0))\n'
    )
    own = plugin(tmp_path, "add-a-controller.md", "design/controllers/pid.py", call)
    assert wrist("export", "pid", "--out", tmp_path / "c").code == 2
    outcome = wrist("--plugin", own, "export", "pid", "--out", tmp_path / "c")
    assert outcome.code == 0, outcome.err
    assert list((tmp_path / "c").glob("*pid*.c"))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "is no Python file"),
        ("x = 1\ny = nothing_of_the_kind\n", "line 2: NameError"),
        ("x = (\n", "line 1: SyntaxError"),
    ],
)
def test_a_file_that_fails_is_told_in_one_line(wrist, tmp_path, text, said):
    own = tmp_path / "own.py"
    if text is not None:
        own.write_text(text)
    outcome = wrist("--plugin", own, "show")
    assert outcome.code == 2
    assert outcome.err.count("\n") == 1
    assert f"--plugin: {own}" in outcome.err
    assert said in outcome.err
