"""Traces of other people's rigs end with an answer that holds together, whatever it is."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from benchmarks.real_rigs.data import Rig, checksums, convert, desired, rigs
from benchmarks.real_rigs.outcome import Outcome, outcome, record, shortened
from plants.files import json_text
from plants.measured.campaigns.campaign import load_campaign

DATA = os.environ.get("WRIST_DATA")
pytestmark = pytest.mark.skipif(not DATA, reason="WRIST_DATA is not set: no measured data at hand")
FOLDER = Path(str(DATA))


def rig(name: str) -> Rig:
    return next(r for r in rigs(FOLDER) if r.name == name)


@pytest.fixture(scope="module")
def smallest(tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    """The trace of the pump's steps, the campaign with the fewest rows."""
    return outcome(rig("pressure-loop-steps"), FOLDER, tmp_path_factory.mktemp("real"))


@pytest.mark.parametrize(
    "name", ["pressure-loop-steps", "pressure-loop-staircases", "pam-joint-0", "pam-joint-3"]
)
def test_a_rig_becomes_a_campaign_that_loads_without_a_warning(tmp_path: Path, name: str):
    made = rig(name)
    place = convert(made, FOLDER, tmp_path)
    c = load_campaign(place)
    assert (c.axis, c.stage, c.start) == (name, made.stage, "unknown")
    assert [r.name for r in c.fit + c.validate] == [Path(n).stem + ".csv" for n in made.sources]
    assert all(len(digest) == 64 for digest in checksums(made, FOLDER).values())
    assert all(r.extra and r.pressure is not None for r in c.fit + c.validate)


@pytest.mark.parametrize("name", ["pam-joint-0", "pam-joint-3"])
def test_the_rebuilt_set_point_leads_the_measured_pressure(tmp_path: Path, name: str):
    c = load_campaign(convert(rig(name), FOLDER, tmp_path))
    delay = 3
    wanted = np.concatenate([r.command[:-delay] for r in c.fit])
    followed = np.concatenate([r.pressure[delay:] for r in c.fit if r.pressure is not None])
    assert np.corrcoef(wanted, followed)[0, 1] > 0.95


def test_a_desired_pressure_adds_up_actions_and_stays_within_its_range():
    found = desired(np.array([0.5]), np.array([[2.0], [100.0], [-1.0], [-100.0]]))
    np.testing.assert_allclose(found[:, 0], [0.63, 1.0, 0.935, 0.0])


@pytest.mark.suite
def test_the_trace_of_a_rig_ends_with_a_verdict(smallest: Outcome):
    assert smallest.stopped is None
    assert smallest.trace is not None
    assert smallest.trace.verdict in ("nothing-missing", "explained", "unexplained")
    assert (smallest.trace.verdict == "unexplained") == bool(smallest.trace.unexplained)


@pytest.mark.suite
def test_the_revised_wrist_is_no_worse_on_recordings_held_out(smallest: Outcome):
    t = smallest.trace
    assert t is not None
    before, after, noise = (side["pressure_kPa"] for side in (t.before, t.after, t.noise))
    assert before is not None
    assert after is not None
    assert noise is not None
    assert noise <= after <= before
    for error, interval in ((before, t.before_interval), (after, t.after_interval)):
        low, high = interval["pressure_kPa"] or (np.nan, np.nan)
        assert low <= error <= high


@pytest.mark.suite
def test_the_numbers_are_json_without_a_place_of_this_machine(smallest: Outcome):
    text = json_text(shortened(record(smallest, FOLDER)))
    said = json.loads(text)
    assert said["channels"]["pressure_kPa"]["before"] > 0.0
    assert set(said["sha256"]) == set(smallest.rig.sources)
    assert str(FOLDER) not in text
    assert str(Path.home()) not in text
