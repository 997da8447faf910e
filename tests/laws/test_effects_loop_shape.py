"""Plays beside the loop are a Prandtl-Ishlinskii sum, and a wrist with them rests where it says."""

import numpy as np
import pytest

from plants.effects import Creep, OneMorePlay, SeveralPlays
from plants.equilibrium import at_pressure
from plants.measured.problem import Begin
from plants.measured.trace.stages.stage import begun
from tests.laws.effect_steps import WRIST, moved, ramp

PATH = ramp(100.0, 160.0, 120.0, 140.0, 60.0, 110.0, rate=200.0)


def played(thresholds, weights):
    """The sum of plays [deg] along the path, each play by its definition."""
    found = []
    plays = [0.0] * len(thresholds)
    for x in PATH - 100.0:
        plays = [max(min(p, x + r), x - r) for p, r in zip(plays, thresholds, strict=True)]
        found.append(sum(w * p for w, p in zip(weights, plays, strict=True)))
    return np.array(found)


@pytest.mark.parametrize(
    ("effect", "thresholds", "weights"),
    [
        (OneMorePlay(0.1, 12.0), (12.0,), (0.1,)),
        (SeveralPlays(0.05, -0.02, 0.08, 30.0), (10.0, 20.0, 30.0), (0.05, -0.02, 0.08)),
    ],
)
def test_plays_are_added_to_what_the_loop_gives(effect, thresholds, weights):
    instant = WRIST.with_values(Tw=1e-9)
    _, plain = moved(instant, PATH)
    _, ours = moved(instant + effect, PATH)
    np.testing.assert_allclose(ours[1:] - plain[1:], played(thresholds, weights)[1:], atol=1e-7)


@pytest.mark.parametrize("start", ["line1", "line2", "inside"])
def test_a_wrist_with_plays_and_creep_stays_at_rest(start):
    wrist = WRIST + SeveralPlays(0.05, 0.02, 0.08, 30.0) + Creep(0.1, 0.5)
    state = wrist.rest(start, 9.0)
    _, angle = moved(wrist, np.full(3000, float(state.pressure)), state=state)
    np.testing.assert_allclose(angle, 9.0, atol=1e-9)


def test_the_rest_at_a_pressure_is_the_rest_at_its_angle():
    wrist = WRIST + SeveralPlays(0.05, 0.02, 0.08, 30.0)
    state = at_pressure(wrist, "line1", 130.0)
    assert float(wrist.rest("line1", state.angle).pressure) == pytest.approx(130.0, abs=1e-6)


def test_a_recording_that_begins_elsewhere_begins_at_the_angle_that_was_seen():
    wrist = WRIST + SeveralPlays(0.05, 0.02, 0.08, 30.0)
    _, angle = moved(wrist, np.full(500, 140.0), state=begun(wrist, Begin(140.0, 16.0, False)))
    np.testing.assert_allclose(angle, 16.0, atol=1e-9)
