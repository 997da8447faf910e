"""A regulator of second order, or one that small commands do not open, is named as what it is.

The rig is that of `tests.rig.soft.proportional`, made by scipy.  Before there were forms for either, both
were named as valves without a regulator.
"""

import pytest

from plants.measured.campaigns.campaign import load_campaign
from plants.measured.instrument.logger import corrected
from plants.measured.trace.counting.zero import counted
from plants.measured.trace.trace import trace_campaign
from tests.rig.soft.proportional import Proportional


def traced(folder, rig):
    rig.write(folder)
    return trace_campaign(load_campaign(folder))


def test_a_regulator_of_second_order_is_found_with_its_parameters(tmp_path):
    rig = Proportional()
    trace = traced(tmp_path, rig)
    assert [(e.name, e.form) for e in trace.effects] == [("dead-time", "transport and a second-order lag")]
    v = trace.revised.values
    assert v["dead-time.damping"] == pytest.approx(rig.damping, abs=0.05)
    assert 1.0 / v["dead-time.inertia"] == pytest.approx(rig.natural, rel=0.1)
    assert trace.after["pressure_kPa"] < 1.1 * trace.noise["pressure_kPa"]


def test_a_least_command_is_found_and_the_zero_beside_it(tmp_path):
    rig = Proportional(dead=1.2)
    trace = traced(tmp_path, rig)
    assert {(e.name, e.form) for e in trace.effects} == {
        ("dead-time", "transport and a second-order lag"),
        ("regulator-deadband", "no answer to the smallest commands"),
    }
    assert trace.revised.values["regulator-deadband.least"] == pytest.approx(rig.gain * rig.dead, abs=0.5)
    assert trace.after["pressure_kPa"] < 1.2 * trace.noise["pressure_kPa"]


def test_the_zero_is_not_that_of_a_line_through_the_level_part(tmp_path):
    rig = Proportional(dead=1.2)
    rig.write(tmp_path)
    (remark,) = counted(corrected(load_campaign(tmp_path))[0])[1]
    assert remark.value == pytest.approx(-rig.gain * rig.dead, abs=1.0)
