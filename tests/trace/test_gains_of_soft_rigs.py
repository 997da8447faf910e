"""Gains that are tuned on what a trace makes of a log hold on the actuator that was logged.

The actuator is of `tests.rig.soft.named`, which shares no code with the library; it bends to one side.
"""

from dataclasses import replace

import numpy as np
import pytest

from design.robustness.tuning.recommended import tune_candidates
from design.studies.design_study import Taken, required_of
from design.synthesis.designed_plant import designed
from plants.effects.effect import dead_time_of
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.trace.trace import trace_for_design
from plants.parameters.files import dump, load
from plants.rig import Zero
from plants.wrist import Wrist
from tests.promise.soft import held
from tests.rig.soft.named import CAMPAIGNS


@pytest.mark.suite
def test_steps_about_the_middle_of_the_range_of_a_bending_actuator(tmp_path):
    make, fit, validate = CAMPAIGNS["bender"]
    make().write(tmp_path / "bender", fit, validate)
    _, revised = trace_for_design(load_campaign(tmp_path / "bender"))
    zero = revised.rig.zero
    assert zero.angle == pytest.approx(26.0, abs=2.0)
    assert zero.pressure == pytest.approx(3.0, abs=0.1)  # the actuator's bias
    dump(revised, tmp_path / "plant.toml")
    plant = load(tmp_path / "plant.toml")
    assert plant.rig == revised.rig
    read = load_campaign(tmp_path / "bender", plant.rig).fit[0]
    raw = load_campaign(tmp_path / "bender").fit[0]
    assert plant.rig.zero != Zero()
    np.testing.assert_allclose(raw.angle - read.angle, zero.angle)
    tuned = tune_candidates(required_of(designed(plant), Taken())).best
    assert tuned.holds
    seen = held(make(), tuned.final.gains, plant)
    assert seen.kept, str(seen)


@pytest.mark.suite
def test_gains_for_valves_that_the_command_opens_hold_on_the_rig(tmp_path):
    """No regulator: the gain from the command to the pressure changes three times over the range."""
    make, fit, validate = CAMPAIGNS["finger"]
    make().write(tmp_path / "finger", fit, validate)
    trace, revised = trace_for_design(load_campaign(tmp_path / "finger"))
    assert "valves opened by the command" in {e.form for e in trace.effects}
    tuned = tune_candidates(required_of(designed(revised), Taken())).best
    assert tuned.holds
    seen = held(make(), tuned.final.gains, revised)
    assert seen.kept, str(seen)


@pytest.mark.suite
def test_what_a_late_sensor_delays_is_dead_time_of_the_loop(tmp_path):
    """A log does not tell a sensor that is late from a logger that is; a loop behind the sensor would have a
    dead time that its design did not know."""
    make, fit, validate = CAMPAIGNS["bender"]
    rig, late = make(), 0.2
    replace(rig, logger=replace(rig.logger, angle_delay=late)).write(tmp_path / "late", fit, validate)
    _, revised = trace_for_design(load_campaign(tmp_path / "late"))
    assert revised.rig.angle_delay == pytest.approx(late, abs=0.05)
    plant = designed(revised)
    assert dead_time_of(Wrist.of(plant).effects) == pytest.approx(late + rig.delay, abs=0.1)
    # Whether any gains hold every limit in the model hangs on the rounding of the processor: the quick part
    # of the creep lies at a bound, and next to nothing is told of it.  Those that are given, at worst the
    # nearest, have to hold on the actuator.
    tuned = tune_candidates(required_of(plant, Taken())).best
    # In a loop a delay of the sensor and one of the command are the same.
    seen = held(replace(rig, delay=rig.delay + late), tuned.final.gains, revised)
    assert seen.kept, str(seen)
