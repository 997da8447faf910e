"""The requirement: its cases are what it says, its judge is the runner's, its parts can be taken away."""

from dataclasses import replace

import numpy as np
import pytest

from design.controllers.pi import PI
from design.evaluation.cases import stack
from design.evaluation.runner import play
from design.robustness.checks import check
from design.robustness.requirement import requirement
from design.robustness.samples.hunt import hunt
from design.robustness.samples.search_space import KINDS
from plants import Wrist
from plants.effects.regulator.dead_time import DeadTime
from plants.parameters.files import built_in

STATED = requirement(built_in("flexion"))
PI_ = PI.of(STATED.wrist, 2.9, 7.0)


def places(count, seed=0):
    return np.random.default_rng(seed).random((STATED.space.size, count))


def test_the_rigs_file_states_it():
    rig = built_in("flexion").rig
    assert STATED.conditions.dead_time == rig.uncertainty.dead_time[1] == 0.05
    assert STATED.limits.named == dict(rig.limits)
    assert STATED.space.kinds == KINDS


def test_cases_of_each_kind_are_asked_what_it_says():
    x = places(4000)
    asked, kind = STATED.space.asked(x), STATED.space.kind(x)
    counts = np.bincount(kind, minlength=4)
    assert counts.min() > 900
    r, h = asked["references"], asked["holds"]
    step, back, _, load = (kind == KINDS.index(k) for k in ("step", "return", "sequence", "load"))
    assert set(np.unique(r[:, step])) == {-15.0, 15.0}
    assert (h[:-1, step] == 0.0).all()
    assert set(np.unique(r[-1, back])) == {-15.0, 0.0, 15.0}
    assert (np.abs(r[-2, back]) == 15.0).all()
    assert (r[-1, back] != r[-2, back]).all()
    assert h[-2, back].min() < 0.4 < 4.0 < h[-2, back].max() <= STATED.space.hold[1]
    assert (asked["angle"][load] == r[-1, load]).all()
    assert (asked["load_at"][load] == 0.0).all()
    assert (asked["load_at"][~load] < 0.0).all()
    task = STATED.space.of_task(x)
    assert task[step].all()
    assert not task[load].any()
    assert (h[-2, task & back] >= STATED.space.calm[0]).all()


def test_a_slow_rig_is_calm_later():
    """Its file says for how long it is held; 0.6 of that is the least before a step of its task."""
    plant = built_in("flexion")
    slow = replace(plant, rig=replace(plant.rig, task=replace(plant.rig.task, hold=10.0)))
    space, x = requirement(slow).space, places(2000)
    asked, task, back = space.asked(x), space.of_task(x), space.kind(x) == KINDS.index("return")
    holds = asked["holds"][-2]
    assert holds[space.kind(x) == KINDS.index("sequence")].min() >= 6.0
    assert holds[back].min() < 0.4 < 9.0 < holds[back].max() <= 10.0
    assert task[back].any()
    assert (holds[task & back] >= 6.0).all()
    for i in np.flatnonzero(back)[:20]:
        assert space.case(x[:, i])[0].of_task == task[i]


def test_it_judges_as_each_case_alone_is_judged():
    x = places(48, 3)
    values = STATED.run(x, PI_)
    for i in range(0, 48, 5):
        case, _ = STATED.space.case(x[:, i])
        alone = play(stack([case]), PI_)
        for name, v in alone.values.items():
            assert values[name][i] == pytest.approx(v[0], rel=1e-9, abs=1e-12), (case.name, name)
        assert case.of_task == STATED.space.of_task(x[:, [i]])[0]


def test_a_load_moves_a_resting_wrist_and_the_loop_takes_it_back():
    x = places(64, 5)
    x[-1] = 0.9  # of the kind load
    settled = STATED.run(x, PI_)["settling_time_s"]
    case, _ = STATED.space.case(x[:, 0])
    asked = case.task
    went = play(stack([case]), PI_, record=True).trajectory.angle[:, 0]
    assert went[0] == asked.angle
    moved = went - asked.angle
    assert np.abs(moved).max() > 0.2 * abs(asked.load)
    assert abs(moved[-1]) < 0.02 * abs(asked.load)
    assert np.isfinite(settled).all()


def test_a_plant_that_is_known_to_be_late_keeps_its_own_dead_time_within_the_longest():
    plant = built_in("flexion").revised(
        [DeadTime], {"dead-time.delay": 0.03}, {"dead-time.delay": 0.001}, "a test"
    )
    assert requirement(plant).space.dead_time == pytest.approx(0.02)
    asked = requirement(plant, conditions=replace(STATED.conditions, dead_time=0.0))
    assert asked.space.dead_time == 0.0
    low, high = asked.box.bounds("dead-time.delay")
    assert low < 0.03 < high
    later = float(asked.margins(PI_).Ms)
    assert later > float(requirement(built_in("flexion"), conditions=replace(
        STATED.conditions, dead_time=0.0)).margins(PI_).Ms)  # fmt: skip


def test_fresh_samples_are_the_same_for_a_seed_and_any_number_of_threads():
    one, other = (check(STATED, PI_, 300, 4, jobs) for jobs in (1, 3))
    assert np.array_equal(one.excess, other.excess)
    assert not np.array_equal(one.excess, check(STATED, PI_, 300, 5).excess)


def test_gains_of_yesterday_break_it_and_it_says_so():
    """3.13, 10.4: the optimum of the task without dead time."""
    hot = check(STATED, PI.of(Wrist.flexion(), 3.13, 10.4), 2000, 1)
    assert hot.broken > 20
    assert STATED.linear_excess(PI.of(Wrist.flexion(), 3.13, 10.4))["Ms"] > 0.05


def test_a_hunt_finds_a_narrow_peak_that_chance_does_not():
    centre = np.array([0.1, 0.9, 0.5, 0.33, 0.77, 0.2])

    def height(x):
        return -np.sum(np.abs(x - centre[:, None]), axis=0)

    found = hunt(height, np.empty((6, 0)), 12_000, 0)
    assert found.heights.max() > -0.02
    assert np.random.default_rng(1).random((6, 12_000)).size == 72_000
    assert height(np.random.default_rng(1).random((6, 12_000))).max() < -0.2
    assert found.heights[found.worst(1)][0] == found.heights.max()
