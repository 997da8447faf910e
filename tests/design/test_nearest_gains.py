"""Where no gains hold every limit, the nearest are those of which all that they break is known, and least."""

from dataclasses import replace

import numpy as np

from design.margins import margins
from design.robustness.tuning.gain_search import evaluate_law, law_with
from design.robustness.tuning.nearest_gains import nearest
from design.synthesis.evaluate import Evaluation, best_of, controller, evaluate, join, simulated
from design.synthesis.requirements import Limits, default_problem
from design.synthesis.structure import PLAIN_PI
from design.synthesis.tuning import Region, Tuning
from plants import Wrist


def judged(cost, unsettled, **excess):
    n = len(cost)
    gains, nowhere = np.arange(1.0, n + 1.0), np.zeros(n, np.intp)
    beyond = {name: np.array(e) for name, e in excess.items()}
    return Evaluation(gains, gains, np.array(cost), nowhere, {}, {}, beyond, np.array(unsettled))


def test_gains_that_were_not_simulated_come_after_those_of_which_a_run_never_settles():
    """They break a limit of the linear loop by 2 %, and nobody knows what else."""
    at = judged([np.inf, 5.0, 4.0], [0, 1, 1], Ms=[0.02, -0.1, -0.1], settling_time_s=[-1.0, np.inf, np.inf])
    assert best_of(at).Kp[0] == 3.0


def test_the_fewer_runs_never_settle_the_better_whatever_the_other_limits():
    at = judged([5.0, 4.0, 4.0], [1, 7, 1], overshoot_percent=[0.1, 0.0, 0.9], settling_time_s=[np.inf] * 3)
    assert best_of(at).Kp[0] == 1.0


def test_where_all_runs_settle_the_least_excess_decides():
    at = judged([5.0, 4.0], [0, 0], overshoot_percent=[0.1, 0.0], settling_time_s=[0.2, 0.4])
    assert best_of(at).Kp[0] == 1.0


def test_gains_that_hold_every_limit_come_first_and_of_these_the_cheapest():
    at = judged([3.0, 5.0, 4.0], [0, 0, 0], overshoot_percent=[0.1, -0.1, 0.0], settling_time_s=[-0.5] * 3)
    assert best_of(at).Kp[0] == 3.0


def test_runs_that_never_settle_are_counted():
    problem = default_problem(Wrist.flexion())
    at = evaluate(problem, [1.2, 0.3], [2.2, 0.3])
    each = simulated(problem, controller(problem, np.array([1.2, 0.3]), np.array([2.2, 0.3])), 2)
    assert at.unsettled.tolist() == np.isinf(each.settling_time_s).sum(axis=1).tolist()
    assert at.unsettled[1] > 0
    assert at.only(1).unsettled.tolist() == at.unsettled[1:].tolist()
    assert join([at, at]).unsettled.tolist() == [*at.unsettled, *at.unsettled]


def tuned(Kp, Ki, **limits):
    """Gains of flexion under other limits, those of a plain PI with all its settings."""
    wrist = Wrist.flexion()
    problem = default_problem(wrist, replace(Limits.of(wrist.rig), **limits))
    law = law_with(PLAIN_PI, PLAIN_PI.settings)
    at = evaluate_law(problem, law, np.array([Kp]), np.array([Ki]))
    return Tuning(problem, Region.of(wrist), at, at, ())


def test_where_a_margin_cannot_be_held_runs_that_settle_come_before_it():
    """Gains so low that hardly a run settles, for the sake of an Ms that no gains hold."""
    slow = tuned(0.5, 0.3, Ms=1.0)
    assert not slow.feasible
    found = nearest(slow)
    assert found.at.unsettled[0] < slow.at.unsettled[0]
    each = simulated(found.problem, controller(found.problem, found.at.Kp, found.at.Ki), 1)
    assert np.isinf(each.settling_time_s).sum() == found.at.unsettled[0]
    margin = margins(found.problem.branches, controller(found.problem, found.at.Kp, found.at.Ki))
    assert margin.Ms[0] <= 2.0
    assert margin.delay_margin_s[0] >= found.problem.limits.delay_margin_s


def test_where_no_gains_within_twice_the_limits_settle_any_stable_loop_may():
    """An Ms that only gains hold with which hardly a run settles: twice its limit is 1.1."""
    slow = tuned(0.5, 0.3, Ms=0.55)
    found = nearest(slow)
    assert slow.at.unsettled[0] > found.at.unsettled[0] == 0
    margin = margins(found.problem.branches, controller(found.problem, found.at.Kp, found.at.Ki))
    assert 1.1 < margin.Ms[0] < 2.0
    assert margin.delay_margin_s[0] >= found.problem.limits.delay_margin_s


def test_nearest_gains_are_the_numbers_that_are_printed():
    for slow in (tuned(0.5, 0.3, Ms=1.0), tuned(1.23456, 2.34567, overshoot_percent=1e-6)):
        found = nearest(slow)
        assert all(float(f"{g:.3g}") == g for g in (found.Kp, found.Ki))
        assert found.at.unsettled[0] <= slow.at.unsettled[0]


def test_gains_with_which_every_run_settles_stay():
    found = tuned(1.2, 2.2, overshoot_percent=1e-6)
    assert not found.feasible
    assert found.at.unsettled[0] == 0
    assert nearest(found) is found
