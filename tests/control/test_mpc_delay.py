"""An MPC whose model has a dead time: what it plans from, and what that is worth behind one."""

from dataclasses import replace

import numpy as np
import pytest

from design.mpc import loop
from design.mpc.formulations.linear import linear_mpc
from design.mpc.formulations.real_time import real_time_mpc
from design.mpc.margins_at_rest import margins_at_rest
from design.mpc.problem import nominal, robust
from plants import InputError, Wrist
from plants.effects.regulator.dead_time import DeadTime
from plants.simulation.sensor import Measured

WRIST = Wrist.flexion()


@pytest.mark.parametrize("make", [linear_mpc, real_time_mpc])
def test_behind_the_dead_time_of_its_model_it_moves_as_it_does_without_any_later_by_that(make):
    """A model that is right knows where its commands lead: the run is that without a dead time, shifted."""
    bare = loop.run(WRIST, make(nominal(WRIST)), 15.0, duration=1.0, record=True).trajectory
    known = make(nominal(WRIST, delay=2))
    late = loop.run(WRIST + DeadTime(0.04), known, 15.0, duration=1.04, record=True).trajectory
    assert np.abs(late.angle[:40]).max() < 1e-9
    # The observer is not told of the pressure until a command acts; what is left of that is small.
    assert np.abs(late.angle[40:1000] - bare.angle[:960]).max() < 0.02


def test_commands_under_way_are_those_given_before_the_oldest_first():
    mpc = real_time_mpc(nominal(WRIST, delay=3))
    state = mpc.init(Measured(0.0, 0.0, 100.0))
    given = [state.command] * 3
    for k in range(6):
        state, command, _ = mpc.step(state, Measured(15.0 - k, float(k), 100.0 + k))
        given.append(command)
        assert state.under_way == tuple(given[-4:-1])


@pytest.mark.slow
def test_a_known_dead_time_leaves_more_margin():
    asked = robust(WRIST)
    without, known = (
        margins_at_rest(real_time_mpc(replace(asked, delay=d)), [WRIST], (0.05,)) for d in (0, 2)
    )
    assert known.Ms < 0.75 * without.Ms
    assert known.delay_margin_s > 2.0 * without.delay_margin_s


@pytest.mark.parametrize("delay", [-1, 1.5, True])
def test_a_delay_is_a_whole_number_of_periods(delay):
    with pytest.raises(InputError, match="MPC delay"):
        nominal(WRIST, delay=delay)
