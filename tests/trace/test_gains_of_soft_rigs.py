"""Gains that are tuned on what a trace makes of a log hold on the actuator that was logged.

The actuator is of `tests.rig.soft`, which shares no code with the library; it bends to one side.
"""

import numpy as np
import pytest

from design.robustness.tuning.recommended import tune_candidates
from design.studies.design_study import Taken, required_of
from design.synthesis.designed_plant import designed
from plants.measured.campaign import load_campaign
from plants.measured.trace.trace import trace_campaign
from plants.parameters.files import dump, load
from plants.rig import Zero
from tests.promise.soft import held
from tests.rig.soft import CAMPAIGNS


@pytest.mark.suite
def test_steps_about_the_middle_of_the_range_of_a_bending_actuator(tmp_path):
    make, fit, validate = CAMPAIGNS["bender"]
    make().write(tmp_path / "bender", fit, validate)
    trace = trace_campaign(load_campaign(tmp_path / "bender"), either_way=True)
    zero = trace.revised.rig.zero
    assert zero.angle == pytest.approx(26.0, abs=2.0)
    assert zero.pressure == pytest.approx(3.0, abs=0.1)  # the actuator's bias
    dump(trace.revised, tmp_path / "plant.toml")
    plant = load(tmp_path / "plant.toml")
    assert plant.rig == trace.revised.rig
    read = load_campaign(tmp_path / "bender", plant.rig).fit[0]
    raw = load_campaign(tmp_path / "bender").fit[0]
    assert plant.rig.zero != Zero()
    np.testing.assert_allclose(raw.angle - read.angle, zero.angle)
    tuned = tune_candidates(required_of(designed(plant), Taken())).best
    assert tuned.holds
    seen = held(make(), tuned.final.gains, plant)
    assert seen.kept, str(seen)
