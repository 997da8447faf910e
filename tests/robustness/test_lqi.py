"""The robust LQI is what its equations say, its guarantee holds, and its margins are those of the loop."""

from functools import cache

import numpy as np
import pytest

from design.alternatives.lqi_design import RobustLQI, design_lqi, judge
from design.alternatives.lqi_synthesis import LQIWeights, checked, plant, synthesise, vertices
from design.controllers.controller import Measured
from design.controllers.lqi import LQI, step
from design.controllers.pi import PI
from design.evaluation.cases import Case
from design.evaluation.steps import holding, run
from design.evaluation.tasks import Task
from design.input_loop import InputLoop, closed, worst_pole
from design.margins import branch_responses
from design.synthesis.convex import Unsolved
from design.synthesis.requirements import Limits, Problem
from plants import Wrist
from plants.effects import Creep, DeadTime
from tests.oracles.plain_loop import Plant

WRIST = Wrist.flexion()
TYPICAL = LQI(Ke=600.0, Kd=-640.0, Kq=-70.0, jump=8.0, slope=0.36, Tw=0.16, bandwidth=45.0)
MILD = LQI(Ke=50.0, Kd=-50.0, Kq=-14.0, jump=3.5, slope=0.2, Tw=0.16, bandwidth=20.0)
WEIGHTS = LQIWeights(damping=2.0, lack=4e-3, effort=1e-4)


def one_branch(rate: float = 9.0) -> Wrist:
    """A wrist without hysteresis: one slope everywhere, no width, one regulator rate."""
    return WRIST.with_values(s=0.36, a1=0.36, a2=0.36, w1=1e-9, w2=1e-9, k_slow=rate, k_fast=rate)


def test_a_PI_is_the_special_case_that_it_is_said_to_be():
    Kp, Ki = 3.0, 10.0
    w = one_branch()
    as_lqi = LQI(Ki, -Kp / 0.16, 0.0, Kp, 0.36, 0.16, 40.0)
    start = w.rest("line1", 0.0)
    _, _, one = run(w, PI(Kp, Ki), 5.0, start, record=True, duration=5.0)
    _, _, other = run(w, as_lqi, 5.0, start, record=True, duration=5.0)
    assert np.abs(one.angle - other.angle).max() < 0.005 * 5.0
    assert np.abs(one.angle - other.angle).max() < 0.1 * np.abs(one.angle - 5.0).max()


@pytest.mark.parametrize("controller", [TYPICAL, MILD])
@pytest.mark.parametrize(
    ("start", "angle", "reference"), [("virgin", 0.0, 15.0), ("line1", 15.0, 0.0), ("inside", 0.0, -15.0)]
)
def test_the_compiled_loop_is_the_one_of_a_page_of_plain_python(controller, start, angle, reference):
    state = WRIST.rest(start, angle)
    _, _, t = run(WRIST, controller, reference, state, duration=2.0, record=True)
    page = Plant(WRIST.values, float(state.pressure), angle, start == "virgin")
    c, dt, b = controller, 0.001, controller.bandwidth
    u = P0 = float(state.pressure)
    h = y = angle
    lack, r0 = 0.0, angle
    keep = np.exp(-dt / c.Tw)
    mean = (1.0 - keep) * c.Tw / dt
    ly = 1.0 - np.exp(-2.0 * b * dt) / keep
    lh = (keep * (1.0 - ly) + 1.0 - 2.0 * np.exp(-b * dt)) / (1.0 - keep)
    angles, commands = [], []
    for _ in range(2000):
        P, seen = page.P, page.y
        ahead = h + c.slope * (P - P0)
        guess = keep * y + (mean - keep) * h + (1.0 - mean) * ahead
        h, y = ahead + lh * (seen - guess), guess + ly * (seen - guess)
        q = u - P
        lack += (1.0 - np.exp(-c.washout * dt)) * (q - lack)
        u += c.jump * (reference - r0)
        u += dt * (c.Ke * (reference - seen) + c.Kd * (h - y) + c.Kq * (q - lack))
        u = min(max(u, 0.0), 4.0 * c.gain)
        P0, r0 = P, reference
        angles.append(seen)
        commands.append(u / c.gain)
        page.move(u / c.gain)
    np.testing.assert_allclose(t.angle[:-1, 0], angles, rtol=0, atol=1e-8)
    np.testing.assert_allclose(t.command[:-1, 0], commands, rtol=0, atol=1e-8)


