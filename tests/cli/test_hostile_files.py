"""Plants of others: what their names, titles and numbers may not do to files, terminals and results."""

import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from design.controllers.pi import PI
from design.robustness.box import box_of
from design.robustness.samples.adversary import worst_case
from design.robustness.samples.scenario_file import save
from plants.errors import InputError
from plants.files import clear, file_name, replaced_folder, temporary_prefix, write_atomically
from plants.parameters.files import built_in, dump, load
from tests.cli.terminal import ROOT

FLEXION = (ROOT / "plants/parameters/flexion.toml").read_text(encoding="utf-8")


@pytest.fixture
def plant(tmp_path):
    """The flexion set with a piece of its text replaced, in a folder of its own."""

    def write(old: str, new: str) -> Path:
        assert old in FLEXION
        path = tmp_path / "in" / "plant.toml"
        path.parent.mkdir(exist_ok=True)
        path.write_text(FLEXION.replace(old, new, 1), encoding="utf-8")
        return path

    return write


@pytest.fixture
def fitted(tmp_path):
    """A set with a fitted parameter, its text replaced in a place: ``fitted(old, new)``."""

    def write(old: str, new: str) -> Path:
        path = tmp_path / "fitted.toml"
        dump(built_in("flexion").fitted({"Tw": 0.15}, {"Tw": 0.01}, "a campaign"), path)
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new, 1), encoding="utf-8")
        return path

    return write


AXIS = 'axis = "flexion"'
TITLE = next(line for line in FLEXION.splitlines() if line.startswith("title"))


@pytest.mark.parametrize("axis", ["x/../../../evil", "/tmp/evil", "..", "wrist (left)", "a\\tb", "ü" * 300])
def test_a_name_leads_to_no_other_folder(wrist, plant, tmp_path, axis):
    out = tmp_path / "deep" / "er" / "out"
    outcome = wrist("simulate", "--plant", plant(AXIS, f'axis = "{axis}"'), "--duration", "0.1", "--out", out)
    assert outcome.code == 0, outcome.err
    (made,) = out.iterdir()
    assert made.name.startswith("simulate-")
    assert {p.name for p in tmp_path.iterdir()} == {"deep", "in"}


@pytest.mark.suite
def test_a_tuning_and_a_replay_stay_in_their_folder(wrist, plant, tmp_path):
    """The name of an axis stands in the names of their pictures."""
    given, out = plant(AXIS, 'axis = "x/../../../evil"'), tmp_path / "deep" / "er" / "out"
    said = wrist("tune", "--nominal", "--plant", given, "--points", "5", "--starts", "1", "--out", out)
    assert said.code in (0, 1), said.err
    gains, saved = PI(3.1, 10.4), tmp_path / "in" / "worst.toml"
    save(worst_case(box_of(load(given)), gains, dead_time=0.0, load=0.0, budget=64, duration=1.0), saved)
    replayed = wrist("simulate", "--scenario", saved, "--out", out)
    assert replayed.code == 0, replayed.err
    assert sorted(p.name.partition("-")[0] for p in out.iterdir()) == ["scenario", "tune"]
    assert {p.name for p in tmp_path.iterdir()} == {"deep", "in"}


@pytest.mark.slow
@pytest.mark.parametrize("axis", ["wrist (left)", "9", "_", "a__b", "int", 'x; system(\\"ls\\")'])
def test_a_motion_of_any_name_is_exported(wrist, plant, tmp_path, axis):
    given = plant(AXIS, f'axis = "{axis}"')
    assert wrist("export", "pi", "--gains", "3,10", "--plant", given, "--out", tmp_path / "c").code == 0


def test_the_names_of_files_are_safe():
    assert file_name("../../evil") == "evil"
    assert file_name("CON\0\n\x1b[2J") == "CON-[2J".replace("[", "-").replace("--", "-")
    assert len(file_name("x" * 1000)) <= 100
    assert file_name("") == file_name("///") == "unnamed"
    assert file_name("Palmar flexion") == "Palmar flexion"


def test_dollar_signs_in_a_title_are_drawn_as_they_are(wrist, plant, tmp_path):
    given = plant(TITLE, 'title = "for $5 or $6_{ each"')
    assert wrist("simulate", "--plant", given, "--duration", "0.1", "--out", tmp_path / "o").code == 0


@pytest.mark.parametrize("escape", ["\\u001b[2J", "\\u009b2J", "\\u0000", "\\u0007", "\\u001b]0;evil\\u0007"])
def test_control_characters_in_a_file_are_refused(wrist, plant, escape):
    outcome = wrist("show", "--plant", plant(TITLE, f'title = "a{escape}b"'))
    assert outcome.code == 2
    assert "control character" in outcome.err


