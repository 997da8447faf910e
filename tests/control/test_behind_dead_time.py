"""Overshoot behind a dead time is what linear theory says where the loop is linear, and what single runs
show where it is not."""

import control
import numpy as np
import pytest

from design.comparison.behind_dead_time import behind_dead_time
from design.comparison.tolerated import DURATION
from design.controllers.pi import PI
from design.evaluation.runner import play, step_from
from design.evaluation.steps import run
from design.mpc.formulations.linear import linear_mpc
from design.mpc.problem import MPCProblem
from design.open_loops import loop_tf
from plants import Wrist
from plants.simulation.disturbance import burdened
from plants.wrist import STARTS

LATE = np.array([0.0, 0.03, 0.06])
LINEAR = Wrist.flexion().with_values(w1=1e-9, w2=1e-9, k_slow=9.0, k_fast=9.0)


def test_it_is_python_controls_where_the_loop_is_linear():
    pi, dt = PI(2.0, 16.0), LINEAR.rig.sample_time
    found = behind_dead_time(LINEAR, {"PI": pi}, LATE)
    loop = loop_tf(LINEAR, pi, "line1", "fast")
    expected = []
    for late in LATE:
        delay = control.tf([1.0], [1.0, *[0.0] * round(late / dt)], dt)
        closed = control.feedback(control.ss(delay) * loop, 1)
        _, y = control.step_response(closed, np.arange(3000) * dt)
        expected.append(100.0 * (float(np.max(y)) - 1.0))
    assert expected[2] > expected[0] + 5.0
    assert found.overshoot["PI"] == pytest.approx(expected, abs=0.2)
    assert found.settles["PI"].all()


def test_it_is_the_worst_of_every_sign_and_initial_state():
    wrist, pi, late = Wrist.flexion(), PI(4.8, 20.0), 0.06
    plant = burdened(wrist, late, None)
    each = [
        float(run(plant, pi, sign * 15.0, plant.rest(start))[0].overshoot_percent[0])
        for start in STARTS
        for sign in (1.0, -1.0)
    ]
    found = behind_dead_time(wrist, {"PI": pi}, np.array([late])).overshoot["PI"]
    assert max(each) > min(each) + 1.0
    assert found == pytest.approx([max(each)], rel=1e-9)


def test_a_loop_that_goes_unstable_does_not_settle():
    found = behind_dead_time(LINEAR, {"PI": PI(10.0, 40.0)}, np.array([0.0, 0.1]))
    assert found.settles["PI"].tolist() == [True, False]
    assert [(r["dead_time_s"], r["settles"]) for r in found.rows()] == [(0.0, True), (0.1, False)]


def test_an_mpc_is_played_from_rest():
    wrist, late = Wrist.flexion(), 0.05
    mpc = linear_mpc(MPCProblem(wrist))
    plant = burdened(wrist, late, None)
    found = behind_dead_time(wrist, {"MPC": mpc}, np.array([late])).overshoot["MPC"]
    each = [play(step_from(plant, plant.rest(), s, DURATION), mpc).metrics for s in (15.0, -15.0)]
    assert found == pytest.approx([max(float(m.overshoot_percent[0]) for m in each)], rel=1e-9)
