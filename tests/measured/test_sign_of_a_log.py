"""A rig that nobody declared may be logged with an angle that falls as the pressure rises."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from design.export.catalogue import part
from plants.errors import InputError
from plants.measured.campaigns.campaign import Campaign, load_campaign
from plants.measured.campaigns.recording import Recording
from plants.measured.instrument.logger import counted_from
from plants.measured.trace.counting.sign import rising
from plants.measured.trace.start import starting
from plants.parameters.files import built_in, dump, load
from plants.rig import Zero
from plants.wrist import Wrist
from tests.rig.soft.named import CAMPAIGNS


@pytest.fixture(scope="module")
def falling(tmp_path_factory):
    """The bender, its angle logged with the opposite sign."""
    make, fit, validate = CAMPAIGNS["bender"]
    folder = tmp_path_factory.mktemp("soft") / "bender"
    make().write(folder, fit, validate)
    return counted_from(load_campaign(folder), Zero(reversed=True))


def test_the_angle_is_counted_with_the_opposite_sign(falling):
    begun = starting(falling)
    assert begun.parameters.rig.zero.reversed
    assert any("opposite sign" in str(r) for r in begun.instrument)
    for r, logged in zip(begun.campaign.fit, falling.fit, strict=True):
        assert np.corrcoef(r.angle, r.pressure)[0, 1] > 0.8
        assert np.corrcoef(r.angle, logged.angle)[0, 1] == pytest.approx(-1.0)
    assert rising(begun.campaign) == (begun.campaign, ())


def test_so_it_is_from_the_command_alone(falling):
    bare = replace(falling, fit=tuple(replace(r, pressure=None) for r in falling.fit))
    assert rising(bare)[1]


def test_a_later_log_is_read_as_the_one_that_was_traced(falling):
    """Sign and middle of the range, one after the other, are what the zero of the rig says at once."""
    begun = starting(falling, either_way=True)
    zero = begun.parameters.rig.zero
    assert zero.reversed
    assert zero.angle == pytest.approx(-26.0, abs=2.0)
    for r, logged in zip(begun.campaign.fit, falling.fit, strict=True):
        off = r.angle - logged.counted_from(zero).angle
        assert np.ptp(off) < 1e-9  # but for an offset of the recording
        assert abs(off[0]) < 0.5


def test_the_file_of_a_plant_keeps_it_and_exports_say_it(tmp_path):
    flexion, zero = built_in("flexion"), Zero(0.0, -26.0, True)
    dump(replace(flexion, rig=replace(flexion.rig, zero=zero)), tmp_path / "plant.toml")
    assert load(tmp_path / "plant.toml").rig.zero == zero
    wrist = Wrist.flexion()
    made = part("pi", "flexion", replace(wrist, rig=replace(wrist.rig, zero=zero)), (3.1, 10.4))
    assert any("the angle from -26 deg, with the opposite sign" in note for note in made.notes)
    text = (tmp_path / "plant.toml").read_text().replace("reversed = true", "reversed = 1")
    (tmp_path / "plant.toml").write_text(text)
    with pytest.raises(InputError, match="reversed"):
        load(tmp_path / "plant.toml")


def test_a_command_under_which_the_pressure_falls_is_refused(falling):
    def backwards(r):
        return replace(r, command=4095.0 - r.command)

    with pytest.raises(InputError, match="the pressure falls as the command rises; map command_V with scale"):
        rising(replace(falling, fit=tuple(map(backwards, falling.fit))))


@pytest.mark.parametrize(
    ("deepest", "named"), [(-60.0, "pressure_kPa, which is a vacuum's,"), (60.0, "command_V")]
)
def test_what_is_to_be_turned_where_the_pressure_falls_is_named(deepest, named):
    """A pump that sucks, logged as a gauge has it, and a regulator that is commanded the other way round."""
    time = np.arange(0.0, 60.0, 0.02)
    command = 5.0 * (1.0 - np.cos(0.3 * time))
    drawn = lfilter([0.05], [1.0, -0.95], command) / command.max()
    pressure = deepest * drawn if deepest < 0.0 else deepest * (1.0 - drawn)
    recording = Recording("log", time, command, 0.5 * abs(deepest) * drawn, pressure)
    log = Campaign("log", "finger", "wrist", "unknown", 0.02, (recording,), (recording,), "0" * 64)
    with pytest.raises(InputError, match=f"map {named} with scale = -1"):
        rising(log)
