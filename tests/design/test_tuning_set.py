"""Gains are tuned on every sign of the step, every memory and every corner of the plant."""

from itertools import product

import numpy as np
import pytest

from design.comparison.compare import on_tasks, step_cases
from design.controllers.pi import PI
from design.evaluation.cases import Case, stack, unreachable
from design.evaluation.scenarios import HEADROOM, STEP, Spread, corners, tuning_scenarios, within_reach
from design.evaluation.tasks import Task
from design.synthesis.evaluate import rollouts
from design.synthesis.requirements import Problem
from plants import Wrist
from plants.kernel import pytrees as tree
from plants.wrist import STARTS

AXES = ["flexion", "deviation"]
every_axis = pytest.mark.parametrize("axis", AXES)


@every_axis
def test_there_are_at_most_96_and_no_two_are_the_same(axis):
    found = tuning_scenarios(getattr(Wrist, axis)())
    assert len({s.name for s in found}) == len(found) <= 96


@every_axis
def test_every_corner_is_stepped_both_ways_from_every_memory_and_back(axis):
    w = getattr(Wrist, axis)()
    found = tuning_scenarios(w)
    assert {s.wrist for s in found} == {plant for _, plant in corners(w, Spread())}
    for name, _ in corners(w, Spread()):
        here = {(s.task.start, s.task.angle, s.task.reference) for s in found if s.plant == name}
        assert here >= set(product(STARTS, [0.0], [STEP, -STEP]))
        assert {(a, r) for _, a, r in here} >= {(STEP, 0.0), (-STEP, 0.0)}


@every_axis
def test_the_corners_are_all_signs_of_the_declared_spread(axis):
    w, spread = getattr(Wrist, axis)(), Spread(width=0.3, slope=0.05, lag=0.4)
    ratios = {
        tuple(round(plant.values[n] / w.values[n] - 1.0, 12) for n in ("w1", "a1", "Tw"))
        for _, plant in corners(w, spread)[1:]
    }
    assert ratios == set(product((0.3, -0.3), (0.05, -0.05), (0.4, -0.4)))
    for _, plant in corners(w, spread):
        assert plant.values["w2"] / w.values["w2"] == pytest.approx(plant.values["w1"] / w.values["w1"])
        assert plant.values["s"] / w.values["s"] == pytest.approx(plant.values["a2"] / w.values["a2"])


@every_axis
def test_every_corner_still_is_a_loop(axis):
    for name, plant in corners(getattr(Wrist, axis)(), Spread()):
        assert plant.hysteresis.problem(0.0, 200.0) is None, name


@every_axis
def test_the_tuning_set_is_not_the_set_of_reported_tasks(axis):
    w = getattr(Wrist, axis)()
    tuned_on = {(s.task, s.wrist) for s in tuning_scenarios(w)}
    reported = {(s.task, s.wrist) for s in step_cases(w)}
    assert tuned_on - reported
    assert {plant for _, plant in reported} == {w}
    assert len({plant for _, plant in tuned_on}) == 9
    # What tuning never sees: a return from a step that is still under way after 5 s of holding.
    (there,) = on_tasks(w, [PI(1.2, 2.2)])["return+"]
    problem = Problem.of(w, [Case(Task("line1", STEP, (0.0,)), w)])
    rested = rollouts(problem, np.array([1.2]), np.array([2.2]))
    assert abs(there.iae_deg_s - rested.iae_deg_s[0, 0]) > 1e-3


def test_corners_that_no_command_holds_are_set_aside_and_the_task_itself_never_is():
    w = Wrist.flexion()
    out = w.with_values(w1=25.0)
    scenarios = [Case(Task("virgin", 0.0, (15.0,)), out, "wide"), Case(Task("virgin", 0.0, (15.0,)), out),
                 Case(Task("virgin", 0.0, (15.0,)), w, "as it is")]  # fmt: skip
    kept, aside = within_reach(scenarios)
    assert ([s.plant for s in kept], [s.plant for s in aside]) == (["nominal", "as it is"], ["wide"])
    problem = Problem.of(w, scenarios, duration=1.0)
    assert (len(problem.scenarios), len(problem.set_aside)) == (2, 1)
    assert rollouts(problem, np.array([1.0, 2.0]), np.array([1.0, 2.0])).iae_deg_s.shape == (2, 2)


@every_axis
def test_stacked_scenarios_are_the_scenarios(axis):
    found = tuning_scenarios(getattr(Wrist, axis)())[5:40:7]
    lanes = stack(found)
    wrist, state, reference = lanes.wrist, lanes.state, lanes.reference.references[0]
    for i, s in enumerate(found):
        assert {n: float(v[i]) for n, v in wrist.values.items()} == s.wrist.values
        assert [float(x[i]) for x in tree.leaves(state)] == [
            float(x) for x in tree.leaves(s.wrist.rest(s.task.start, s.task.angle))
        ]
        assert reference[i] == s.task.reference


@every_axis
def test_a_rollout_of_many_gains_is_a_table_of_gains_by_scenarios(axis):
    w = getattr(Wrist, axis)()
    scenarios = tuning_scenarios(w)[::31]
    Kp, Ki = np.array([1.0, 5.0, 9.0]), np.array([2.0, 10.0, 5.0])
    table = rollouts(Problem.of(w, scenarios, duration=1.0), Kp, Ki)
    for i, j in np.ndindex(3, len(scenarios)):
        alone = rollouts(Problem.of(w, [scenarios[j]], duration=1.0), Kp[i : i + 1], Ki[i : i + 1])
        assert table.iae_deg_s[i, j] == alone.iae_deg_s[0, 0]
        assert table.overshoot_percent[i, j] == alone.overshoot_percent[0, 0]


def test_corners_that_no_command_can_hold_are_set_aside_and_the_nominal_task_never():
    wrist = Wrist.deviation().with_values(a2=0.205)
    kept, aside = within_reach(tuning_scenarios(wrist))
    assert aside
    assert all(s.plant != "nominal" for s in aside)
    for s in aside:
        assert unreachable(s, HEADROOM, 4.0 - HEADROOM) > 0.0
    assert all(s.plant == "nominal" or unreachable(s, 0.1, 3.9) == 0.0 for s in kept)
    assert HEADROOM == 0.1  # V; the README and the reports say so
