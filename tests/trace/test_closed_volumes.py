"""A syringe is named as what it is: a closed volume, whose pressure is a curve over the stroke, and which
loses air for good.

The rig is that of `tests.rig.soft.syringe`, an ideal gas.  Before there were forms for either, a straight
line and its zero were fitted to the pressure.
"""

import pytest

from plants.measured.campaigns.campaign import load_campaign
from plants.measured.instrument.logger import corrected
from plants.measured.trace.counting.zero import counted
from plants.measured.trace.trace import trace_campaign
from tests.rig.soft.syringe import OUTSIDE, Syringe


@pytest.mark.parametrize("loss", [0.0, 0.001])
def test_a_closed_volume_is_found_with_its_gain_and_its_curve(tmp_path, loss):
    rig = Syringe(loss=loss)
    rig.write(tmp_path)
    trace = trace_campaign(load_campaign(tmp_path))
    named = {(e.name, e.form) for e in trace.effects}
    sags = {("leak", "out of a closed volume")} if loss else set()
    assert named == {("regulator-curvature", "hyperbola of the command")} | sags
    v = trace.revised.values
    assert v["gain"] == pytest.approx(rig.gain, rel=0.02)
    # P = T / (1 - c T / R) with T = gain u is Boyle's law with c = R / outside.
    low, high = trace.revised.rig.pressure_range
    assert v["regulator-curvature.curvature"] == pytest.approx((high - low) / OUTSIDE, rel=0.05)
    if loss:
        assert v["leak.rate"] == pytest.approx(loss, rel=0.2)
    assert trace.after["pressure_kPa"] < 1.1 * trace.noise["pressure_kPa"]


def test_the_zero_is_that_of_the_curve(tmp_path):
    Syringe(loss=0.001).write(tmp_path)
    assert counted(corrected(load_campaign(tmp_path))[0])[1] == ()
