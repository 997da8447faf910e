"""Where the pressure is not explained to the noise, what is left of it drives the wrist: its sensor's noise
must not, since a loop that engages smoothly would then be named for ignoring it."""

import pytest

from tests.change.pairs import drawn, write
from tests.trace.traces import trace_folder

pytestmark = pytest.mark.suite


@pytest.mark.parametrize("number", [7, 40])
def test_nothing_of_the_joint_is_named_for_the_noise_of_the_pressure(number, tmp_path):
    """A supply of another form, and a gain that drifts, neither of which the pressure's model follows."""
    case, rig = drawn(502, 45)[number - 1]
    assert case.effects[0] in ("supply-droop", "gain-drift")
    found = trace_folder(write(rig, tmp_path))
    assert [e.name for e in found.effects] == [e for e in case.effects if e == "supply-droop"]
    assert found.after["angle_deg"] <= found.before["angle_deg"]
