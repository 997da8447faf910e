"""A scenario file gives back the run that it was saved from, to the bit; a bad one is told in one line."""

import tomllib
from dataclasses import replace

import pytest

from design.controllers.feedforward import Feedforward
from design.controllers.pi import PI
from design.evaluation.cases import stack
from design.evaluation.runner import play
from design.robustness.box import box_of
from design.robustness.samples.adversary import worst_case
from design.robustness.samples.scenario_file import load, save
from plants import Wrist
from plants.effects.wrist.creep import Creep
from plants.errors import InputError
from plants.parameters.files import built_in
from plants.parameters.files import load as load_plant


@pytest.fixture(scope="module")
def found():
    """A worst case with everything in it: an effect of the plant's own, dead time and load."""
    plant = built_in("deviation").revised(
        [Creep], {"creep.gain": 0.08, "creep.time_constant": 3.0}, {}, "a test"
    )
    return worst_case(box_of(plant), PI(3.1, 7.3), dead_time=0.03, load=1.0, budget=64, duration=2.0)


@pytest.fixture
def path(found, tmp_path):
    save(found, tmp_path / "worst.toml")
    return tmp_path / "worst.toml"


def test_what_is_saved_is_what_is_loaded(found, path):
    saved = load(path)
    assert saved.case == found.case
    assert saved.controller == found.controller
    assert saved.metrics == found.metrics
    assert saved.plant == found.plant


def test_a_replay_has_the_metrics_that_were_saved(path):
    saved = load(path)
    played = play(stack([saved.case]), saved.controller)
    assert {n: float(v[0]) for n, v in vars(played.metrics).items()} == saved.metrics


def test_the_plant_of_a_file_is_a_parameter_set(found, path):
    plant = load_plant(path)
    assert plant.values == found.case.wrist.values
    assert plant.effects == (Creep,)
    assert str(plant.parameters["Tw"].provenance).startswith("assumed: worst case found by search within")


def test_numbers_that_are_infinite_survive(found, tmp_path):
    never = replace(found, metrics={**found.metrics, "settling_time_s": float("inf")})
    save(never, tmp_path / "never.toml")
    assert load(tmp_path / "never.toml").metrics["settling_time_s"] == float("inf")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[scenario]", "[scene]", "unknown key .scene."),
        ("[controller]", "[control]", "unknown key .control."),
        ("[metrics]", "[metric]", "unknown key .metric."),
        ("start = ", "begin = ", "unknown key .begin."),
        ("holds = [", "holds = [1.0, ", "references but"),
        ("references = [", 'references = ["a", ', r"references\[0\]"),
        ("references = [", "references = [400.0, ", "references"),
        ("holds = [", "holds = [nan, ", r"holds\[0\]"),
        ("dead_time = ", "dead_time = 7", "dead_time"),
        ("Kp = ", "Kp = -", "Kp"),
        ("Kp = ", "Kq = ", "unknown key .Kq."),
        ("iae_deg_s = ", "iae = ", "unknown key .iae."),
        ("unit = ", "uni = ", "unit"),
    ],
)
def test_bad_files_are_told_in_one_line(path, old, new, words):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=words) as error:
        load(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


def test_a_file_that_is_not_there_or_cannot_be_written(found, tmp_path):
    with pytest.raises(InputError, match="no such"):
        load(tmp_path / "none.toml")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        save(found, tmp_path / "file" / "worst.toml")


def test_units_stand_beside_the_numbers(path):
    text = path.read_text()
    tomllib.loads(text)
    assert "Kp = 3.1 # kPa/deg" in text
    assert "# deg s²" in text


def test_a_worst_case_of_another_controller_is_refused(found, tmp_path):
    other = replace(found, controller=Feedforward.of(Wrist.flexion()))
    assert other.record["speed"] == 25.0
    with pytest.raises(InputError, match="holds the settings of a PI, not of a Feedforward"):
        save(other, tmp_path / "other.toml")
    assert not list(tmp_path.iterdir())
