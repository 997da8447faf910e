"""The feedback of the real-time MPC is one QP about what was prepared, while the wrist is found near it."""

import numpy as np
import pytest

from design.controllers.controller import Measured
from design.mpc.formulations import real_time
from design.mpc.formulations.real_time import JUMP, real_time_mpc
from design.mpc.prediction import start_of
from design.mpc.problem import MPCProblem
from plants import Wrist
from plants.kernel import pytrees as tree

CONTROLLER = real_time_mpc(MPCProblem(Wrist.flexion(), horizon=5))
NEAR = {"pressure": 0.5, "memory.h": 0.1, "memory.virgin": 0.5, "angle": 0.1}
"""How far each part of the state may be from what was prepared for [kPa, deg]."""


@pytest.fixture
def under_way():
    """After some periods of a step, off the virgin curve, and what is believed there as it was prepared."""
    state = CONTROLLER.init(Measured(0.0, 0.0, 100.0))
    for k in range(12):
        state, _, _ = CONTROLLER.step(state, Measured(10.0, 0.5 * k, min(100.0 + 8.0 * k, 180.0)))
    return state, tree.like(state.believed.plant, state.prepared.start.tolist())


@pytest.fixture
def prepared(monkeypatch):
    """How often a plan is linearised, by where."""
    starts, plain = [], real_time.linearise

    def noted(*given):
        starts.append(given[4])
        return plain(*given)

    monkeypatch.setattr(real_time, "linearise", noted)
    return starts


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("name", NEAR)
def test_a_wrist_that_is_found_elsewhere_is_prepared_for_again(under_way, prepared, name, side):
    """A line of the loop may lie between; of a state that is as predicted nothing is done twice."""
    state, plant = under_way
    place = tree.names(plant).index(name)
    assert set(tree.names(plant)) == set(NEAR)
    for share, times in ((0.0, 0), (0.9, 0), (1.1, 1)):
        leaves = tree.leaves(plant)
        leaves[place] += side * share * NEAR[name]
        found = state.believed._replace(plant=tree.like(plant, leaves))
        prepared.clear()
        assert CONTROLLER.attempt(state, found, state.reference).found
        assert len(prepared) == times
        for start in prepared:
            np.testing.assert_array_equal(start, start_of(found))


def test_a_reference_that_jumps_has_the_plan_chosen_anew(under_way, prepared):
    state, plant = under_way
    found = state.believed._replace(plant=plant)
    for share, times in ((0.9, 0), (1.1, 1)):
        for side in (-1.0, 1.0):
            prepared.clear()
            assert CONTROLLER.attempt(state, found, state.reference + side * share * JUMP).found
            assert len(prepared) == times
