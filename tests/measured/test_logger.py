"""What a logger does is found and taken out: held channels, offsets, sensors at rest."""

from dataclasses import replace

import numpy as np
import pytest

from plants.measured.campaigns.campaign import load_campaign
from plants.measured.instrument.logger import corrected
from plants.measured.instrument.renewals import renewals
from plants.measured.instrument.saturation import longest
from plants.measured.residual.stillness import noise_of_campaign
from tests.rig.soft.named import CAMPAIGNS


@pytest.fixture(scope="module")
def plain():
    return load_campaign("plants/measured/examples/flexion")


def written(name, folder):
    make, fit, validate = CAMPAIGNS[name]
    make().write(folder, fit, validate)
    return load_campaign(folder)


def test_a_plain_log_is_left_as_it_is(plain):
    found, remarks = corrected(plain)
    assert remarks == ()
    assert found.fit == plain.fit


def test_a_held_channel_counts_where_it_was_renewed(tmp_path):
    campaign = written("arm-a", tmp_path)
    found, remarks = corrected(campaign)
    (held,) = [r for r in remarks if r.habit == "held"]
    assert held.channel == "pressure_kPa"
    assert held.value == pytest.approx(0.17, rel=0.05)
    fresh = found.fit[0].fresh("pressure_kPa")
    assert fresh.mean() == pytest.approx(0.0102 / 0.17, rel=0.1)
    before, after = campaign.fit[0].pressure, found.fit[0].pressure
    np.testing.assert_array_equal(after[fresh], before[fresh])
    # The true noise is 0.15 kPa; of the held values nothing could be said.
    assert noise_of_campaign(found.fit, "pressure_kPa") == pytest.approx(0.15, rel=0.1)


@pytest.mark.parametrize("step", [1.0, 0.05])
def test_a_coarse_sensor_is_not_held(step):
    slow = np.round(10.0 * np.sin(np.arange(4000) / 500) / step) * step
    assert renewals(slow) is None


def test_a_sensor_that_saturates_at_zero_is_remarked_and_not_refused(tmp_path):
    _, remarks = corrected(written("arm-b", tmp_path))
    (saturated,) = [r for r in remarks if r.habit == "saturated"]
    assert "reads exactly zero" in str(saturated)


def test_offsets_that_differ_between_recordings_are_taken_off(plain):
    shifts = (0.6, -0.4, 0.5)
    moved = tuple(replace(r, angle=r.angle + s) for r, s in zip(plain.fit, shifts, strict=False))
    found, remarks = corrected(replace(plain, fit=moved))
    (offset,) = [r for r in remarks if r.habit == "offset"]
    assert offset.value == pytest.approx(0.6, abs=0.05)
    for a, b in zip(found.fit, plain.fit, strict=True):
        np.testing.assert_allclose(a.angle, b.angle, atol=0.05)


@pytest.mark.parametrize("shifts", [(0.0, 0.0, 0.0), (0.6, -0.4, 0.5)])
def test_a_drift_at_rest_is_no_offset(plain, shifts):
    """Over eight seconds of rest the angle moves by 0.4 deg; where it began the sensor was right, or off."""
    moved = tuple(
        replace(r, angle=r.angle + s + 0.05 * (r.time - r.time[0]))
        for r, s in zip(plain.fit, shifts, strict=True)
    )
    found, remarks = corrected(replace(plain, fit=moved))
    assert [r.habit for r in remarks] == (["offset"] if any(shifts) else [])
    for a, b in zip(found.fit, plain.fit, strict=True):
        np.testing.assert_allclose(a.angle, b.angle + 0.05 * (b.time - b.time[0]), atol=0.05)


def test_the_longest_run():
    assert longest(np.array([True, False, True, True, True, False])) == 3
    assert longest(np.zeros(4, bool)) == 0
