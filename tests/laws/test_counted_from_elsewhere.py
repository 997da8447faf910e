"""A plant whose angle is counted from elsewhere moves as it did: what it simulates differs by that angle."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from plants.effects import EFFECTS
from plants.measured.trace.counting.middle import about_middle, counted_elsewhere
from plants.parameters.files import built_in, dump, load
from plants.parameters.quantities import Stated
from plants.rig import Zero
from plants.wrist import Wrist
from tests.laws.second_law import second_law_set

MIDDLE = 16.0
SAID = Stated("the test", "its middle")

PLANTS = {"four-segment": built_in("flexion"), "prandtl-ishlinskii": second_law_set()}
OF_THE_WRIST = [form for forms in EFFECTS.values() for form in forms if form.STAGE == "wrist"]


def with_effect(plant, form):
    """The plant with an effect at the last of the values at which it is tried."""
    values = list(form.trials(plant.rig))[-1]
    found = {f"{form.NAME}.{n}": v for n, v in values.items()}
    return plant.revised((form,), found, {}, "the test")


def commands(plant):
    rng = np.random.default_rng(5)
    return np.repeat(rng.uniform(*plant.rig.command_range, 12), 700)


def runs(plant, moved):
    """Angle and pressure of both from rest at the middle."""
    first, second = Wrist.of(plant), Wrist.of(moved)
    begun = first.rest("inside", MIDDLE), second.rest("virgin", 0.0)
    return [w.simulate(commands(plant), state=s) for w, s in zip((first, second), begun, strict=True)]


@pytest.mark.parametrize("law", PLANTS)
def test_the_declared_plant(law):
    moved = counted_elsewhere(PLANTS[law], MIDDLE, SAID)
    assert moved.rig.zero == Zero(angle=MIDDLE)
    was, now = runs(PLANTS[law], moved)
    assert np.ptp(was.angle) > 30.0
    np.testing.assert_allclose(now.angle, was.angle - MIDDLE, atol=1e-9)


@pytest.mark.parametrize("law", PLANTS)
@pytest.mark.parametrize("form", OF_THE_WRIST, ids=lambda f: f"{f.NAME}, {f.FORM}")
def test_with_each_effect_of_the_wrist(law, form):
    plant = with_effect(PLANTS[law], form)
    was, now = runs(plant, counted_elsewhere(plant, MIDDLE, SAID))
    np.testing.assert_allclose(now.pressure, was.pressure, atol=1e-7)
    np.testing.assert_allclose(now.angle, was.angle - MIDDLE, atol=1e-6)


@pytest.mark.parametrize("law", PLANTS)
def test_its_file_keeps_it(law, tmp_path):
    moved = counted_elsewhere(PLANTS[law], MIDDLE, SAID)
    dump(moved, tmp_path / "plant.toml")
    read = load(tmp_path / "plant.toml")
    assert read.values == moved.values
    assert Wrist.of(read).hysteresis == Wrist.of(moved).hysteresis


@pytest.mark.parametrize("law", PLANTS)
def test_counted_twice_is_counted_once(law):
    loop = Wrist.of(PLANTS[law]).hysteresis
    twice, once = loop.counted_from(120.0, 5.0).counted_from(140.0, 7.0), loop.counted_from(140.0, 12.0)
    pressures = np.linspace(0.0, 200.0, 50)
    for of in ("ascending", "descending"):
        np.testing.assert_allclose(getattr(twice, of)(pressures), getattr(once, of)(pressures))
        np.testing.assert_allclose(getattr(once, of)(pressures), getattr(loop, of)(pressures) - 12.0)
    np.testing.assert_allclose(twice.rise(pressures), loop.rise(pressures))
    for half, own in zip(twice.halves(pressures), loop.halves(pressures), strict=True):
        np.testing.assert_allclose(half, own)


def logged(*angles):
    """A log in which the angle goes between these."""
    return SimpleNamespace(name="log", fit=(SimpleNamespace(angle=np.array(angles)),), validate=())


def test_a_plant_that_goes_to_both_sides_stays_as_it_is():
    assert about_middle(PLANTS["four-segment"], logged(-20.0, 20.0)) is PLANTS["four-segment"]


def test_one_that_goes_to_one_side_is_counted_from_the_middle_of_what_it_reaches():
    """The descending branch keeps it from the end where it started: a step is a third of what is left."""
    plant = PLANTS["four-segment"]
    rig = replace(plant.rig, pressure_range=(100.0, 200.0))
    moved = about_middle(replace(plant, rig=rig), logged(0.0, 40.0))
    loop = Wrist.of(plant).hysteresis
    low, high = float(loop.descending(100.0)), min(float(loop.ascending(197.6)), 40.0)
    assert moved.rig.zero.angle == pytest.approx(0.5 * (low + high), abs=0.5)
    assert moved.rig.task.step == pytest.approx((high - low) / 3.0, rel=0.05)
    assert moved.rig.uncertainty.load / rig.uncertainty.load == pytest.approx(moved.rig.task.step / 15.0)


def test_an_angle_with_the_opposite_sign_is_counted_from_the_other_side_of_the_log():
    plant = PLANTS["four-segment"]
    falling = replace(plant, rig=replace(plant.rig, zero=Zero(angle=3.0, reversed=True)))
    moved = counted_elsewhere(falling, MIDDLE, SAID)
    assert moved.rig.zero == Zero(angle=3.0 - MIDDLE, reversed=True)
