"""The loop around a dead time is the one of a plain page with a queue of commands."""

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.steps import run
from plants import Wrist
from plants.effects import DeadTime
from plants.kernel import pytrees as tree
from tests.oracles.plain_loop import Plant, closed_loop


@pytest.mark.parametrize("axis", ["flexion", "deviation"])
@pytest.mark.parametrize("reference", [15.0, -15.0])
@pytest.mark.parametrize("delay", [0.0, 0.001, 0.1, 0.35])
def test_the_loop_is_the_one_with_a_queue(axis, reference, delay):
    w = getattr(Wrist, axis)()
    _, _, t = run(w + DeadTime(delay), PI(3.13, 10.4), reference, duration=3.0, record=True)
    angles, commands = closed_loop(Plant(w.values), 3.13, 10.4, reference, 3.0, delay)
    np.testing.assert_allclose(t.angle[:-1, 0], angles, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(t.command[:-1, 0], commands, rtol=0.0, atol=1e-8)


def test_lanes_have_delays_of_their_own_and_start_from_angles_of_their_own():
    w, delays = Wrist.flexion(), np.array([0.0, 0.05, 0.1, 0.2])
    gains = PI(np.array([1.0, 2.0, 3.13, 2.0]), 6.0)
    state = [(w + DeadTime(d)).rest("line1", a) for d, a in zip(delays, (0.0, 3.0, 6.0, 9.0), strict=True)]
    lanes = tree.like(state[0], list(np.array([tree.leaves(s) for s in state], float).T))
    _, _, t = run(w + DeadTime(delays), gains, 12.0, lanes, duration=2.0, record=True)
    for i, (d, angle) in enumerate(zip(delays, (0.0, 3.0, 6.0, 9.0), strict=True)):
        plant = Plant(w.values, float(state[i].pressure), angle, virgin=False)
        angles, _ = closed_loop(plant, float(gains.Kp[i]), 6.0, 12.0, 2.0, d)
        np.testing.assert_allclose(t.angle[:-1, i], angles, rtol=0.0, atol=1e-8)
