"""The tuner of a rig in mm, at 20 ms and 0 to 10 V, is about that rig: its task, its limits, its units."""

import json
import re

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.steps import run
from design.tuner import Tuner
from design.tuner.picture import shown_samples
from plants import Wrist
from tests.cli.test_one_motion_rig import BENDER, VALUES

BEND = Wrist.from_values(VALUES, rig=BENDER)


@pytest.fixture(scope="module")
def tuner():
    return Tuner(BEND)


def test_what_is_shown_is_its_own_task(tuner):
    rows, pi = shown_samples(BENDER), PI.of(BEND, tuner.Kp, tuner.Ki)
    assert rows[-1] == 500
    assert tuner.shown.time[-1] == tuner.about["time_s"][-1] == 10.0
    assert {abs(s.case.task.reference) for s in tuner.shown.series} == {10.0, 0.0}
    for s in tuner.shown.series:
        task = s.case.task
        _, _, went = run(BEND, pi, task.reference, BEND.rest(task.start, task.angle), record=True)
        way = (went.angle[rows, 0] - task.angle) * np.sign(task.reference - task.angle)
        np.testing.assert_allclose(s.way, way, atol=1e-9)


def test_its_limits_range_and_gains_are_those_of_the_rig(tuner):
    assert tuner.limits.named == dict(BENDER.limits)
    assert (tuner.about["step"], tuner.about["command"], tuner.about["duration_s"]) == (
        10.0,
        [0.0, 10.0],
        10.0,
    )
    # The same pressure for the same share of the step: 10 mm where the wrist has 15 deg.
    assert tuner.region.Kp == pytest.approx((0.75, 30.0))
    assert tuner.region.Ki == pytest.approx((0.75, 150.0))
    assert (tuner.Kp, tuner.Ki) == pytest.approx((1.8, 3.3))
    while not tuner.regions["complete"]:
        tuner.sharpen += 1
    assert tuner.regions["held"]


def test_all_that_is_sent_is_in_its_units(tuner):
    sent = json.dumps([tuner.about, tuner.picture, tuner.regions], ensure_ascii=False)
    assert re.findall(r"\bdeg\b", sent) == []
    assert [s["unit"] for s in tuner.about["sliders"][:2]] == ["kPa/mm", "kPa/(mm s)"]
    assert tuner.picture["plant"]["lines"] == "a1 0.25, a2 0.25 mm/kPa"
    assert tuner.picture["iae"].endswith(" mm s")
    (travel,) = (row for row in tuner.picture["limits"] if row["name"] == "total_variation_V")
    assert travel["limit"] == "≤ 40 V"
    assert " mm from " in travel["place"]


def test_a_reference_that_no_command_holds_is_told_in_its_units():
    far = Tuner(BEND.with_values(w1=20.0))
    assert re.fullmatch(r"the command range is [\d.]+ V too small to hold \+10 mm", far.picture["note"])


def test_the_browser_knows_no_unit_and_no_number_of_the_task(tuner):
    assert not re.search(r"kPa|\[deg|\bdeg\b|\[V\]|volts", tuner._esm)
