"""A parameter of an effect that the recordings say nothing about is where the effect would vanish."""

import numpy as np
import pytest

from plants.effects.regulator.fill_exhaust import TwoRates
from plants.measured.playback import Playback
from plants.measured.recording import Recording
from plants.measured.stage import Stage
from plants.measured.trace.search.choose import Candidate
from plants.measured.trace.search.undetermined import at_neutral
from plants.measured.trace.stages.model import Model
from plants.parameters.files import built_in
from plants.simulation.open_loop import open_loop
from plants.wrist import Wrist

RISES = np.repeat([1.0, 2.0, 3.0, 4.0], 2000)
FALLS = np.repeat([4.0, 3.0, 2.0, 1.0], 2000)


def traced(command, tried: float) -> Candidate:
    """The model of a recording of a regulator that exhausts at 0.7 of the rate, where a trial has left it."""
    declared = built_in("flexion")
    rig = Wrist.from_values(
        {**declared.values, "fill-exhaust-asymmetry.ratio": 0.7}, (TwoRates,), declared.rig
    )
    pressure = open_loop(rig, command).pressure[::10]
    noisy = pressure + np.random.default_rng(0).normal(0.0, 0.1, pressure.size)
    t = 0.01 * np.arange(pressure.size)
    playback = Playback(Recording("run", t, command[::10], pressure=noisy), declared.rig.sample_time)
    stage = Stage("regulator", "pressure_kPa", 0.1, (playback,), ("k_fast",), declared.rig)
    values = {**declared.values, "fill-exhaust-asymmetry.ratio": tried}
    return Candidate(Model(stage, declared, values, (TwoRates,)))


def test_a_speed_of_exhausting_that_never_shows_is_that_of_filling():
    found = at_neutral(traced(RISES, 4.1))
    assert found.model.values["fill-exhaust-asymmetry.ratio"] == 1.0


def test_one_that_shows_is_kept():
    now = traced(FALLS, 0.7)
    assert now.model.chi2 == pytest.approx(1.0, abs=0.15)
    assert at_neutral(now) is now
