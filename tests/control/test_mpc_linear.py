"""Behind the inverse the linear MPC plans as a linear system of python-control moves, and its commands take
the one page's wrist to the planned static angles."""

import control
import numpy as np
import pytest
from scipy.optimize import minimize

from design.controllers.controller import Measured
from design.mpc import observer
from design.mpc.formulations import linear
from design.mpc.prediction import coefficients
from design.mpc.problem import MPCProblem, Observer
from plants import Wrist
from plants.dynamics import bend, step
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


@pytest.mark.parametrize("wrist", [Wrist.flexion(), Wrist.deviation()])
def test_by_default_the_shift_is_hardly_noisier_than_the_sensor_that_tells_it(wrist):
    """Standard deviations, by the Lyapunov equation of the observer's error with white noise of the angle."""
    problem = MPCProblem(wrist)
    g, keep = observer.gains(problem), np.exp(-problem.period / wrist.Tw)
    A, C = np.array([[1.0, 0.0], [1.0 - keep, keep]]), np.array([[0.0, 1.0]])
    L = np.array([[g.shift], [g.angle]])
    spread = np.sqrt(control.dlyap((np.eye(2) - L @ C) @ A, L @ L.T)[0, 0])
    assert 0.5 < spread < 1.5


@pytest.mark.parametrize(("rate", "periods"), [(0.05, 12), (0.1, 11), (0.2, 7)])
def test_from_period_to_period_the_plan_moves_by_the_rate_limit_while_it_is_far_away(rate, periods):
    """What is held of the plan is that of the period before, not a later one."""
    wrist = Wrist.flexion()
    controller, c = linear.linear_mpc(MPCProblem(wrist, rate=rate)), wrist.sampled()
    plant = wrist.rest("line1")
    state, first, commands = controller.init(Measured(0.0, 0.0, float(plant.pressure))), [], []
    for _ in range(periods):
        angle = float(plant.angle)
        state, command, _ = controller.step(state, Measured(12.0 - angle, angle, float(plant.pressure)))
        first.append(float(state.plan[1, 0]))
        commands.append(command)
        for _ in range(controller.problem.substeps):
            plant = step(plant, command, c)
    assert np.diff(first) == pytest.approx(np.full(periods - 1, controller.planner.rate), rel=1e-6)
    assert np.diff(commands).max() <= rate + 1e-12


@pytest.mark.parametrize("seed", range(3))
def test_the_observer_is_its_rule_in_plain_python(seed):
    """A period of the plant by its own law, bent to end at the measured pressure; then the corrections."""
    wrist, draw = Wrist.flexion(), np.random.default_rng(seed)
    problem = MPCProblem(wrist)
    g, flat, c = observer.gains(problem), coefficients(wrist), wrist.sampled()
    believed = observer.begin(2.0, 120.0, wrist)
    for _ in range(25):
        volts = float(draw.uniform(0.5, 3.5))
        lost = draw.random(2) < 0.2
        pressure = np.nan if lost[0] else float(believed.plant.pressure) + draw.normal(0.0, 8.0)
        angle = np.nan if lost[1] else float(believed.plant.angle) + draw.normal(0.0, 2.0)
        found = observer.update(believed, volts, Measured(0.0, angle, pressure), g, flat)
        pushed, path = volts + believed.lack / wrist.regulator.gain, [believed.plant.pressure]
        free = believed.plant
        for _ in range(problem.substeps):
            free = step(free, pushed, c)
            path.append(float(free.pressure))
        missed = 0.0 if lost[0] else pressure - path[-1]
        plant = believed.plant
        for i in range(1, problem.substeps + 1):
            plant = bend(plant, path[i] + missed * i / problem.substeps, (), c)
        assert found.plant.pressure == pytest.approx(float(plant.pressure), abs=1e-9)
        assert found.plant.memory.h == pytest.approx(float(plant.memory.h), abs=1e-9)
        off = 0.0 if lost[1] else angle - (float(plant.angle) + believed.shift)
        assert found.shift == pytest.approx(believed.shift + g.shift * off, abs=1e-9)
        assert found.plant.angle + found.shift == pytest.approx(
            float(plant.angle) + believed.shift + g.angle * off, abs=1e-9
        )
        error = wrist.regulator.gain * pushed - path[0]
        share = (path[-1] - path[0]) / error
        limited = np.clip(missed, -observer.MOST_MISSED, observer.MOST_MISSED)
        learnt = g.lack * limited * share / (share**2 + observer.LEAST_SHARE**2)
        assert found.lack == pytest.approx(believed.lack + learnt, abs=1e-9)
        believed = found


def test_at_rest_the_lack_is_learnt_with_the_share_of_a_slow_regulator():
    wrist = Wrist.flexion()
    problem = MPCProblem(wrist)
    g, believed = observer.gains(problem), observer.begin(0.0, 100.0, wrist)
    found = observer.update(
        believed, 100.0 / wrist.regulator.gain, Measured(0.0, 0.0, 100.1), g, coefficients(wrist)
    )
    share = 1.0 - np.exp(-wrist.regulator.k_slow * problem.period)
    assert found.lack == pytest.approx(g.lack * 0.1 * share / (share**2 + observer.LEAST_SHARE**2), rel=1e-6)


def test_on_a_line_the_plan_is_the_best_of_the_problem_in_volts():
    """Lines of one slope and no bound met: the QP finds the minimum of the cost in commands."""
    wrist = Wrist.flexion().with_values(a1=0.2, a2=0.2)
    problem = MPCProblem(wrist, horizon=8, rate=50.0, low=-100.0, high=100.0)
    of, p, gain = linear.planner(problem, coefficients(wrist)), wrist.hysteresis, wrist.regulator.gain
    k, rest = wrist.regulator.k_fast, wrist.rest("line1")
    before, reference = float(rest.pressure / gain), float(rest.angle) + 3.0
    believed = observer.begin(0.0, 100.0, wrist)._replace(plant=rest)
    _, found = linear.plan(of, believed, before, reference, np.zeros(16, dtype=np.int32))
    poles = [[-k, 0], [1 / wrist.Tw, -1 / wrist.Tw]]
    system = control.c2d(control.ss(poles, [[k], [0]], [[0, 1]], 0), problem.period)
    line = lambda v: p.a1 * (gain * v - p.rest_pressure) - p.w1  # noqa: E731

    def cost(commands):
        inputs, time = np.append(line(commands), 0.0), np.arange(9) * problem.period
        angles = control.forced_response(system, time, inputs, [rest.memory.h, rest.angle]).outputs[1:]
        return problem.cost(angles, commands, before, reference)

    least = minimize(cost, np.full(8, before), method="BFGS", options={"gtol": 1e-6})
    np.testing.assert_allclose(found.x, line(least.x), atol=1e-4)
    assert of.rate == pytest.approx(line(before + problem.rate) - line(before))
