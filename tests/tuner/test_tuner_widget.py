"""The widget without a browser: sliders in, pictures out, limits and files refused in one line."""

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import traitlets

import design.tuner
from design.synthesis.requirements import Limits
from design.synthesis.tuning import Region
from design.tuner import Tuner
from plants import Wrist
from plants.effects import Creep, DeadTime
from plants.errors import InputError
from plants.parameters.files import built_in, dump
from reports.shared.figures import style

HERE = Path(design.tuner.__file__).parent


@pytest.fixture
def tuner():
    return Tuner("deviation")


def test_a_slider_that_moves_changes_the_picture_and_answers(tuner):
    before = tuner.picture
    tuner.set_state({"Ki": 60.0, "asked": 1})
    assert tuner.answered == 1
    assert tuner.picture != before
    assert (
        {row["name"] for row in tuner.picture["limits"] if row["broken"]} == set(tuner.shown.broken) != set()
    )


def test_two_sliders_at_once_make_one_picture(tuner, monkeypatch):
    made = []
    monkeypatch.setattr(
        "design.tuner.widget.picture", lambda *a, real=design.tuner.widget.picture: made.append(a) or real(*a)
    )
    tuner.set_state({"Kp": 3.0, "Ki": 9.0, "dead_time": 0.01, "asked": 4})
    assert len(made) == 1
    assert (tuner.shown.setting.Kp, tuner.shown.setting.dead_time, tuner.answered) == (3.0, 0.01, 4)


def test_gains_leave_the_map_and_the_plant_makes_another(tuner):
    before = tuner.regions
    tuner.Kp = 3.0
    assert tuner.regions is before
    tuner.dead_time = 0.08
    while not tuner.regions["complete"]:
        tuner.sharpen += 1
    assert tuner.regions["held"] != before["held"]
    assert tuner.regions["level"] > before["level"]


def test_no_loop_says_why_and_the_next_setting_shows_again(tuner):
    tuner.lines = 0.5
    tuner.transit = 3.0
    assert "runs backwards" in tuner.picture["trouble"]
    tuner.sharpen += 1
    tuner.transit = 1.0
    assert tuner.picture["trouble"] is None
    assert len(tuner.picture["series"]) == 10


def test_a_value_outside_the_slider_is_refused_in_one_line(tuner):
    with pytest.raises(traitlets.TraitError, match=r"^Kp: 500 is outside 0.5 to 20$"):
        tuner.Kp = 500.0
    with pytest.raises(traitlets.TraitError, match="dead_time: nan"):
        tuner.dead_time = float("nan")


def test_it_starts_at_the_wrist_that_it_is_given(tmp_path):
    late = Tuner(Wrist.flexion() + DeadTime(0.12) + Creep(0.1, 0.7))
    assert late.dead_time == 0.12
    assert late.about["sliders"][-1]["high"] == pytest.approx(0.24)
    dump(built_in("flexion"), tmp_path / "mine.toml")
    assert Tuner(tmp_path / "mine.toml").wrist == Tuner(built_in("flexion")).wrist == Wrist.flexion()
    with pytest.raises(InputError, match="nowhere"):
        Tuner(tmp_path / "nowhere.toml")


def test_limits_and_region_are_the_users():
    narrow = Tuner("flexion", replace(Limits.none(), Ms=1.3), Region((2.0, 4.0), (3.0, 9.0)))
    assert (narrow.Kp, narrow.Ki) == (2.0, 3.0)
    assert set(narrow.about["limits"]) == set(narrow.regions["limits"]) == {"Ms"}
    assert [row["limit"] for row in narrow.picture["limits"]].count("none") == 6


def test_the_button_keeps_the_gains_and_replaces_only_its_own_file(tuner, tmp_path):
    path = tmp_path / "gains.toml"
    tuner._handle_custom_msg({"keep": str(path)}, [])
    assert tuner.kept["done"]
    assert str(path) in tuner.kept["words"]
    assert tuner.kept["command"] == "wrist robust --axis deviation --gains gains.toml"
    tuner.Kp = 4.0
    assert tuner.keep(path) == path
    text = path.read_text()
    assert "value = 4.0" in text
    other = Tuner("flexion")
    other._handle_custom_msg({"keep": str(path)}, [])
    assert not other.kept["done"]
    assert other.kept["words"] == f"{path}: exists already; choose another name"
    assert path.read_text() == text


def run(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=HERE.parents[1])


def test_neither_the_package_nor_the_command_imports_the_widgets_library():
    code = "import sys, design, design.tuner, design.cli.app; assert 'anywidget' not in sys.modules"
    assert run(code.replace(", design.cli.app", ", design.cli")).returncode == 0


def test_without_anywidget_one_line_says_what_to_install():
    done = run("import sys; sys.modules['anywidget'] = None\nfrom design.tuner import Tuner")
    last = done.stderr.strip().splitlines()[-1]
    assert (
        last == 'ImportError: the tuner needs anywidget; install it: pip install "wrist-workbench[notebooks]"'
    )


def test_its_colours_are_those_of_the_figures():
    css = (HERE / "tuner.css").read_text()
    for name in ("blue", "orange", "green", "purple", "sky"):
        assert re.search(rf"--{name}: (#\w+);", css).group(1) == getattr(style, name.upper()).lower()


def test_the_browser_is_sent_to_no_other_place():
    source = "".join((HERE / name).read_text() for name in ("drawing.js", "tuner.js", "tuner.css"))
    assert re.findall(r"\w+://[^\"'\s)]+", source) == ["http://www.w3.org/2000/svg"]
    assert "import(" not in source
