"""What no effect explains is learnt only where that helps, and never passes for a cause."""

import json

import pytest

from plants.effects.wrist.learnt_block import LearntBlock
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.trace.trace import trace_campaign
from plants.parameters.files import built_in
from reports.trace.record import trace_record
from reports.trace.words import block_words
from tests.rig.campaign import make_campaign


@pytest.mark.suite
def test_a_sensor_that_sits_eccentrically_is_learnt_without_a_cause(tmp_path):
    """No effect of the library is one; a curve of the branches describes most of it, and the block lowers the
    error further on data that chose nothing."""
    make_campaign(tmp_path, "flexion", ("eccentric-sensor",), 20)
    campaign = load_campaign(tmp_path)
    trace = trace_campaign(campaign, built_in("flexion"), learning=True)
    assert trace.verdict == "unexplained"
    assert isinstance(trace.block, LearntBlock)
    assert "learnt" not in [e.name for e in trace.effects]
    assert trace.named_only["angle_deg"] < 0.5 * trace.before["angle_deg"]
    assert trace.after["angle_deg"] < trace.named_only["angle_deg"]
    without = trace_campaign(campaign, built_in("flexion"))
    assert without.after == trace.named_only
    assert [e.name for e in without.effects] == [e.name for e in trace.effects]
    assert "names no cause" in block_words(trace)[0]
    assert block_words(without) == []
    record = json.loads(json.dumps(trace_record(trace)))["learnt_block"]
    assert record["without"]["angle_rmse_deg"] == without.after["angle_deg"]
    assert trace_record(without)["learnt_block"] is None


@pytest.mark.suite
def test_nothing_is_learnt_of_a_rig_that_lacks_nothing(tmp_path):
    make_campaign(tmp_path, "deviation", (), 21)
    trace = trace_campaign(load_campaign(tmp_path), built_in("deviation"), learning=True)
    assert trace.verdict == "nothing-missing"
    assert trace.block is None
    assert block_words(trace) == ["No learnt block: the angle has no residual that is left unexplained."]
