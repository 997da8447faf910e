"""Each failure (infeasible, late, raised, no number from a sensor) takes the next rung of the ladder, without
a jump of the command into the PI, and the loop recovers when the QP solves again."""

from dataclasses import replace
from itertools import count

import numpy as np
import pytest

from design.controllers.controller import Measured
from design.mpc import fallback, qp
from design.mpc.fallback import BY_PI, HELD, SHIFTED, SOLVED, Fallback, Info
from design.mpc.formulations.converged import converged_mpc
from design.mpc.formulations.linear import linear_mpc
from design.mpc.formulations.real_time import JUMP, RealTimeMPC, real_time_mpc
from design.mpc.loop import run
from design.mpc.prediction import start_of
from design.mpc.problem import MPCProblem, nominal
from design.mpc.timing import ledger
from plants import Wrist
from plants.kernel import pytrees as tree

PROBLEM = MPCProblem(Wrist.flexion())


def resting(start):
    return Measured(0.0, 0.0, float(Wrist.flexion().rest(start).pressure))


FAILURES = {
    "infeasible": lambda x, active: qp.QPSolution(x, active, False, 3, "infeasible"),
    "no number": lambda x, active: qp.QPSolution(x * np.nan, active, True, 3, ""),
}


class Broken:
    """A solver that fails between two of its calls."""

    def __init__(self, solve, first, last, how):
        self.solve, self.first, self.last, self.how, self.calls = solve, first, last, how, 0

    def __call__(self, H, f, low, high, active):
        self.calls += 1
        if self.first <= self.calls <= self.last:
            return self.how(f, active)
        return self.solve(H, f, low, high, active)


def broken(make, first, last, how):
    controller = make(PROBLEM)
    if make is linear_mpc:
        bad = Broken(controller.planner.solve, first, last, how)
        return replace(controller, planner=controller.planner._replace(solve=bad))
    return replace(controller, solve=Broken(controller.solve, first, last, how))


def raises(f, active):
    raise ValueError("out of order")


@pytest.mark.parametrize("make", [linear_mpc, real_time_mpc])
@pytest.mark.parametrize("how", [*FAILURES.values(), raises], ids=[*FAILURES, "raised"])
def test_a_solver_that_fails_for_a_while_is_bridged(make, how):
    play = run(Wrist.flexion(), broken(make, 5, 19, how), 15.0, duration=4.0)
    rungs = [i.rung for i in play.periods]
    assert rungs[:4] == [SOLVED] * 4
    assert rungs[4:9] == [SHIFTED] * 5
    assert rungs[9:19] == [BY_PI] * 10
    assert rungs[19:] == [SOLVED] * (len(rungs) - 19)
    assert all(i.reason for i in play.periods[4:19])
    assert float(play.metrics.steady_state_error_deg[0]) < 1e-3


def test_the_pi_takes_over_without_a_jump():
    controller = broken(real_time_mpc, 4, 10**6, FAILURES["infeasible"])
    play = run(Wrist.flexion(), controller, 15.0, duration=1.0, record=True)
    rungs = [i.rung for i in play.periods]
    first = rungs.index(BY_PI)
    commands = play.trajectory.command[::20, 0]
    # Bumpless: the first command of the PI is the one before it.
    assert commands[first] == pytest.approx(commands[first - 1], abs=1e-12)
    assert np.ptp(commands[first:-1]) > 1e-3


def test_a_shifted_plan_is_what_was_planned():
    """On the plant that is believed in, carrying on with the plan reaches where the plan said."""
    good = real_time_mpc(PROBLEM)
    state = good.init(resting("line1"))
    state, _, _ = good.step(state, Measured(15.0, 0.0, state.believed.plant.pressure))
    ahead = state.plan
    bad = replace(good, solve=Broken(good.solve, 1, 10**6, FAILURES["infeasible"]))
    for k in range(3):
        state, command, info = bad.step(state, Measured(15.0 - k, float(k), 130.0))
        assert info.rung == SHIFTED
        assert command == pytest.approx(ahead[k], abs=1e-12)


@pytest.mark.parametrize("patience", [0, 1, 3])
def test_a_shifted_plan_goes_on_for_as_many_periods_as_there_is_patience(patience):
    controller = linear_mpc(PROBLEM, Fallback(patience=patience))
    bad = Broken(controller.planner.solve, 3, 10, FAILURES["infeasible"])
    failing = replace(controller, planner=controller.planner._replace(solve=bad))
    rungs = [i.rung for i in run(Wrist.flexion(), failing, 15.0, duration=0.2).periods]
    assert rungs[:2] == [SOLVED] * 2
    assert rungs[2 : 2 + patience] == [SHIFTED] * patience
    assert rungs[2 + patience : 10] == [BY_PI] * (8 - patience)


