"""The MPC's problem: its cost written out, matrices that are the cost's derivatives, settings of the rig."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from design.mpc.problem import MPCProblem, MPCWeights, Observer, nominal, robust
from plants import Wrist
from plants.errors import InputError

WRIST = Wrist.flexion()
weights = st.builds(
    MPCWeights, st.floats(0.0, 5.0), st.floats(0.01, 5.0), st.floats(0.1, 20.0), st.floats(0.0, 20.0)
)
numbers = st.lists(st.floats(-20.0, 20.0), min_size=6, max_size=6)


@given(weights, numbers, numbers, st.floats(0.0, 4.0), st.floats(-20.0, 20.0))
def test_the_cost_is_the_sum_that_is_told(w, angles, commands, before, reference):
    problem = MPCProblem(WRIST, horizon=6, weights=w)
    total, last_angle, last = 0.0, None, before
    for k, (angle, command) in enumerate(zip(angles, commands, strict=True)):
        total += (w.terminal if k == 5 else w.angle) * (angle - reference) ** 2
        total += w.move * (command - last) ** 2
        total += 0.0 if last_angle is None else w.swing * (angle - last_angle) ** 2
        last_angle, last = angle, command
    assert problem.cost(angles, commands, before, reference) == pytest.approx(total, rel=1e-9, abs=1e-9)


@given(weights, numbers, numbers)
def test_the_hessians_are_those_of_the_cost(w, angles, commands):
    """The cost is quadratic, so that it is its parts: x'Qx of the errors, and of the moves from 0 V."""
    problem = MPCProblem(WRIST, horizon=6, weights=w)
    e, v = np.array(angles), np.array(commands)
    parts = e @ problem.angle_hessian @ e + v @ problem.move_hessian @ v
    assert problem.cost(e, v, 0.0, 0.0) == pytest.approx(parts, rel=1e-9, abs=1e-9)
    for matrix in (problem.angle_hessian, problem.move_hessian):
        np.testing.assert_array_equal(matrix, matrix.T)


@given(st.floats(0.0, 4.0), numbers)
def test_the_bounds_hold_commands_in_the_range_that_move_by_the_rate(before, commands):
    problem = MPCProblem(WRIST, horizon=6, low=0.5, high=3.5, rate=0.7)
    low, high = problem.bounds(before)
    v = np.array(commands)
    rows = np.concatenate([v, problem.differences @ v])
    inside = bool((rows >= low).all() and (rows <= high).all())
    moves = np.diff(v, prepend=before)
    told = bool((v >= 0.5).all() and (v <= 3.5).all() and (np.abs(moves) <= 0.7).all())
    assert inside == told


def test_commands_that_may_just_be_are_within_the_bounds():
    problem = MPCProblem(WRIST, horizon=4, low=0.5, high=3.5, rate=0.75)
    low, high = problem.bounds(2.0)
    for v in (np.array([2.75, 3.5, 3.5, 2.75]), np.array([1.25, 0.5, 1.25, 2.0])):
        rows = np.concatenate([v, problem.differences @ v])
        assert (rows >= low).all()
        assert (rows <= high).all()


def test_where_nothing_is_told_the_range_is_that_of_the_papers_rig():
    problem = MPCProblem(WRIST)
    assert (problem.low, problem.high, problem.substeps) == (0.0, 4.0, 20)
    assert problem.plausible.pressure.high == 400.0


@pytest.mark.parametrize("of", [nominal, robust])
@pytest.mark.parametrize(("range_", "dt", "period"), [((-5.0, 5.0), 0.005, 0.02), ((0.0, 10.0), 0.03, 0.03)])
def test_of_a_rig_they_have_its_range_and_sample_time(of, range_, dt, period):
    wrist = replace(WRIST, rig=replace(WRIST.rig, command_range=range_, sample_time=dt))
    problem = of(wrist)
    assert (problem.low, problem.high) == range_
    assert problem.rate == pytest.approx(0.5 * (range_[1] - range_[0]))
    assert problem.period == pytest.approx(period)
    assert problem.substeps == round(period / dt)
    assert of(wrist, horizon=7).horizon == 7


def test_the_robust_setting_moves_and_learns_more_slowly():
    fast, slow = nominal(WRIST), robust(WRIST)
    assert slow.weights.move >= 100.0 * fast.weights.move
    assert slow.weights.swing > 10.0 * fast.weights.swing
    assert slow.weights.angle == slow.weights.terminal == 1.0
    assert slow.observer.lack < fast.observer.lack
    assert slow.observer.bandwidth <= fast.observer.bandwidth
    assert (slow.period, slow.horizon, slow.rate) == (fast.period, fast.horizon, fast.rate)


@pytest.mark.parametrize("lack", [0.0, 1.0])
def test_settings_at_their_ends_are_taken(lack):
    assert Observer(1e-3, lack).lack == lack
    assert MPCProblem(WRIST, horizon=2, period=0.001).substeps == 1
    assert MPCProblem(WRIST, horizon=200).horizon == 200
    assert MPCWeights(angle=0.0, terminal=0.5, swing=0.0).angle == 0.0
    with pytest.raises(InputError):
        MPCProblem(WRIST, horizon=201)
    with pytest.raises(InputError):
        Observer(lack=-1e-9)
