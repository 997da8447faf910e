"""Trajectories by optimal control come within 5 % of the bound, as the simulator, not the optimiser, says."""

import casadi
import numpy as np
import pytest
from scipy.optimize import fsolve

from design.controllers.pi import PI
from design.evaluation.cases import Case
from design.evaluation.steps import run
from design.evaluation.tasks import Task
from design.limit import bound, limit, limits_of, optimal, ratios, replay
from design.limit.optimal import CORNER, HOLD, WEIGHT, TimeOptimalProblem, _guess, _solve
from plants import Wrist
from plants.effects.regulator.dead_time import DeadTime
from tests.control.limit_plant import iae, lanes, of_state, settled_at


@pytest.mark.slow
@pytest.mark.parametrize(
    ("motion", "start", "angle", "reference"),
    [("flexion", "virgin", 0.0, 15.0), ("deviation", "line1", 15.0, 0.0)],
)
def test_within_five_percent_and_replayed_by_another_simulator(motion, start, angle, reference):
    wrist = getattr(Wrist, motion)()
    found = limit(Case(Task(start, angle, (reference,)), wrist), trajectory=True)
    assert 0.0 <= found.gap <= 0.05
    assert 1.0 <= found.iae_achieved / found.iae_bound <= 1.05
    assert found.commands is found.fastest.commands
    for of, settles in ((found.fastest, found.achieved_s), (found.least, None)):
        assert of.commands.min() >= 0.0
        assert of.commands.max() <= 4.0
        angles, _ = lanes(wrist.values, of_state(wrist.rest(start, angle)), of.commands[:-1, None])
        assert np.abs(angles[:, 0] - of.angle).max() < 1e-9
        assert settles is None or settled_at(angles, reference, angle)[0] == pytest.approx(settles)
    assert iae(angles, reference)[0] == pytest.approx(found.iae_achieved)


def test_behind_a_dead_time():
    wrist = Wrist.deviation() + DeadTime(0.05)
    found = bound(wrist, 15.0)
    least = optimal(wrist, 15.0, wrist.rest(), found, "iae", 0.0)
    assert 1.0 <= least.metrics.settling_time_s / found.settling_s <= 1.05
    assert 1.0 <= least.metrics.iae_deg_s / found.iae <= 1.05


def test_the_linear_cascade_is_not_slower_than_its_time_optimal_transfer():
    """One rate, no loop: to come to rest at the reference takes one switch, whose time and end solve two
    equations in exponentials; to stay in the band for good can only be quicker."""
    wrist = Wrist.flexion().with_values(k_slow=9.0, s=0.36, w1=0.0, w2=0.0)
    k, T, up, down = 9.0, wrist.Tw, 0.36 * 97.6, -0.36 * 100.0

    def after(h, y, target, t):
        """Both lags, exactly: h tends to the target, y follows h."""
        e, f = np.exp(-k * t), np.exp(-t / T)
        d = h - target
        return target + d * e, target + (y - target) * f + d * (e - f) / (1.0 - k * T)

    def missed(times):
        return np.subtract(after(*after(0.0, 0.0, up, times[0]), down, times[1]), 15.0)

    transfer = fsolve(missed, [0.2, 0.05])
    assert np.abs(missed(transfer)).max() < 1e-9
    state = wrist.rest("line1")
    found = bound(wrist, 15.0, state)
    achieved = float(optimal(wrist, 15.0, state, found, "settling", 0.0).metrics.settling_time_s)
    assert found.settling_s <= achieved <= transfer.sum() + 0.001


@pytest.mark.parametrize(("angle", "way"), [(0.0, 15.0), (5.0, 10.0), (-5.0, 20.0)])
def test_the_band_is_a_share_of_the_way_from_where_the_step_begins(angle, way):
    wrist = Wrist.flexion()
    problem = TimeOptimalProblem(wrist, wrist.rest("line1", angle), 15.0, 1.0, 100)
    assert problem.band == pytest.approx(wrist.rig.task.band * way)


def test_replays_are_judged_as_by_a_plain_loop():
    wrist = Wrist.flexion()
    v = 2.0 + 0.4 * np.sin(np.arange(3000) / 100.0)
    v = np.append(v, 3.2)
    told = replay(wrist, v, 15.0, wrist.rest())
    held = np.concatenate([v, np.full(10_000 - len(v), 3.2)])[:, None]
    angles, _ = lanes(wrist.values, of_state(wrist.rest()), held[:-1])
    assert float(told.metrics.settling_time_s) == pytest.approx(settled_at(angles, 15.0, 0.0)[0])
    assert float(told.metrics.iae_deg_s) == pytest.approx(iae(angles, 15.0)[0])
    assert float(told.metrics.overshoot_percent) == pytest.approx(max(angles.max() / 15.0 - 1.0, 0.0) * 100.0)


def test_controllers_lie_above_the_limit():
    wrist = Wrist.flexion()
    of = limits_of(wrist)
    assert len(of) == 10
    judged, _, _ = run(wrist, PI(np.array([1.2, 6.0]), np.array([2.2, 8.0])), np.full(2, 15.0), wrist.rest())
    found = ratios(judged, of["step+virgin"])
    assert (found.settling > 1.0).all()
    assert (found.iae > 1.0).all()
    assert found.iae[0] == pytest.approx(judged.iae_deg_s[0] / of["step+virgin"].iae_bound)