@pytest.mark.parametrize("make", [linear_mpc, real_time_mpc])
def test_a_late_answer_is_not_used(make):
    slow = count(0, 30_000_000)  # every look at the clock, 30 ms have gone
    controller = make(PROBLEM, Fallback(budget=0.01, patience=2, clock=lambda: next(slow)))
    state = controller.init(resting("virgin"))
    state, command, info = controller.step(state, Measured(5.0, 0.0, 100.0))
    assert info.rung == BY_PI
    assert info.reason == "late"
    assert command == pytest.approx(100.0 / 49.4, abs=1e-12)
    in_time = make(PROBLEM, Fallback(budget=0.01, patience=2, clock=lambda: 0))
    assert in_time.step(state, Measured(5.0, 0.0, 100.0))[2].rung == SOLVED


@pytest.mark.parametrize("make", [linear_mpc, real_time_mpc])
@pytest.mark.parametrize("lost", ["angle", "pressure", "both"])
def test_a_sensor_without_a_number_is_bridged(make, lost):
    controller, wrist = make(PROBLEM), Wrist.flexion()
    c, plant_state = wrist.sampled(), wrist.rest("line1")
    state, rungs = controller.init(resting("line1")), []
    from plants.dynamics import step

    for k in range(100):
        P, y = float(plant_state.pressure), float(plant_state.angle)
        gone = 10 <= k < 40
        P = np.nan if gone and lost != "angle" else P
        y = np.nan if gone and lost != "pressure" else y
        state, command, info = controller.step(state, Measured(12.0 - y, y, P))
        rungs.append(info.rung)
        assert 0.0 <= command <= 4.0
        for _ in range(20):
            plant_state = step(plant_state, command, c)
    below = BY_PI if lost == "pressure" else HELD
    assert rungs == [SOLVED] * 10 + [SHIFTED] * 5 + [below] * 25 + [SOLVED] * 60
    assert float(plant_state.angle) == pytest.approx(12.0, abs=1e-3)


def test_the_command_keeps_range_and_rate_on_every_rung():
    problem = MPCProblem(Wrist.flexion(), rate=0.3)
    controller = fallback_often(real_time_mpc(problem))
    play = run(Wrist.flexion(), controller, 15.0, duration=2.0, record=True)
    commands = np.concatenate([[100.0 / 49.4], play.trajectory.command[::20, 0]])
    assert np.abs(np.diff(commands)).max() <= 0.3 + 1e-12
    assert commands.min() >= 0.0
    assert commands.max() <= 4.0
    assert {i.rung for i in play.periods} == {SOLVED, SHIFTED, BY_PI}


def fallback_often(controller):
    every = count()

    def solve(H, f, low, high, active):
        if next(every) % 12 < 8:
            return FAILURES["infeasible"](f, active)
        return controller.solve(H, f, low, high, active)

    return replace(controller, solve=solve)


def test_a_step_changes_nothing_that_it_was_given():
    controller = real_time_mpc(PROBLEM)
    state = controller.init(resting("line1"))
    state, _, _ = controller.step(state, Measured(15.0, 0.0, 116.7))
    first = controller.step(state, Measured(14.0, 1.0, 130.0))
    controller.step(first[0], Measured(10.0, 5.0, 150.0))
    again = controller.step(state, Measured(14.0, 1.0, 130.0))
    assert again[1] == first[1]
    assert again[2].rung == fallback.SOLVED


def test_the_ledger_counts_each_rung_and_each_step_that_took_longer_than_the_period():
    taken = [(SOLVED, 9.0), (SOLVED, 0.5), (SHIFTED, 0.4), (SOLVED, 1.5), (HELD, 0.1), (SHIFTED, 0.2)]
    infos = [Info(rung, "", 0, 0, int(periods * 2e7), 0) for rung, periods in taken]
    found = ledger(infos, 0.02, leave_out=1)
    assert found.rungs == {SOLVED: 2, SHIFTED: 2, HELD: 1}
    assert (found.steps, found.misses) == (5, 1)
    assert found.total.most == pytest.approx(0.03)


@pytest.mark.parametrize(
    ("virgin", "angle", "stuck"), [(1.0, 0.0, True), (0.0, 0.0, False), (1.0, 15.0, False)]
)
def test_a_plan_is_stuck_that_ends_on_the_virgin_curve_away_from_the_reference(virgin, angle, stuck):
    """All but the end of the plan is on the virgin curve, far from where it should be."""
    controller = real_time_mpc(PROBLEM)
    believed = controller.init(Measured(0.0, 0.0, 100.0)).believed
    about = controller._linearised(believed, np.full(PROBLEM.horizon, 100.0 / 49.4))
    names = tree.names(believed.plant)
    states = np.tile(start_of(believed), (PROBLEM.horizon, 1))
    assert states[0, names.index("memory.virgin")] == 1.0
    states[-1, [names.index("memory.virgin"), names.index("angle")]] = virgin, angle
    assert controller._stuck(about._replace(states=states), believed, 15.0) is stuck


