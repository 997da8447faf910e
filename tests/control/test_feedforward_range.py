"""Where no range is told, a feedforward commands what the paper's regulator takes, all of it and no more; a
loop that this range does not cross has no inverse."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from design.controllers.controller import Measured
from design.controllers.feedforward import Feedforward, FeedforwardPI
from design.controllers.reference_model import no_inverse, reachable, within_reach
from plants import Wrist
from plants.errors import InputError

WRIST = Wrist.flexion()


@pytest.mark.parametrize("range_", [None, (0.5, 3.0)], ids=["default", "told"])
@pytest.mark.parametrize("kind", [Feedforward, partial(FeedforwardPI, Kp=50.0)], ids=["alone", "with a PI"])
def test_far_references_take_the_command_to_both_ends(kind, range_):
    low, high = range_ or (0.0, 4.0)
    controller = kind(WRIST, **({} if range_ is None else {"low": low, "high": high}))
    c, state = controller.sampled(), controller.holding(WRIST.rest().pressure)
    commands = []
    for k in range(1200):
        state, command = c.act(state, Measured(30.0 if k < 600 else -30.0, 0.0, 100.0))
        commands.append(float(command))
    assert (min(commands), max(commands)) == (low, high)
    assert np.abs(np.array(commands)[[599, 1199]] - [high, low]).max() < 1e-9


@pytest.mark.parametrize("share", [0.99, 1.01], ids=["narrower", "wider"])
def test_a_loop_wider_than_the_commands_move_the_joint_has_no_inverse(share):
    """The branches of a loop `w` wide meet no common angle once `a w` is what `a` makes of all pressures."""
    low, high = WRIST.reach
    width = 0.5 * share * (high - low) * float(WRIST.hysteresis.a1)
    plant = replace(WRIST, hysteresis=replace(WRIST.hysteresis, w1=width, w2=width))
    least, most = reachable(plant)
    if share < 1.0:
        assert least < most
        assert no_inverse(plant) is None
        assert within_reach(plant, 0.5 * (least + most)) == 0.5 * (least + most)
        return
    assert least > most
    assert "wider than what the commands move the joint" in no_inverse(plant)
    with pytest.raises(InputError, match="reference 5 deg: the loop is wider"):
        within_reach(plant, 5.0)
    with pytest.raises(InputError, match="no inverse of the loop: it is wider"):
        Feedforward.of(plant)


def test_a_regulator_that_is_slower_far_from_the_command_has_no_inverse():
    """As a fit may find it where both rates are nearly equal; refused in a line, as by the class itself."""
    plant = WRIST.with_values(k_fast=0.99 * WRIST.regulator.k_slow)
    with pytest.raises(
        InputError, match=r"no inverse of the regulator: k_slow 0\.55 is above k_fast 0\.5445"
    ):
        Feedforward.of(plant)
    with pytest.raises(ValueError, match="k_slow above k_fast"):
        Feedforward(plant)
