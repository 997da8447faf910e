"""Vectors of a plant go through the whole range of the command, and say what the simulator says."""

from dataclasses import replace

import numpy as np
import pytest

from design.export.catalogue import part
from design.export.plant.part import of_plant
from design.export.plant.vectors import BEGIN, plant_csv, plant_vector, shares
from design.export.vectors import vector
from plants import Wrist
from plants.dynamics import read, settled, step
from plants.effects.effect import Around
from plants.effects.wrist.cross_coupling import Coupling
from tests.control.c_target import WRIST

COUPLED = Wrist.deviation() + Coupling(0.05)
FROM_50_kPa = replace(COUPLED, rig=replace(COUPLED.rig, pressure_range=(50.0, 200.0)))


def test_both_kinds_of_vectors_have_ten_thousand_samples():
    assert plant_vector(of_plant("plant", "a wrist", WRIST), WRIST).given.shape == (10_000, 1)
    assert len(vector(part("pi", "flexion", WRIST, (3.1, 10.4)), WRIST).rows) == 10_000


def test_a_quarter_of_the_samples_each_are_jumps_a_chirp_ramps_and_small_steps():
    found, k = shares(8000, np.random.default_rng(1)), np.arange(8000)
    assert (found >= 0.0).all()
    assert (found <= 1.0).all()
    assert (found[:400] == 0.5).all()  # at rest first
    jumps = found[400:2000].reshape(4, 400)
    assert (np.ptp(jumps, axis=1) == 0.0).all()
    assert len(set(jumps[:, 0])) == 4
    phase = 2.0 * np.pi * (0.0002 * k + 4e-8 * k**2)
    np.testing.assert_allclose(found[2000:4000], 0.5 + 0.45 * np.sin(phase[2000:4000]), atol=1e-9)
    ramps = np.diff(found[4000:6000])
    assert np.abs(ramps) == pytest.approx(1.0 / 1500.0, abs=1e-9)
    assert (found[4000:6000].min(), found[4000:6000].max()) == pytest.approx((0.0, 1.0), abs=1e-3)
    assert np.abs(found[6000:] - 0.5).max() <= 0.4 + 1e-12
    small = np.diff(found[6000:])
    assert np.std(small[small != 0.0]) == pytest.approx(0.01, rel=0.1)  # where it is not at an end
    assert len(shares(3, np.random.default_rng(1))) == 3


@pytest.mark.parametrize("wrist", [WRIST, COUPLED, FROM_50_kPa], ids=["alone", "coupled", "from 50 kPa"])
def test_what_a_vector_shows_is_the_law_sample_by_sample(wrist):
    made = of_plant("plant", "a wrist", wrist)
    found = plant_vector(made, wrist, 800, seed=4)
    low, high = wrist.rig.command_range
    first, last = wrist.rig.pressure_range
    np.testing.assert_allclose(
        found.given[:, 0], low + (high - low) * shares(800, np.random.default_rng(4)), atol=1e-12
    )
    other = np.full(800, wrist.rig.rest_pressure)
    if wrist is not WRIST:
        other = found.given[:, 1]
        wave = (other - wrist.rig.rest_pressure) / (0.3 * (last - first))
        np.testing.assert_allclose(wave, np.sin(np.arange(800) * 2.0 * np.pi / 3700.0 + 0.5), atol=1e-12)
    c, dt = wrist.sampled(), wrist.rig.sample_time
    state = settled(wrist.rest(), c, Around(BEGIN, other[0] - wrist.rig.rest_pressure))
    assert found.begin == BEGIN > 0.0
    shown = []
    for k in range(800):
        now = Around(BEGIN + k * dt, other[k] - wrist.rig.rest_pressure)
        state = step(state, found.given[k, 0], c, now)
        shown.append((float(read(state, c, now)), float(state.pressure)))
    np.testing.assert_allclose(found.shown, shown, atol=0.02)
    np.testing.assert_allclose(found.shown[:, 1], np.array(shown)[:, 1], atol=1e-9)
    head, *lines = plant_csv(made, found).splitlines()
    assert head.count(",") == found.given.shape[1] + 1
    table = np.array([[float(x) for x in line.split(",")] for line in lines])
    np.testing.assert_array_equal(table, np.column_stack([found.given, found.shown]))


@pytest.mark.parametrize("wrist", [WRIST, FROM_50_kPa])
def test_a_target_may_be_off_by_a_billionth_of_what_angle_and_pressure_range_over(wrist):
    first, last = wrist.rig.pressure_range
    low, high = wrist.hysteresis.reachable(first, last)
    told = of_plant("plant", "a wrist", wrist).tolerance
    assert told == pytest.approx((1e-9 * float(high - low), 1e-9 * (last - first)))