class Noted:
    """A clock of which every look takes so much longer than the one before, and who looked."""

    def __init__(self):
        self.now, self.took = 0, 0

    def __call__(self):
        self.took += 1_000
        self.now += self.took
        return self.now


@pytest.mark.parametrize("make", [linear_mpc, real_time_mpc, converged_mpc])
def test_the_times_of_a_period_add_up_to_it(make):
    clock = Noted()
    controller = make(replace(PROBLEM, horizon=6), Fallback(clock=clock))
    state = controller.init(resting("virgin"))
    begun = clock.now
    _, _, info = controller.step(state, Measured(5.0, float("nan"), 100.0))
    assert info.solve_ns == 0  # nothing was solved
    assert info.preparation_ns + info.wrapper_ns == info.total_ns < clock.now - begun
    for _ in range(3):
        begun = clock.now + clock.took + 1_000
        state, _, info = controller.step(state, Measured(5.0, 0.0, 100.0))
        assert info.total_ns == clock.now - begun
        assert info.preparation_ns == clock.took  # between its last two looks
        assert min(info.preparation_ns, info.solve_ns, info.wrapper_ns) > 0
        assert info.preparation_ns + info.solve_ns + info.wrapper_ns == info.total_ns


def test_the_next_period_is_prepared_where_this_one_was_solved_and_only_there():
    controller = broken(real_time_mpc, 2, 2, FAILURES["infeasible"])
    state, prepared = controller.init(resting("line1")), []
    for _ in range(3):
        state, _, info = controller.step(state, Measured(5.0, 0.0, state.believed.plant.pressure))
        prepared.append((info.rung, state.prepared is not None))
    assert prepared == [(SOLVED, True), (SHIFTED, False), (SOLVED, True)]


@pytest.mark.parametrize("make", [linear_mpc, real_time_mpc])
def test_a_plan_is_as_long_as_the_horizon_however_often_it_is_shifted(make):
    """Its end is held: what was planned last goes on."""
    controller = make(PROBLEM)
    state = controller.init(resting("line1"))
    state, _, info = controller.step(state, Measured(15.0, 0.0, state.believed.plant.pressure))
    assert info.rung == SOLVED
    whole = np.atleast_2d(state.plan)
    assert whole.shape[-1] == PROBLEM.horizon
    plan = state.plan
    for k in range(1, PROBLEM.horizon + 3):
        _, plan = controller.resume(plan, state.believed, state.command)
        end = np.repeat(whole[:, -1:], min(k, PROBLEM.horizon), axis=1)
        np.testing.assert_array_equal(np.atleast_2d(plan), np.hstack([whole[:, k:], end]))


def test_a_plan_is_begun_afresh_where_the_reference_jumps_and_only_there(monkeypatch):
    """The first of all is, there being no reference before."""
    begun, really = [], RealTimeMPC.start_plan
    monkeypatch.setattr(RealTimeMPC, "start_plan", lambda *a: begun.append(1) or really(*a))
    controller = real_time_mpc(PROBLEM)
    state, counts = controller.init(resting("line1")), []
    for reference in (5.0, 5.0, 5.0 + 0.9 * JUMP, 5.0, 5.0 + 1.1 * JUMP, 15.0, 15.0, 5.0):
        plant = state.believed.plant
        seen = Measured(reference - plant.angle, plant.angle, plant.pressure)
        state, _, info = controller.step(state, seen)
        assert info.rung == SOLVED
        counts.append(len(begun))
    assert np.diff(counts, prepend=0).tolist() == [1, 0, 0, 0, 1, 1, 0, 1]


@pytest.mark.parametrize("make", [linear_mpc, real_time_mpc])
def test_the_pi_of_another_rig_begins_without_a_jump_there_too(make):
    """A regulator of 20 kPa/V with commands to 10 V: the built-in PI would end at 4 V."""
    bare = Wrist.flexion()
    wrist = replace(
        bare, regulator=replace(bare.regulator, gain=20.0), rig=replace(bare.rig, command_range=(0.0, 10.0))
    )
    controller = make(nominal(wrist))
    state = controller.init(Measured(0.0, 3.0, 150.0))
    for _ in range(8):
        before = state.command
        state, command, info = controller.step(state, Measured(0.0, 3.0, np.nan))
    assert info.rung == BY_PI
    assert before == pytest.approx(7.5, abs=0.3)
    assert command == pytest.approx(before, abs=0.1)
