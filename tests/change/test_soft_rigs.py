"""Two campaigns of a soft actuator that was traced from its log alone: parameters that the log hardly tells
from each other do not forgive a change."""

from dataclasses import replace

import pytest

from design.studies.check.campaigns import left_of
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.trace.change.refit import seen_alike
from plants.measured.trace.trace import trace_campaign
from tests.rig.soft.commands import wandering
from tests.rig.soft.drawn import recordings, soft_actuator


def later(rig, folder, softer):
    """A campaign of the actuator with other commands, its plays softer by a share."""
    top = rig.low + 0.9 * (rig.high - rig.low)
    commands = {
        **rig.commands,
        "steps": lambda: wandering(rig.low, top, 4.0, 60.0, 11),
        "check": lambda: wandering(rig.low, top, 3.0, 60.0, 12),
    }
    weights = tuple((1.0 - softer) * w for w in rig.weights)
    replace(rig, weights=weights, commands=commands).write(folder, ("stairs", "steps"), ("check",))
    return load_campaign(folder)


@pytest.mark.suite
@pytest.mark.parametrize("seed", [403, 405])
def test_a_softer_actuator_is_told_from_one_that_did_not_change(tmp_path, seed):
    rig = soft_actuator(seed)
    rig.write(tmp_path / "old", recordings(seed), ("check",))
    old = trace_campaign(load_campaign(tmp_path / "old"))
    for softer in (0.0, 0.05):
        campaign, _ = seen_alike(old, later(rig, tmp_path / f"{softer}", softer))
        angles = [c for r in left_of(old, campaign) for c in r.channels if c.channel == "angle_deg"]
        assert [c.new for c in angles] == [softer > 0.0] * len(angles)
        assert max(c.allowed for c in angles) < 0.4
