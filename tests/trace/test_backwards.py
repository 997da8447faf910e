"""No effect is named with which the loop turns back."""

from dataclasses import replace

import numpy as np
import pytest

from plants.effects import Creep, MaxwellSlip, OneMorePlay, Polynomial, SeveralPlays
from plants.equilibrium import at_pressure
from plants.measured.campaigns.playback import Playback
from plants.measured.campaigns.recording import Recording
from plants.measured.fitting.stage import Stage
from plants.measured.trace.ranking.backwards import makes_no_loop, turns_back, with_a_loop
from plants.measured.trace.stages.model import Model
from plants.parameters.files import built_in
from plants.wrist import Wrist

DECLARED = built_in("flexion")
TIME = 0.01 * np.arange(3000)
COMMAND = 2.0 + 1.0 * np.sin(0.8 * TIME)


def model(effect):
    recording = Recording("run", TIME, COMMAND, angle=np.zeros(TIME.size))
    stage = Stage("whole", "angle_deg", 0.05, (Playback(recording, 0.001),), ("a1",), DECLARED.rig)
    return Model(stage, DECLARED, {**DECLARED.values, **effect.values}, (type(effect),))


@pytest.mark.parametrize(
    ("effect", "back"),
    [
        (OneMorePlay(0.1, 20.0), False), (OneMorePlay(-0.05, 20.0), False), (OneMorePlay(-0.1, 20.0), True),
        (SeveralPlays(-0.1, 0.1, 0.1, 20.0), True), (SeveralPlays(0.1, -0.1, -0.05, 20.0), False),
        (Creep(0.1, 2.0), False), (Polynomial(0.0, -0.3), False), (Polynomial(-0.45, -0.33), False),
    ],
)  # fmt: skip
def test_it_turns_back_where_plays_take_more_than_the_flattest_branch_gives(effect, back):
    assert turns_back(model(effect)) is back


@pytest.mark.parametrize("weight", [-0.05, -0.1])
def test_a_simulated_reversal_says_the_same(weight):
    # Down the descending branch and up again: once the gap of 4 kPa is closed, the play beside goes along.
    wrist = Wrist.of(DECLARED) + OneMorePlay(weight, 2.0)
    start = at_pressure(wrist, "line2", 90.0)
    angles = []
    for up in (89.5, 91.5):
        held = np.concatenate([np.full(20_000, 85.0), np.full(20_000, up)]) / wrist.regulator.gain
        angles.append(wrist.simulate(held, start).angle[-1])
    assert bool(angles[1] < angles[0]) is turns_back(model(OneMorePlay(weight, 2.0)))


def test_lines_that_cross_where_friction_takes_the_whole_width_are_no_loop():
    """As a file with them is refused."""
    friction = MaxwellSlip(1.0, 4.0)
    found = model(friction)
    assert not makes_no_loop(found)
    crossed = replace(found, values={**found.values, "w1": -0.3, "w2": 0.1, "a1": 0.33, "a2": 0.36})
    assert makes_no_loop(crossed)
    low, high = (crossed.values["gain"] * v for v in DECLARED.rig.command_range)
    assert crossed.wrist.hysteresis.problem(low, high) is not None
    mended = with_a_loop(crossed)
    assert mended.effects == ("stick-slip",)
    assert mended.wrist.hysteresis.problem(low, high) is None
    assert with_a_loop(found) is found
