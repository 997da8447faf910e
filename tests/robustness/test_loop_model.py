"""The loop in three states is the loop: the simulator's, plant on one page and python-control's poles."""

from dataclasses import replace

import control
import numpy as np
import pytest

from design.controllers.pi import PI
from design.open_loops import loop_tf
from design.robustness.loop_model import LoopModel
from plants import Wrist
from plants.actuator.regulator import Regulator
from plants.effects import Creep, DeadTime
from plants.one_page import wrist as one_page
from plants.wrist import SAMPLE_TIME

GAINS = [(1.2, 2.2), (3.13, 10.4), (9.0, 40.0)]


@pytest.mark.parametrize(("Kp", "Ki"), GAINS)
@pytest.mark.parametrize("axis", ["flexion", "deviation"])
def test_poles_of_the_sampled_loop_are_those_of_python_control(axis, Kp, Ki):
    wrist, pi = getattr(Wrist, axis)(), PI(Kp, Ki)
    model = LoopModel.of(wrist, pi)
    for branch, slope in model.slopes.items():
        for rate, k in (("slow", model.k_slow), ("fast", model.k_fast)):
            ours = np.sort_complex(np.linalg.eigvals(model.sampled_matrix(slope, k)))
            theirs = np.sort_complex(control.feedback(loop_tf(wrist, pi, branch, rate), 1).poles())
            assert ours == pytest.approx(theirs, abs=1e-7)


@pytest.mark.parametrize(("Kp", "Ki"), GAINS)
def test_the_continuous_loop_is_stable_where_routh_says_so(Kp, Ki):
    model = LoopModel.of(Wrist.flexion(), PI(Kp, Ki))
    for slope in model.slopes.values():
        for k in np.geomspace(0.02, 20.0, 15):
            # s^3 + (k + 1/T) s^2 + (k/T)(1 + slope Kp) s + slope k Ki / T
            routh = (k + 1.0 / model.Tw) * (1.0 + slope * Kp) > slope * Ki
            assert (np.linalg.eigvals(model.matrix(slope, k)).real.max() < 0.0) == routh


def test_one_step_of_it_is_a_step_of_the_plant_on_one_page():
    # The PI written out here; on line 1 all the while, so that the slope is a1, at one regulator rate.
    wrist = replace(Wrist.flexion(), regulator=Regulator(49.4, 4.0, 4.0, 9.0))
    Kp, Ki, r, dt = 2.0, 5.0, 15.0, SAMPLE_TIME
    values = {k: float(v) for k, v in wrist.values.items()}
    commands, integral = [], 0.0
    rows = []
    for _ in range(400):
        P, h, y = one_page(values, commands)[-1]
        v = (100.0 + Kp * (r - y) + integral) / 49.4
        integral += Ki * (r - y) * dt
        rows.append((r - y, h - y, 49.4 * v - P))
        commands.append(v)
    x = np.array(rows)
    on_line = slice(250, 399)  # the virgin curve is left by then, and the wrist still goes up
    M = LoopModel.of(wrist, PI(Kp, Ki)).sampled_matrix(float(wrist.hysteresis.a1), 4.0)
    assert x[1:][on_line] == pytest.approx(x[:-1][on_line] @ M.T, abs=1e-9)


def test_shares_lie_between_those_of_the_two_rates():
    model = LoopModel.of(Wrist.flexion(), PI(1.0, 1.0))
    low, high = model.sampled_shares()
    assert low == pytest.approx(-np.expm1(-0.55e-3), rel=1e-9)
    assert high == pytest.approx(-np.expm1(-9e-3), rel=1e-6)


def test_what_the_model_leaves_out_is_named():
    wrist = Wrist.flexion() + DeadTime(0.03) + Creep(0.1, 4.0)
    model = LoopModel.of(wrist, PI(1.0, 1.0))
    assert model.dead_time == 0.03
    assert model.left_out == ("creep",)