def test_where_the_observer_knows_the_slope_its_poles_stand_by_themselves():
    pole = np.exp(-TYPICAL.bandwidth * 0.001)
    for branch, known in (("line1", True), ("transit", False)):
        poles = np.linalg.eigvals(closed(WRIST, TYPICAL, branch, "fast"))
        near = np.sort(np.abs(poles - pole))[:2]
        assert bool((near < 1e-5).all()) == known


def continuous(c: LQI, slope: float, rate: float, Tw: float | None = None) -> tuple[object, object]:
    """The equations of the module as continuous systems of python-control: the controller from angle
    and pressure to the command [kPa], written down from the text, and the plant, whose lag is the
    controller's where none is given."""
    import control

    b, T, g = c.bandwidth, c.Tw, c.washout
    lh, ly = b * b * T, 2.0 * b - 1.0 / T
    # States z = h' - slope P, y', lack, u.  h' = z + slope P.
    a = np.array([
        [0.0, -lh, 0.0, 0.0],
        [1.0 / T, -1.0 / T - ly, 0.0, 0.0],
        [0.0, 0.0, -g, g],
        [c.Kd, -c.Kd, -c.Kq, c.Kq],
    ])  # fmt: skip
    into = np.array([
        [lh, 0.0],
        [ly, c.slope / T],
        [0.0, -g],
        [-c.Ke, c.Kd * c.slope - c.Kq],
    ])  # fmt: skip
    controller = control.ss(a, into, np.eye(4)[3:], np.zeros((1, 2)))
    lag = T if Tw is None else Tw
    air_and_lag = control.ss(
        [[-rate, 0.0], [slope / lag, -1.0 / lag]],
        [[rate], [0.0]],
        [[0.0, 1.0], [1.0, 0.0]],
        np.zeros((2, 1)),
    )
    return controller, air_and_lag


@pytest.mark.slow
@pytest.mark.parametrize("controller", [TYPICAL, MILD])
def test_margins_and_poles_are_those_of_python_control(controller):
    import control

    branches = branch_responses(WRIST)
    broken = InputLoop.at_command(controller, branches)
    slopes = {"transit": 0.0803, "line1": 0.36, "line2": 0.36}
    rates = {"slow": WRIST.regulator.k_slow, "fast": WRIST.regulator.k_fast}
    Ms, delay, pole, noise = 0.0, np.inf, -np.inf, 0.0
    omega = np.geomspace(0.01, 300.0, 4001)
    for i, b in enumerate(branches):
        law, wrist = continuous(controller, slopes[b.branch], rates[b.rate])
        loop = -law * wrist
        of = control.frequency_response(loop, omega).complex
        seen = np.interp(omega, b.omega, np.abs(broken.open[i]))
        slow = omega < 30.0
        np.testing.assert_allclose(np.abs(of[slow]), seen[slow], rtol=0.06)
        Ms = max(Ms, np.abs(1.0 / (1.0 + of)).max())
        noise = max(noise, np.abs(control.frequency_response(law, omega).complex[0, 0] / (1.0 + of)).max())
        _, pm, _, _, wc, _ = control.stability_margins(control.frd(of, omega, smooth=True), returnall=True)
        delay = min(delay, *(np.radians(np.mod(pm, 360.0)) / wc), np.inf)
        poles = control.feedback(control.ss(loop), 1).poles()
        pole = max(pole, poles.real.max())
    found = broken.margins(branches)
    assert float(found.Ms) == pytest.approx(Ms, rel=0.02)
    assert float(found.delay_margin_s) == pytest.approx(delay, rel=0.03)
    assert broken.noise_gain == pytest.approx(noise / 49.4, rel=0.05)
    slowest, where = worst_pole(WRIST, controller)
    assert np.log(slowest) / 0.001 == pytest.approx(pole, rel=0.01)
    assert where == "transit, slow regulator rate"


