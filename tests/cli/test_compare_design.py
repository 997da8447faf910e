"""`wrist compare --design` plays the plants and the gains of a design as they are, or says what is wrong."""

import json
import shutil
from pathlib import Path

import pytest

from design.alternatives.designs import design_record
from design.tuner.gains_file import write
from plants.errors import InputError

REVISED = Path(__file__).parents[2] / "reports/examples/revised.toml"
GAINS = {"Kp": 6.47, "Ki": 18.4, "b": 0.7, "Tf": 0.0}


@pytest.fixture
def folder(tmp_path):
    """What a design leaves of one motion: the plant of the committed trace, with an effect of its sensor."""
    made = tmp_path / "design"
    made.mkdir()
    shutil.copy(REVISED, made / "plant-deviation.toml")
    write(made / "gains-deviation.toml", GAINS)
    return made


@pytest.fixture
def asked(monkeypatch):
    """The questions that a comparison is asked, which are not answered."""
    questions = []

    def study(question, tell):
        questions.append(question)
        raise InputError("asked")

    monkeypatch.setattr("design.studies.study.study", study)
    return questions


def test_the_designs_own_plants_and_gains_are_asked_for(wrist, folder, asked):
    """That the comparison plays exactly these, CI asserts of the one that `make compare` makes."""
    outcome = wrist("compare", "--design", folder)
    (question,) = asked
    printed = " ".join(outcome.out.split())  # lines are wrapped
    assert "left out, as in the design" in printed
    assert "left out, as in the design: periodic-disturbance of deviation" in printed
    assert list(question.plants) == ["deviation"]
    assert not any(n.startswith("periodic") for n in question.plants["deviation"].values)
    assert question.fits == {}
    c = question.given["deviation"]
    assert {"Kp": c.Kp, "Ki": c.Ki, "b": c.b, "Tf": c.Tf} == GAINS


def test_the_lqi_and_the_feedforward_of_the_design_are_asked_for(wrist, folder, asked):
    gains = {"Ke": 536.0, "Kd": -774.0, "Kq": -65.7, "jump": 3.2, "bandwidth": 7.47}
    told = {
        "gains": gains,
        "cost": 8.7,
        "worst_excess": 0.1,
        "worst_excess_of": "overshoot_percent",
        "cases": 58,
    }
    record = {"designs": {"deviation": {"PI": {}, "robust LQI": told}}}
    (folder / "design.json").write_text(json.dumps(record))
    wrist("compare", "--design", folder)
    (found,) = asked[0].others["deviation"].values()
    assert list(asked[0].others["deviation"]) == ["robust LQI"]
    assert {n: getattr(found.controller, n) for n in gains} == gains
    assert found.controller.Tw == float(asked[0].wrists["deviation"].Tw)
    assert found.breaks == ("overshoot_percent",)
    assert design_record(found)["breaks"] == ["overshoot_percent"]
    (folder / "design.json").write_text('{"designs": {"deviation": {"robust LQI": {}}}}')
    refused(wrist("compare", "--design", folder), "design.json: no record of a design")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--example",), "leave out --example"),
        (("--plain",), "leave out --plain"),
        (("--plant", "x.toml"), "leave out --plant"),
        (("somewhere",), "leave out a campaign"),
    ],
)
def test_what_a_design_has_is_not_given_again(wrist, folder, tmp_path, words, said):
    refused(wrist("compare", "--design", folder, *words, "--out", tmp_path / "r"), said)


def test_a_folder_that_is_no_design_is_told(wrist, folder, tmp_path):
    out = tmp_path / "r"
    refused(wrist("compare", "--design", tmp_path / "none", "--out", out), "holds no plant-MOTION.toml")
    (folder / "gains-deviation.toml").unlink()
    refused(wrist("compare", "--design", folder, "--out", out), "gains-deviation.toml")
    assert not Path(out).exists()


def refused(outcome, said):
    assert outcome.code == 2
    assert said in outcome.err
    assert outcome.err.count("\n") == 1
