"""The samples of a check begin where the log begins: also of a joint that rests at an end of its range, while
its design counts the angle from the middle."""

import numpy as np
import pytest

from design.controllers.pi import PI
from design.robustness.requirement import requirement
from design.studies.check.envelope import _played
from plants.measured.campaigns.begin import first_begin
from plants.measured.campaigns.campaign import load_campaign
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.trace.start import starting
from tests.rig.soft.named import CAMPAIGNS


@pytest.fixture(scope="module")
def plant(tmp_path_factory):
    """A bending actuator, guessed from its log: at rest 26 deg below the middle of its range."""
    make, fit, validate = CAMPAIGNS["bender"]
    folder = tmp_path_factory.mktemp("bender")
    make().write(folder, fit, validate)
    return starting(load_campaign(folder), either_way=True).parameters


def log_of(plant, first, pressure, seconds=4.0):
    """A log that begins at an angle and a pressure, with a step at once."""
    time = np.arange(0.0, seconds, plant.rig.log_time)
    same = np.ones(time.size)
    return Recording(
        "first", time, 0.0 * time, angle=first * same, pressure=pressure * same, reference=0.5 * first * same
    )


@pytest.mark.parametrize("share", [1.0, 0.4])
def test_samples_begin_at_the_first_rows(plant, share):
    """Of a rig at rest, and of one that was held somewhere when the log began."""
    asked, rest = requirement(plant), plant.rig.zero.rest
    assert rest < -20.0
    law = asked.wrist.hysteresis
    pressure = float(law.rest_between(share * rest)["inside"])
    low = plant.rig.pressure_range[0] if share == 1.0 else pressure
    log = log_of(plant, share * rest, low)
    begin = first_begin(log, float(law.rest_pressure), plant.rig)
    assert begin.virgin is (share == 1.0)
    assert not begin.at_zero
    playback = Playback(log, plant.rig.sample_time)
    gains = PI.of(asked.wrist, 0.2, 0.2)
    angle, command = _played(playback, asked, gains, 24, 0, 0.0, 1)
    assert np.all(np.isfinite(command))
    off = np.abs(angle[0] - share * rest)
    assert off.max() < 0.1 * abs(rest)  # a load shifts it, no more
