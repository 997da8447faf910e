"""`wrist compare --design` plays the plants and the gains of a design as they are, or says what is wrong."""

import json
import shutil
from pathlib import Path

import pytest

from design.tuner.gains_file import write

REVISED = Path(__file__).parents[2] / "reports/examples/revised.toml"
GAINS = {"Kp": 6.47, "Ki": 18.4, "b": 0.7, "Tf": 0.0}
QUICK = ("--points", "6", "--samples", "0", "--mpc-plants", "0")


@pytest.fixture
def folder(tmp_path):
    """What a design leaves of one motion: the plant of the committed trace, with an effect of its sensor."""
    made = tmp_path / "design"
    made.mkdir()
    shutil.copy(REVISED, made / "plant-deviation.toml")
    write(made / "gains-deviation.toml", GAINS)
    return made


@pytest.mark.suite
def test_the_designs_own_gains_stand_in_the_comparison(wrist, folder, tmp_path):
    out = tmp_path / "report"
    outcome = wrist("compare", "--design", folder, *QUICK, "--out", out)
    assert outcome.code == 0, outcome.err
    record = json.loads((out / "comparison.json").read_text())
    printed = " ".join(outcome.out.split())  # lines are wrapped
    assert "left out, as in the design" in printed
    assert "it sits in the sensor: periodic-disturbance of deviation" in printed
    tuned = record["tunings"]["deviation"]
    assert {n: tuned[n] for n in GAINS} == GAINS
    assert tuned["given"] is True
    assert tuned["optimality"]["local_searches"] == []
    assert record["fits"] == {}
    assert list(record["plants"]) == ["deviation"]
    assert not any(n.startswith("periodic") for n in record["plants"]["deviation"])
    assert "synthetic" in record["made"]["remark"]
    page = (out / "comparison.html").read_text()
    assert "Nothing was searched here" in page
    assert (
        f"--gains {folder / 'gains-deviation.toml'} --plant {folder / 'plant-deviation.toml'}" in outcome.out
    )


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
