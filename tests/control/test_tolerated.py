"""What a loop bears in simulation is what linear theory says where the loop is linear."""

import numpy as np
import pytest

from design.comparison.tolerated import DELAY_STEP, GAIN_STEP, settles, tolerated
from design.controllers.pi import PI
from design.open_loops import by_python_control
from plants import Wrist

LINEAR = Wrist.flexion().with_values(w1=1e-9, w2=1e-9, k_slow=9.0, k_fast=9.0)


@pytest.mark.parametrize("gains", [(6.0, 20.0), (10.0, 40.0)])
def test_the_delay_that_a_linear_loop_bears_is_python_controls_delay_margin_or_a_little_less(gains):
    margin = min(r["delay_margin_s"] for r in by_python_control(LINEAR, PI(*gains)))
    found = tolerated(LINEAR, PI(*gains), 10.0).delay_s
    assert 0.85 * margin <= found <= margin  # what rings for longer than the run counts as broken


def test_the_gain_that_a_linear_loop_bears_is_python_controls_gain_margin_or_a_little_less():
    slow = PI(0.0, 15.0)
    margin = min(r["gain_margin"] for r in by_python_control(LINEAR, slow))
    found = tolerated(LINEAR, slow, 10.0).gain
    assert 0.75 * margin <= found <= margin  # near the margin it rings for longer than the run
    strong = [LINEAR.with_values(gain=LINEAR.regulator.gain * found * x) for x in (1.0, GAIN_STEP)]
    assert [settles(w, slow, 10.0) for w in strong] == [True, False]


def test_a_loop_that_settles_with_nothing_more_bears_nothing():
    assert tolerated(LINEAR, PI(0.5, 150.0)).delay_s == 0.0
    assert np.isclose(DELAY_STEP, 0.005)
