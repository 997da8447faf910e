"""What is tuned beside two gains: a weight and a filter, or a feedforward around the same loop."""

import numpy as np
import pytest

from design.controllers.feedforward import FeedforwardPI
from design.controllers.pi import PI
from design.controllers.pi_two_dof import TwoDofPI
from design.robustness.checks import check
from design.robustness.tuning.robust_tuning import tune_robustly
from design.synthesis.structure import TWO_DOF_PI, forward_pi, with_gains
from plants.effects.wrist.creep import Creep
from plants.wrist import Wrist
from tests.robustness.test_robust_tuning import COARSE, plain, small

WRIST = Wrist.flexion()


def test_gains_by_name_make_the_controller_that_they_are_of():
    plain = with_gains(WRIST, {"Kp": 2.0, "Ki": 5.0, "b": 1.0, "Tf": 0.0})
    assert plain == PI.of(WRIST, 2.0, 5.0)
    weighted = with_gains(WRIST, {"Kp": 2.0, "Ki": 5.0, "b": 0.7, "Tf": 0.0})
    assert weighted == TwoDofPI.of(WRIST, 2.0, 5.0, 0.7)
    forward = with_gains(WRIST, {"Kp": 2.0, "Ki": 5.0, "speed": 4.0, "dead_time": 0.025})
    assert forward == FeedforwardPI.of(WRIST, Kp=2.0, Ki=5.0, speed=4.0, dead_time=0.025)


def test_the_model_of_a_feedforward_is_the_wrist_without_effects():
    made = with_gains(WRIST + Creep(0.1, 4.0), {"Kp": 2.0, "Ki": 5.0, "speed": 4.0, "dead_time": 0.0})
    assert made.model.effects == ()
    assert made.settings["Tw"] == WRIST.Tw


@pytest.mark.suite
def test_a_feedforward_around_the_same_loop_costs_less_and_holds_what_the_loop_holds():
    two = tune_robustly(small(), COARSE, 0, structure=TWO_DOF_PI, base=plain().final)
    found = tune_robustly(small(), COARSE, 0, structure=forward_pi(0.025), base=two.final)
    assert found.holds
    assert (found.final.Kp, found.final.Ki) == (two.final.Kp, two.final.Ki)
    assert float(found.final.at.cost[0]) < 0.9 * float(two.final.at.cost[0])
    for n in ("Ms", "Mt", "delay_margin_s"):  # it stands outside the loop
        np.testing.assert_allclose(found.final.at.values[n], two.final.at.values[n], rtol=1e-9)
    again = check(small(), found.final.controller, 500, 91)
    assert again.broken == 0
