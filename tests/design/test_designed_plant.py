"""What a design leaves out of a traced plant: effects of its sensor, and events of the recordings; what it
adds: the delay of its angle."""

from dataclasses import replace

import numpy as np
import pytest

from design.robustness.requirement import requirement
from design.synthesis.designed_plant import designed, events, in_loop, left_out, without
from plants import Wrist
from plants.effects import EFFECTS
from plants.effects.regulator.dead_time import DeadTime, TubeDeadTime
from plants.effects.regulator.leak import LaminarLeak
from plants.effects.sensor.gyro_drift import Drift
from plants.effects.wrist.load_step import GradualLoad, LoadStep
from plants.errors import InputError
from plants.parameters.files import built_in, dump, load


def plant_with(*forms, share=0.6):
    values = {f"{f.NAME}.{n}": k.low + share * (k.high - k.low) for f in forms for n, k in f.kinds().items()}
    return built_in("flexion").revised(forms, values, {}, "a test")


@pytest.mark.parametrize("load", [LoadStep, GradualLoad])
def test_a_sensors_effect_and_an_event_are_left_out_and_the_rest_stays(load):
    whole = plant_with(LaminarLeak, load, Drift)
    assert left_out(whole) == ("load-step", "gyro-drift")
    assert events(whole) == ("load-step",)
    kept = designed(whole)
    assert [e.NAME for e in kept.effects] == ["leak"]
    assert without(whole, events(whole)).effects == (LaminarLeak, Drift)
    assert not any(n.startswith(("load-step", "gyro")) for n in kept.parameters)
    plain = plant_with(LaminarLeak)
    assert kept.values == plain.values
    volts = np.full(3000, 3.1)
    np.testing.assert_array_equal(Wrist.of(kept).simulate(volts).angle, Wrist.of(plain).simulate(volts).angle)


def test_what_is_designed_for_has_the_loads_of_the_rig_as_cases():
    """With the event in the plant there would be none beside it (`Requirement.space`)."""
    assert "load" in requirement(designed(plant_with(LoadStep))).space.kinds
    assert "load" not in requirement(plant_with(LoadStep)).space.kinds


def test_a_load_that_was_picked_up_is_the_only_event():
    assert {e.NAME for forms in EFFECTS.values() for e in forms if e.EVENT} == {"load-step"}


@pytest.mark.parametrize("form", [None, DeadTime, TubeDeadTime])
def test_an_angle_that_is_read_late_is_dead_time_of_the_loop(form, tmp_path):
    plant = plant_with(*([] if form is None else [form]), share=0.3)
    own = plant.values.get("dead-time.delay", 0.0)
    late = replace(plant, rig=replace(plant.rig, angle_delay=0.08))
    dump(late, tmp_path / "late.toml")
    assert load(tmp_path / "late.toml").rig == late.rig
    looped = in_loop(late)
    assert looped.values["dead-time.delay"] == pytest.approx(own + 0.08)
    assert looped.rig.angle_delay == 0.0
    assert designed(late) == looped
    assert in_loop(looped) is looped  # it is added once
    rest = {n: p for n, p in looped.parameters.items() if n != "dead-time.delay"}
    assert rest == {n: p for n, p in plant.parameters.items() if n != "dead-time.delay"}
    volts = np.repeat([2.2, 3.1, 1.4], 1000)
    now, then = (Wrist.of(p).simulate(volts).angle for p in (plant, looped))
    np.testing.assert_allclose(then[80:], now[:-80], atol=1e-9)
    dump(looped, tmp_path / "looped.toml")
    assert load(tmp_path / "looped.toml").values == looped.values


def test_a_dead_time_that_no_delay_line_holds_is_refused_in_a_line():
    """It would be cut short without a word."""
    plant = plant_with(DeadTime, share=0.51)
    with pytest.raises(InputError, match="is more than 510 samples of 0"):
        designed(replace(plant, rig=replace(plant.rig, angle_delay=0.01)))
    slower = replace(plant.rig, sample_time=0.002, angle_delay=0.01)
    assert designed(replace(plant, rig=slower)).values["dead-time.delay"] == pytest.approx(0.52)
