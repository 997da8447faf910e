"""A pressure that counts from another zero in each recording, as with the air's, is told from one that does
not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plants.measured.campaigns.campaign import load_campaign
from plants.measured.instrument.logger import corrected
from plants.measured.instrument.pressure_offsets import pressure_offsets

EXAMPLES = Path(__file__).parents[2] / "plants/measured/examples"


@pytest.fixture(scope="module", params=["flexion", "deviation"])
def campaign(request):
    return load_campaign(EXAMPLES / request.param)


def test_pressures_of_one_zero_have_no_offset(campaign):
    assert pressure_offsets(campaign) == {}


def test_offsets_that_stay_are_found_about_their_mean_and_taken_off(campaign):
    given = dict(zip(campaign.names, np.random.default_rng(2).uniform(-3.0, 3.0, 20), strict=False))
    moved = campaign.each(lambda r: replace(r, pressure=r.pressure + given[r.name]))
    found = pressure_offsets(moved)
    assert len(found) >= 3
    assert "sine.csv" not in found  # which does not begin at rest
    off = {
        r.name: float(np.mean(r.pressure - plain.pressure))
        for r, plain in zip(moved.recordings, campaign.recordings, strict=True)
        if r.name in found
    }
    mean = float(np.mean(list(off.values())))
    for name, value in off.items():
        assert found[name] == pytest.approx(value - mean, abs=0.3)
    back, remarks = corrected(moved)
    assert "pressure sensor is offset" in " ".join(map(str, remarks))
    for one, plain in zip(back.recordings, campaign.recordings, strict=True):
        if one.name in off:
            assert float(np.mean(one.pressure - plain.pressure)) == pytest.approx(mean, abs=0.3)


def test_a_pressure_that_only_begins_elsewhere_is_no_offset(campaign):
    """As where a dead band holds what was there before."""

    def begun(r):
        away = 3.0 * np.exp(-np.maximum(r.time - r.time[0] - 1.5, 0.0) / 0.5)
        return replace(r, pressure=r.pressure + (away if r.name == campaign.names[1] else 0.0))

    assert pressure_offsets(campaign.each(begun)) == {}


def test_recordings_under_other_first_commands_say_nothing(campaign):
    def moved(r):
        i = campaign.names.index(r.name)
        command = r.command.copy()
        command[:90] += 0.5 * (i == 1)
        return replace(r, command=command, pressure=r.pressure + 2.0 * i)

    assert pressure_offsets(campaign.each(moved)) == {}
