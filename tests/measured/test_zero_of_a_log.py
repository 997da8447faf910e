"""What a log is counted from: for a rig that bends to one side a design counts the angle from the middle,
and the file of the plant keeps that for whoever reads another log."""

from dataclasses import replace

import numpy as np
import pytest

from design.cli.common import rig_of
from plants.errors import InputError
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.guess.rig import guessed_rig
from plants.measured.instrument.logger import counted_from
from plants.measured.trace.counting.middle import centred, near_zero, with_reachable_step
from plants.measured.trace.start import starting
from plants.parameters.files import built_in, dump, load
from plants.rig import Zero, built_in_rig
from plants.simulation.open_loop import open_loop
from plants.wrist import Wrist


@pytest.mark.slow
def test_only_for_a_design_the_angle_is_counted_from_the_middle(folder):
    campaign = load_campaign(folder)
    plain, begun = starting(campaign), starting(campaign, either_way=True)
    assert plain.parameters.rig.zero.angle == 0.0
    assert plain.parameters.rig.zero.pressure == pytest.approx(3.0, abs=0.1)
    angles = np.concatenate([r.angle for r in (*begun.campaign.fit, *begun.campaign.validate)])
    assert angles.max() == pytest.approx(-angles.min(), rel=0.1)
    assert begun.parameters.rig.zero.angle == pytest.approx(26.0, abs=2.0)
    assert any("counted from 26 deg" in str(r) for r in begun.instrument)
    assert begun.parameters.rig.zero.rest == -begun.parameters.rig.zero.angle  # it never moved from 0
    assert plain.parameters.rig.zero.rest == 0.0


def test_a_rig_that_bends_to_both_sides_keeps_its_zero(folder):
    campaign = load_campaign(folder)
    both = counted_from(campaign, Zero(angle=26.0))
    assert centred(both) == (both, ())
    assert centred(campaign)[0].start == "unknown"


@pytest.mark.parametrize("far", [1200.0, -1200.0])
def test_the_middle_is_found_however_far_from_zero_the_angles_lie(folder, far):
    campaign = counted_from(load_campaign(folder), Zero(angle=far))
    moved, (remark,) = centred(campaign)
    assert remark.value == pytest.approx(26.0 - far, abs=2.0)
    assert centred(moved) == (moved, ())


@pytest.mark.slow
@pytest.mark.parametrize("far", [170.0, -170.0])
def test_an_angle_far_from_zero_is_counted_from_the_lower_end_of_its_range(folder, far):
    plain, campaign = load_campaign(folder), counted_from(load_campaign(folder), Zero(angle=-far))
    assert near_zero(plain) == (plain, ())
    moved, (remark,) = near_zero(campaign)
    assert "far from zero for its range" in str(remark)
    low = min(r.angle.min() for r in (*plain.fit, *plain.validate))
    assert remark.value == pytest.approx(far + low, abs=1.0)
    assert near_zero(moved) == (moved, ())
    begun = starting(campaign)
    assert begun.parameters.rig.zero.angle == pytest.approx(remark.value, abs=1.0)  # offsets are off there


def test_recordings_that_start_at_rest_at_the_end_of_the_range_start_anywhere(folder):
    resting = replace(load_campaign(folder), start="rest")
    assert centred(resting)[0].start == "unknown"
    assert starting(resting).campaign.start == "rest"


def test_the_file_of_a_plant_keeps_the_zero_for_any_log(folder, tmp_path):
    zero, flexion = Zero(3.0, 26.0), built_in("flexion")
    own = replace(flexion.rig, zero=zero, command_range=(0.0, 4095.0))
    dump(replace(flexion, rig=own), tmp_path / "plant.toml")
    assert load(tmp_path / "plant.toml").rig.zero == zero
    raw, read = (load_campaign(folder, rig).fit[0] for rig in (None, rig_of(tmp_path / "plant.toml")))
    np.testing.assert_allclose(raw.angle - read.angle, 26.0)
    np.testing.assert_allclose(raw.pressure - read.pressure, 3.0)
    assert "zero" not in built_in_rig().record


def test_a_zero_that_is_no_number_is_refused_in_a_line(tmp_path):
    flexion = built_in("flexion")
    dump(replace(flexion, rig=replace(flexion.rig, zero=Zero(0.0, 26.0))), tmp_path / "plant.toml")
    text = (tmp_path / "plant.toml").read_text().replace("angle = 26.0", 'angle = "26"')
    (tmp_path / "plant.toml").write_text(text)
    with pytest.raises(InputError, match="angle = '26' is not a finite number"):
        load(tmp_path / "plant.toml")


def test_load_and_sensor_of_a_guessed_rig_are_of_its_size(folder):
    found, usual = guessed_rig(load_campaign(folder)), built_in_rig()
    assert found.uncertainty.load / found.task.step == pytest.approx(usual.uncertainty.load / usual.task.step)
    assert found.uncertainty.noise == pytest.approx(0.1, rel=0.15)  # the logger's
    assert found.uncertainty.resolution == pytest.approx(0.1)


def test_a_slow_regulator_has_more_time_to_settle(folder):
    found, usual = guessed_rig(load_campaign(folder)), built_in_rig()
    assert found.task.duration > usual.task.duration
    assert found.limits["settling_time_s"] == found.task.duration
    assert found.task.hold / found.task.duration == pytest.approx(usual.task.hold / usual.task.duration)


def test_the_step_of_a_guessed_rig_is_held_either_way_whatever_was_before(folder):
    begun = starting(load_campaign(folder), either_way=True).parameters
    wide = begun.rig.pressure_range[1] / 4.0
    widths = {"w1": wide * begun.values["a1"], "w2": wide * begun.values["a2"]}
    loop = {n: replace(p, value=widths.get(n, p.value)) for n, p in begun.parameters.items()}
    plant = replace(begun, parameters=loop)
    found = with_reachable_step(plant)
    step = found.rig.task.step
    assert 0.0 < step < plant.rig.task.step
    assert found.rig.uncertainty.load / step == pytest.approx(
        plant.rig.uncertainty.load / plant.rig.task.step
    )
    # Played by the simulation, from the other end of the range, each command held until the joint rests.
    low, high = plant.rig.command_range
    hold = np.full(round(30.0 / plant.rig.sample_time), 1.0)
    angle = open_loop(Wrist.of(plant), np.concatenate([high * hold, low * hold, high * hold]), None).angle
    assert angle[2 * len(hold) - 1] < -step
    assert angle[-1] > step
    assert with_reachable_step(found) is found