@pytest.mark.parametrize("angle", [2.0, 11.0])
@pytest.mark.parametrize("turn", [2, 5])
def test_the_search_begins_with_throttle_that_is_turned_and_then_holds(angle, turn):
    """Towards the reference, back to it, and there: mirrored where the step is."""
    loop = Wrist.flexion().hysteresis
    wrist = Wrist.flexion().with_values(
        rest_pressure=98.8, a2=float(loop.a1), w2=float(loop.w1)
    )  # half of 4 V
    found = {}
    for sign in (1.0, -1.0):
        state = wrist.rest("line1" if sign > 0 else "line2", sign * angle)
        problem = TimeOptimalProblem(wrist, state, sign * (angle + 8.0), sign, 120)
        n = problem.nodes
        guess = _guess(problem, turn)
        volts, nodes = guess[:n], guess[n:].reshape(n, 2)
        first, second = (4.0, 0.0) if sign > 0 else (0.0, 4.0)
        assert volts[:turn].tolist() == [first] * turn
        assert volts[turn] == second
        backs = int(np.argmax(volts[turn:] != second))
        held = volts[turn + backs :]
        assert np.ptp(held[1:]) < 0.15  # the regulator stands nearly still there
        assert (np.diff(sign * nodes[:turn, 0]) > 0.0).all()
        found[sign] = sign * (volts - 2.0), sign * (nodes - [98.8, 0.0])
    np.testing.assert_allclose(found[1.0][0], found[-1.0][0], atol=1e-9)
    np.testing.assert_allclose(found[1.0][1], found[-1.0][1], atol=1e-9)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("start", ["virgin", "line1", "line2", "inside"])
def test_static_angles_before_and_after_the_turn_are_those_of_the_loop(start, sign):
    """One monotone move from the start, and one back: `FourSegment.step`, with its corners rounded."""
    wrist = Wrist.deviation()
    loop, state = wrist.hysteresis, wrist.rest(start, 0.0 if start == "virgin" else 2.0)
    problem = TimeOptimalProblem(wrist, state, 15.0 * sign, sign, 100)
    ways = np.array([0.0, 3.0, 20.0, 45.0, 90.0])
    for turn in float(state.pressure) + sign * ways:
        there = loop.step(state.memory, state.pressure, turn)
        assert float(problem.ahead(turn)) == pytest.approx(float(there.h), abs=CORNER)
        for pressure in turn - sign * ways:
            back = loop.step(there._replace(virgin=0.0), turn, pressure)
            assert float(problem.braking(pressure, turn)) == pytest.approx(float(back.h), abs=2.0 * CORNER)


@pytest.mark.parametrize(("start", "reference"), [("line1", 10.0), ("line2", -10.0)])
def test_what_the_optimiser_sees_is_what_the_simulator_does(start, reference):
    """Commands in the range, each held; the pressure turns once; at the end the loop is at the reference."""
    wrist, turn = Wrist.flexion(), 36
    state, sign = wrist.rest(start), float(np.sign(reference))
    problem = TimeOptimalProblem(wrist, state, reference, sign, 170)
    volts, pressures, angles = _solve(problem, turn, "iae")
    assert (volts >= -1e-6).all()
    assert (volts <= 4.0 + 1e-6).all()
    assert (sign * np.diff(pressures[:turn]) >= -1e-6).all()
    assert (sign * np.diff(pressures[turn - 1 :]) <= 1e-6).all()
    simulated, there = state, []
    for v in volts:
        simulated = wrist.simulate([v] * HOLD, simulated).state
        there.append((float(simulated.pressure), float(simulated.angle), float(simulated.memory.h)))
    np.testing.assert_allclose(pressures, [p for p, _, _ in there], atol=1e-4)
    np.testing.assert_allclose(angles, [a for _, a, _ in there], atol=5.0 * CORNER)
    assert there[-1][2] == pytest.approx(reference, abs=5.0 * CORNER)
    assert there[-1][1] == pytest.approx(reference, abs=problem.band)


@pytest.mark.parametrize("goal", ["iae", "settling"])
def test_the_goal_is_the_integral_of_the_error_and_what_the_lag_leaves_at_the_end(monkeypatch, goal):
    """At the guess, whose nodes the simulator comes to; beyond the bound the band is paid for."""
    wrist, made = Wrist.flexion(), {}
    problem = TimeOptimalProblem(wrist, wrist.rest("line1"), 10.0, 1.0, 170)
    plain = casadi.nlpsol

    def noted(name, solver, nlp, options):
        made.update(nlp)
        return plain(name, solver, nlp, options | {"ipopt": options["ipopt"] | {"max_iter": 0}})

    monkeypatch.setattr(casadi, "nlpsol", noted)
    _solve(problem, 36, goal)
    n, guess = problem.nodes, _guess(problem, 36)
    response = wrist.simulate(np.repeat(guess[:n], HOLD), problem.state)
    left = np.abs(response.angle[1:] - 10.0)
    expected = 0.001 * left.sum() + wrist.Tw * abs(guess[-1] - 10.0)
    late = np.linspace(0.0, 0.3, n * HOLD - 170 + 1) if goal == "settling" else np.zeros(0)
    w = np.concatenate([guess, late])
    cost, broken = casadi.Function("made", [made["x"]], [made["f"], made["g"]])(w)
    assert float(cost) == pytest.approx(expected + WEIGHT * late.sum(), rel=5e-3)
    rows = np.array(broken).ravel()
    assert np.abs(rows[: 2 * n]).max() < 1e-9  # each hold leads from node to node
    assert (rows[2 * n : 2 * n + 36] >= -1e-9).all()  # ahead
    assert (rows[2 * n + 36 : 3 * n] <= 1e-9).all()  # and back
    if goal == "settling":
        np.testing.assert_allclose(
            rows[3 * n + 1 :][: n * HOLD], 10.0 - response.angle[1:], atol=5.0 * CORNER
        )
        inside = (10.0 - response.angle[170:]) - late
        np.testing.assert_allclose(rows[3 * n + 1 + n * HOLD :], inside, atol=5.0 * CORNER)