def test_a_path_with_an_escape_is_shown_and_not_obeyed(wrist, tmp_path):
    outcome = wrist("show", "--plant", tmp_path / "\x1b[2Jnowhere")
    assert "\\x1b[2Jnowhere" in outcome.err
    folder = tmp_path / "\x9b31m"
    told = wrist("simulate", "--duration", "0.1", "--out", folder)
    assert told.code == 0
    assert "\\x9b31m" in told.out
    assert "\x9b" not in told.out


@pytest.mark.parametrize("error", ["nan", "-0.01", "inf", '"small"', "true"])
def test_a_standard_error_is_a_number_or_absent(fitted, error):
    with pytest.raises(InputError, match="std_error"):
        load(fitted("std_error = 0.01", f"std_error = {error}"))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("bounds = ", "bound = ", "bounds"),
        ("std_error = ", "std_eror = ", "std_error"),
        ("title = ", "titel = ", "title"),
        ('hysteresis = "', 'hysterisis = "', "hysteresis"),
        ("[parameters.Tw]", "[parameters.Tww]", "Tw"),
        ("[parameters.Tw]", "[parameter.Tw]", "parameters"),
    ],
)
def test_an_unknown_key_is_refused_with_the_nearest_known(wrist, fitted, old, new, said):
    outcome = wrist("show", "--plant", fitted(old, new))
    assert outcome.code == 2
    assert f"(did you mean {said}?)" in outcome.err


@pytest.mark.parametrize(
    "text",
    [
        f"x = {'1' * 400}",
        f"x = {'1' * 5000}",
        f"x = {'[' * 3000}{']' * 3000}",
        "form = []",
        'rig = "mine"',
        "hysteresis = []",
        "parameters = []",
        "[effects.creep]\nform = []\n[effects.creep.parameters]\ngain = 1",
        "[effects]\ncreep = 3",
        "\0",
        "x = 1979-05-27T07:32:00Z",
    ],
    ids=lambda text: text[:20],
)
def test_malformed_text_is_refused_in_one_line(wrist, tmp_path, text):
    for place, content in (("before", f"{text}\n{FLEXION}"), ("after", f"{FLEXION}\n{text}\n")):
        path = tmp_path / f"{place}.toml"
        path.write_text(content, encoding="utf-8")
        outcome = wrist("show", "--plant", path)
        assert outcome.code == 2, outcome
        assert outcome.err.count("\n") == 1
        assert len(outcome.err) < 600


def test_a_device_and_a_pipe_are_written_to_as_they_are(wrist, tmp_path):
    pipe, read = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()))
    reader.start()
    assert wrist("show", "--json", pipe).code == 0
    reader.join(10.0)
    assert '"gain"' in read[0]
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert wrist("show", "--json", "/dev/null").code == 0
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)


def test_a_link_is_followed_to_its_target(wrist, tmp_path):
    (tmp_path / "there").mkdir()
    target, link = tmp_path / "there" / "real.json", tmp_path / "link.json"
    link.symlink_to(target)
    for _ in range(2):  # to nothing, then to a file
        assert wrist("show", "--json", link).code == 0
        assert link.is_symlink()
        assert '"gain"' in target.read_text()
    assert [p.name for p in (tmp_path / "there").iterdir()] == ["real.json"]


def test_the_next_run_clears_what_a_killed_one_left(tmp_path):
    code = (
        "import os, signal, tempfile, plants.files as f\n"
        "open_ = os.fdopen\n"
        "f.os.fdopen = lambda *a: os.kill(os.getpid(), signal.SIGKILL)\n"
        f"f.write_atomically({str(tmp_path / 'a.json')!r}, 'x')"
    )
    killed = subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False)
    assert killed.returncode == -9
    assert len(list(tmp_path.iterdir())) == 1
    mine = tmp_path / f"{temporary_prefix()}abc"  # of a process that runs
    mine.write_text("")
    write_atomically(tmp_path / "b.json", "y")
    assert {p.name for p in tmp_path.iterdir()} == {"b.json", mine.name}


def test_what_is_not_ours_is_not_cleared(tmp_path):
    for name in (".wrist-elsewhere-999999-abc", ".wrist-x", ".b.json.abc", "wrist-1-2"):
        (tmp_path / name).write_text("")
    clear(tmp_path)
    assert len(list(tmp_path.iterdir())) == 4


def test_a_folder_is_replaced_whole_or_not_at_all(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "old").write_text("old")

    def half():
        with replaced_folder(folder) as beside:
            (beside / "new").write_text("new")
            raise KeyError

    with pytest.raises(KeyError):
        half()
    assert [p.name for p in folder.iterdir()] == ["old"]
    with replaced_folder(folder) as beside:
        (beside / "new").write_text("new")
    assert [p.name for p in folder.iterdir()] == ["new"]
    assert [p.name for p in tmp_path.iterdir()] == ["out"]