def test_an_unstable_loop_has_no_margins():
    backwards = LQI(600.0, 640.0, -1.0, 8.0, 0.36, 0.16, 45.0)
    branches = branch_responses(WRIST)
    assert worst_pole(WRIST, backwards)[0] > 1.0
    found = InputLoop.at_command(backwards, branches).margins(branches)
    assert (float(found.Ms), float(found.delay_margin_s)) == (np.inf, 0.0)


def test_dead_time_of_the_tube_comes_off_the_delay_margin_and_absent_effects_change_nothing():
    def delay(wrist: Wrist) -> float:
        branches = branch_responses(wrist)
        return float(InputLoop.at_command(TYPICAL, branches).margins(branches).delay_margin_s)

    plain = delay(WRIST)
    assert delay(WRIST + Creep(gain=0.0, time_constant=3.0)) == pytest.approx(plain, rel=1e-6)
    assert plain - delay(WRIST + DeadTime(delay=0.04)) == pytest.approx(0.04, rel=1e-3)


def test_a_plant_whose_riccati_equation_no_solver_solves_has_no_feedback():
    """It ended `wrist design` with an error of the program, after all of its tuning."""
    slope, rate = 1.2867677534034448e-08, 0.3591890630058911
    w = one_branch(rate).with_values(s=slope, a1=slope, a2=slope, Tw=2.9633314005807476e-05)
    weights = LQIWeights(damping=3.700854698718055, lack=0.008259308539982548, effort=8.290190200605021)
    with pytest.raises(Unsolved, match="Riccati"):
        synthesise(w, weights)


def test_with_one_vertex_the_feedback_is_the_linear_quadratic_regulator():
    import control

    w = one_branch()
    assert vertices(w) == [(0.36, 9.0)]
    found = synthesise(w, WEIGHTS)
    K, P, _ = control.lqr(plant(0.36, 9.0, 0.16), [[0.0], [0.0], [1.0]], WEIGHTS.matrix, WEIGHTS.effort)
    np.testing.assert_allclose(found.gains, -K[0], rtol=2e-3)
    np.testing.assert_allclose(found.bound[0, 0], P[0, 0], rtol=1e-3)
    assert found.holds


@pytest.mark.parametrize("axis", ["flexion", "deviation"])
def test_the_cost_is_bounded_whatever_the_order_of_branches_and_rates(axis):
    from scipy.linalg import expm

    w = getattr(Wrist, axis)()
    found = synthesise(w, WEIGHTS)
    assert found.holds
    assert found.decay > 0.0
    price = WEIGHTS.matrix + WEIGHTS.effort * np.outer(found.gains, found.gains)
    dt, draw = 0.002, np.random.default_rng(1)
    a = [plant(*v, w.Tw) + np.outer([0.0, 0.0, 1.0], found.gains) for v in vertices(w)]
    moves = [expm(x * dt) for x in a]
    for x in (np.array([15.0, 0.0, 15.0 * found.jump]), *draw.standard_normal((3, 3))):
        bound, cost, size = x @ found.bound @ x, 0.0, [x @ found.bound @ x]
        for k in range(4000):
            if k % 20 == 0:  # the vertex that P sees fall least, the worst of the greedy orders, or any
                falls = [x @ (m.T @ found.bound + found.bound @ m) @ x for m in a]
                which = int(np.argmax(falls)) if draw.random() < 0.7 else int(draw.integers(len(a)))
            after = moves[which] @ x
            cost += 0.5 * dt * (x @ price @ x + after @ price @ after)
            x = after
            size.append(x @ found.bound @ x)
        assert cost <= bound * 1.001
        assert cost > 0.05 * bound  # the bound is one of this loop, not of any
        assert size[-1] <= size[0] * np.exp(-2.0 * found.decay * 4000 * dt) * 1.001


def test_what_does_not_fall_at_a_vertex_is_not_confirmed():
    corners = tuple(vertices(WRIST))
    good = synthesise(WRIST, WEIGHTS)
    assert checked(corners, 0.16, WEIGHTS, good.gains, good.bound, "x").holds
    assert not checked(corners, 0.16, WEIGHTS, -good.gains, good.bound, "x").holds
    assert not checked(corners, 0.16, WEIGHTS, good.gains, np.eye(3), "x").holds
    assert not checked(corners, 0.16, WEIGHTS, good.gains, -good.bound, "x").holds


