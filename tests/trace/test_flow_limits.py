"""A valve that is fully open is named for what it does, not for a supply that sags."""

import pytest

from tests.rig.campaign import make_campaign
from tests.trace.traces import trace_folder


@pytest.mark.suite
@pytest.mark.parametrize(("axis", "seed"), [("flexion", 1), ("deviation", 2)])
def test_flow_that_saturates_is_an_asymmetry_with_limits(axis, seed, tmp_path):
    """The rig's valve comes to its limit smoothly, which the library's does not."""
    make_campaign(tmp_path, axis, ("fill-exhaust-asymmetry",), seed, {"fill-exhaust-asymmetry": 4})
    found = trace_folder(tmp_path)
    assert found.verdict == "explained"
    assert [(e.name, e.form) for e in found.effects] == [
        ("fill-exhaust-asymmetry", "a limit of the flow each way")
    ]
    assert all(found.after[c] < 2.2 * found.noise[c] for c in ("pressure_kPa", "angle_deg"))
    assert found.after["angle_deg"] < 0.5 * found.before["angle_deg"]
