"""Effects that are steep in time do not hide others, and do not pass for what a logger does."""

import pytest

from tests.rig.campaign import make_campaign
from tests.trace.traces import trace_folder


@pytest.mark.suite
def test_rate_dependence_is_found_beside_a_load_step(tmp_path):
    """The moment of the load is steep, and no fit of another effect beside it may stop for that."""
    forms = {"rate-dependence": 2, "load-step": 3}
    make_campaign(tmp_path, "deviation", ("rate-dependence", "load-step"), 77013, forms)
    found = trace_folder(tmp_path)
    assert found.verdict == "explained"
    assert {e.name for e in found.effects} == {"rate-dependence", "load-step"}
    assert found.after["angle_deg"] < 1.1 * found.noise["angle_deg"]


@pytest.mark.suite
def test_a_drift_is_not_taken_for_an_offset_of_the_sensor(tmp_path):
    """In the eight seconds of rest that the staircase begins with the sensor drifts by 0.4 deg."""
    make_campaign(tmp_path, "deviation", ("gyro-drift",), 77037, {"gyro-drift": 2})
    found = trace_folder(tmp_path)
    assert [e.name for e in found.effects] == ["gyro-drift"]
    assert not [r for r in found.remarks if "offset" in r]
    assert found.after["angle_deg"] < 1.1 * found.noise["angle_deg"]