def test_an_unknown_gain_of_the_regulator_leaves_no_steady_error():
    off = WRIST.with_values(gain=47.5)
    _, last, _ = run(off, TYPICAL, 15.0, duration=25.0)
    assert abs(float(last.plant.angle[0]) - 15.0) < 0.02
    never = LQI(**{**vars(TYPICAL), "washout": 0.0})
    _, last, _ = run(off, never, 15.0, duration=25.0)
    assert abs(float(last.plant.angle[0]) - 15.0) > 0.2


def test_it_holds_still_where_it_is_told_to_hold():
    for wrist in (WRIST, WRIST.with_values(gain=47.5)):
        state = wrist.rest("line1", 10.0)
        held = holding(wrist, TYPICAL, state)
        assert TYPICAL.command(held) * wrist.regulator.gain == pytest.approx(state.pressure, rel=1e-12)
        _, last, t = run(wrist, TYPICAL, 10.0 + 1e-9, state, duration=1.0, record=True)
        assert np.abs(t.angle - 10.0).max() < 1e-7
        assert float(last.plant.pressure[0]) == pytest.approx(state.pressure, abs=1e-5)


def test_the_clipped_command_does_not_wind_up():
    c = TYPICAL.sampled()
    state = TYPICAL.holding(150.0, Measured(0.0, 0.0, 150.0))
    for _ in range(500):  # far below the reference, at the end of the range
        state, command = step(state, Measured(40.0, 0.0, 150.0), c)
        assert 0.0 <= command <= 4.0 * (1.0 + 1e-12)
    assert command == pytest.approx(4.0)
    state, command = step(state, Measured(-5.0, 45.0, 150.0), c)
    assert command < 4.0


@pytest.mark.parametrize("wrong", [{"Ke": 0.0}, {"bandwidth": -1.0}, {"Kd": np.nan}, {"slope": 0.0}])
def test_settings_that_make_no_controller_are_refused(wrong):
    with pytest.raises(ValueError, match="must be"):
        LQI(**{**vars(TYPICAL), **wrong})


def small(limits: Limits) -> Problem:
    runs = [Case(Task(start, 0.0, (15.0,)), WRIST) for start in ("virgin", "line2")]
    runs.append(Case(Task("line1", 15.0, (0.0,)), WRIST))
    return Problem.of(WRIST, runs, limits, duration=5.0)


@cache
def designed() -> RobustLQI:
    return design_lqi(small(Limits()))


@pytest.mark.slow
def test_the_design_holds_every_limit_on_the_scenarios_one_by_one():
    found = designed()
    assert found.breaks == ()
    assert found.choice.feedback.holds
    assert found.pole is not None
    assert found.pole[0] < 1.0
    worst = 0.0
    for s in found.problem.scenarios:
        judged, _, _ = run(
            s.wrist,
            found.controller,
            s.task.reference,
            s.wrist.rest(s.task.start, s.task.angle),
            duration=5.0,
        )
        assert float(judged.overshoot_percent[0]) <= 5.0
        assert float(judged.total_variation_V[0]) <= 16.0
        assert float(judged.steady_state_error_deg[0]) <= 0.02 * 15.0
        worst = max(worst, float(judged.iae_deg_s[0]))
    assert float(found.at.cost[0]) == pytest.approx(worst, rel=1e-12)


@pytest.mark.slow
def test_the_design_is_the_least_of_its_neighbours_that_hold_the_limits():
    found = designed()
    near = [
        LQI(**{**vars(found.controller), name: getattr(found.controller, name) * factor})
        for name in ("bandwidth", "jump")
        for factor in (0.5, 2.0)
    ]
    at = judge(found.problem, [found.controller, *near])
    assert at.cost[0] == found.at.cost[0]
    assert float(at.merit[0]) <= 1.1 * float(at.merit.min())


@pytest.mark.slow
def test_where_no_member_of_the_family_holds_the_limits_the_broken_one_is_named():
    found = design_lqi(small(Limits(total_variation_V=0.2)), generations=3)
    assert "total_variation_V" in found.breaks
    assert float(found.at.excess["total_variation_V"][0]) > 0.0
