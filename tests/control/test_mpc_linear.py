"""Behind the inverse the linear MPC plans as a linear system of python-control moves, and its commands take
the one page's wrist to the planned static angles."""

import control
import numpy as np
import pytest

from design.mpc import linear, observer
from design.mpc.prediction import coefficients
from design.mpc.problem import MPCProblem, Observer
from plants import Wrist
from plants.one_page import wrist as one_page


def test_free_and_forced_response_are_those_of_the_linear_system():
    wrist = Wrist.deviation()
    problem = MPCProblem(wrist, horizon=12)
    of = linear.planner(problem, coefficients(wrist))
    k, Tw = wrist.regulator.k_fast, wrist.Tw
    system = control.c2d(control.ss([[-k, 0], [1 / Tw, -1 / Tw]], [[k], [0]], np.eye(2), 0), problem.period)
    u, x0 = np.random.default_rng(2).normal(size=12) * 10.0, np.array([3.0, -2.0])
    time = np.arange(13) * problem.period
    states = control.forced_response(system, time, np.append(u, 0.0), x0).states[:, 1:]
    assert np.abs(of.free @ x0 + of.forced @ u - states[1]).max() < 1e-10
    assert np.abs(of.static_free @ x0 + of.static_forced @ u - states[0]).max() < 1e-10


def test_commands_take_the_wrist_to_static_angles_over_reversals():
    """From rest, through the dead zone, up, back along the transit to line 2, and up again."""
    wrist = Wrist.flexion()
    of = linear.planner(MPCProblem(wrist, rate=4.0), coefficients(wrist))
    asked = np.array([0.0, 0.3, 2.5, 5.0, 7.0, 6.6, 6.2, 6.5, 7.5, 9.0, 8.6, 8.4])
    start = observer.begin(0.0, 100.0, wrist)
    believed = start._replace(plant=start.plant._replace(pressure=115.0))
    commands = linear.follow(of, believed, 115.0 / 49.4, asked)
    assert commands.min() > 0.0
    assert commands.max() < 4.0
    page = one_page(wrist.values, held_to(wrist, 115.0) + spread(commands))
    reached = np.array(page)[-len(asked) * 20 - 1 :: 20, 1][1:]
    assert np.abs(reached - asked).max() < 1e-6


def spread(commands):
    return np.repeat(commands, 20).tolist()


def held_to(wrist, pressure):
    """Commands that bring the one page's wrist from rest to a pressure inside its dead zone, and there."""
    return [pressure / wrist.regulator.gain] * 40_000


def test_commands_are_clipped_to_range_and_rate():
    wrist = Wrist.flexion()
    of = linear.planner(MPCProblem(wrist, rate=0.5), coefficients(wrist))
    commands = linear.follow(of, observer.begin(0.0, 100.0, wrist), 2.0, np.full(10, 25.0))
    assert np.abs(np.diff(commands, prepend=2.0)).max() <= 0.5 + 1e-12
    assert commands.max() == pytest.approx(4.0)


@pytest.mark.parametrize("bandwidth", [5.0, 20.0, 30.0])
def test_the_observers_error_has_both_poles_where_they_were_asked_for(bandwidth):
    wrist = Wrist.flexion()
    problem = MPCProblem(wrist, observer=Observer(bandwidth=bandwidth))
    g, keep = observer.gains(problem), np.exp(-problem.period / wrist.Tw)
    A, C = np.array([[1.0, 0.0], [1.0 - keep, keep]]), np.array([[0.0, 1.0]])  # of (shift, angle)
    L = np.array([[g.shift], [g.angle]])
    poles = np.linalg.eigvals((np.eye(2) - L @ C) @ A)
    assert np.abs(poles - np.exp(-bandwidth * problem.period)).max() < 1e-6
