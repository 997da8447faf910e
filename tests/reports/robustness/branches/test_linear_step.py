"""The step of the linear loop from its frequency response is that of python-control."""

import control
import numpy as np
import pytest

from design.controllers.pi import PI
from design.controllers.pi_two_dof import TwoDofPI
from design.open_loops import loop_tf, open_loops
from plants import Wrist
from reports.robustness.branches.figures import frequencies
from reports.robustness.branches.linear_step import branch_step

WRIST, GAINS = Wrist.flexion(), PI(2.0, 6.0)
TIME = np.arange(0.02, 3.0, 0.02)


@pytest.mark.parametrize("place", range(6))
def test_a_step_is_that_of_python_control(place):
    loop = open_loops(WRIST, GAINS)[place]
    closed = control.feedback(loop_tf(WRIST, GAINS, loop.branch, loop.rate), 1)
    known = control.step_response(closed, np.arange(0.0, 3.001, 1e-3))
    found = branch_step(loop, GAINS, frequencies(WRIST), TIME)
    np.testing.assert_allclose(found, np.interp(TIME, *known), atol=2e-3)


def test_a_weight_of_the_reference_softens_the_step_and_changes_not_where_it_ends():
    """y of a weight b is b times the step of the gains plus (1 - b) times that of the integral part alone."""
    late = np.array([0.05, 60.0])
    weighted = TwoDofPI(GAINS.Kp, GAINS.Ki, b=0.5)
    loop, same = open_loops(WRIST, weighted)[4], open_loops(WRIST, GAINS)[4]
    omega = np.geomspace(1e-3, 2000.0, 6000)
    half, whole = branch_step(loop, weighted, omega, late), branch_step(same, GAINS, omega, late)
    none = branch_step(same, TwoDofPI(GAINS.Kp, GAINS.Ki, b=0.0), omega, late)
    np.testing.assert_allclose(half, 0.5 * (whole + none), atol=1e-9)
    assert half[0] < 0.8 * whole[0]
    assert half[1] == pytest.approx(1.0, abs=2e-3)
